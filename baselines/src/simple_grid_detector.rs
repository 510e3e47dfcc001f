//! The ablation of the hierarchical grid: the same detector without its dense level.

use detector::detector::DetectorOutput;
use detector::fit::outline::Outline;
use detector::params::HierarchicalParams;
use detector::pipeline::blob_stages::{OutlineBoxes, fill_dense_level, linked_blocks, object_clusters};
use detector::pipeline::foreground_stages::foreground_stages;
use detector::pipeline::frame::{Blobs, Frame};
use detector::pipeline::object_stages::{ObjectModels, least_points, object_stages};
use detector::pipeline::stage_list::{Pipeline, Stage};
use detector::segment::connected_components::{ConnectedComponentsParams, connected_components};
use detector::segment::disjoint_sets::DisjointSets;
use detector::{PointCloud, StageProduct, stage};

/// Objects as connected components of coarse cells, for a sensor `sensor_height_m` above the road.
///
/// Terrain, cell classes, foreground, merging of cells, boxes and classes are those of the hierarchical detector, whose
/// parameters are `shared`; blobs are not separated. The grid has one level: each coarse cell holds a single dense cell, so
/// ξ is 1 whatever the parameters say. The models are those of [`object_stages`].
///
/// Paper: HG section 3.2 and Fig. 7, the *Simple Grid Model*; boxes as VM section 4.
pub fn simple_grid(
    shared: &HierarchicalParams,
    models: ObjectModels,
    sensor_height_m: f32,
) -> Pipeline<Blobs> {
    let mut shared = shared.clone();
    shared.grid.xi = 1;
    let max_height_difference_m = shared.grouping.gaps.max_height_difference_m;
    let params = ConnectedComponentsParams { max_height_difference_m };
    let least_points = least_points(&shared.cluster, models.vehicles.as_ref());
    let front_end = shared.front_end();
    let stages = foreground_stages(&front_end)
        .then(stage::MERGE, MergedCells { params, blobs: DisjointSets::default() })
        .then(stage::BOXES, OutlineBoxes::new(Outline::new(shared.grid.xi, 1), least_points))
        .and(object_stages(&shared, models));
    let frame = Frame::new(Blobs::new(&front_end), &front_end, sensor_height_m);
    Pipeline { name: "simple-grid", frame, stages }
}

/// Merges cells to blobs.
struct MergedCells {
    params: ConnectedComponentsParams,
    blobs: DisjointSets,
}

impl Stage<Blobs> for MergedCells {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<Blobs>, output: &mut DetectorOutput) {
        fill_dense_level(cloud, frame, output);
        let Frame { grid, clustering, .. } = frame;
        let Blobs { foreground, dense, links, object_of_dense, object_points } = clustering;
        connected_components(grid, dense, &self.params, links);
        let n_cells = dense.n_blocks();
        self.blobs.reset(n_cells);
        for &[cell, neighbor] in &*links {
            self.blobs.join(cell, neighbor);
        }
        object_of_dense.clear();
        object_of_dense.extend((0..n_cells as u32).map(|cell| self.blobs.representative(cell)));
        object_points.fill(cloud, foreground.point_indices(), dense, object_of_dense, n_cells);
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<Blobs>) -> Vec<StageProduct> {
        let clusters = object_clusters(cloud, frame);
        vec![
            linked_blocks(frame, &[]),
            StageProduct { stage: stage::MERGE, name: "clusters", shape: clusters },
        ]
    }
}
