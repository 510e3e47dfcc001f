//! Stages that make objects with boxes of the foreground, by the cells that its points lie in.

use crate::detector::{DetectorOutput, DropReason, DroppedCluster};
use crate::drawn::blobs::{cut_borders, merge_graph, object_cells};
use crate::drawn::fitted_boxes::fitted_boxes;
use crate::drawn::point_clusters::point_clusters;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::outline::Outline;
use crate::pipeline::frame::{Blobs, Frame};
use crate::pipeline::stage_list::Stage;
use crate::point_cloud::PointCloud;
use crate::segment::connected_components::{ConnectedComponentsParams, connected_components};
use crate::segment::dense_separation::DenseSeparation;
use crate::stage;
use crate::stage_product::{Shape, StageProduct};

/// Sorts the foreground into dense cells.
///
/// Paper: HG section 3.
pub fn fill_dense_level(_: &PointCloud, frame: &mut Frame<Blobs>, _: &mut DetectorOutput) {
    let Frame { grid, clustering: Blobs { foreground, dense, .. }, .. } = frame;
    dense.fill(grid, foreground.cells(), foreground.point_indices());
}

/// Links coarse cells that belong together.
///
/// Paper: HG section 3.2, merging indicator ψ.
pub fn merge(params: ConnectedComponentsParams) -> impl Stage<Blobs> {
    move |_: &PointCloud, frame: &mut Frame<Blobs>, _: &mut DetectorOutput| {
        let Frame { grid, clustering: Blobs { dense, links, .. }, .. } = frame;
        connected_components(grid, dense, &params, links);
    }
}

/// Cuts links along gaps between dense cells, and gathers the points of the objects that remain.
///
/// Paper: HG section 3.2, third step, and section 4.
impl Stage<Blobs> for DenseSeparation {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<Blobs>, _: &mut DetectorOutput) {
        let Frame { grid, clustering, .. } = frame;
        let Blobs { foreground, dense, links, object_of_dense, object_points } = clustering;
        self.separate(grid, dense, links);
        object_of_dense.clear();
        object_of_dense.extend_from_slice(self.object_of_dense());
        object_points.fill(cloud, foreground.point_indices(), dense, object_of_dense, self.n_parts());
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<Blobs>) -> Vec<StageProduct> {
        let Frame { grid, clustering: Blobs { dense, object_points, .. }, .. } = frame;
        let product = |name, shape| StageProduct { stage: stage::SEPARATION, name, shape };
        vec![
            linked_blocks(frame, self.cut_links()),
            product("dense_cells", object_cells(grid, dense, object_points)),
            product("cuts", cut_borders(grid, dense, self.cut_links())),
            product("clusters", object_clusters(cloud, frame)),
        ]
    }
}

/// The coarse cells that merging linked; `cut_links` are the links that were cut.
pub fn linked_blocks(frame: &Frame<Blobs>, cut_links: &[[u32; 2]]) -> StageProduct {
    let shape = merge_graph(&frame.grid, &frame.clustering.dense, &frame.clustering.links, cut_links);
    StageProduct { stage: stage::MERGE, name: "links", shape }
}

/// The object of every point of `cloud`, the latest scan.
pub fn object_clusters(cloud: &PointCloud, frame: &Frame<Blobs>) -> Shape {
    let points = &frame.clustering.object_points;
    let points_of = |object_idx| points.point_indices(object_idx).iter().copied();
    point_clusters(cloud.len(), (0..points.n_objects()).map(points_of))
}

/// Fits boxes to the outlines of objects of enough points.
///
/// Paper: VM section 4.
pub struct OutlineBoxes {
    least_points: usize,
    outline: Outline,
    box_fit: ConvexHullBox,
}

impl OutlineBoxes {
    /// Boxes of objects of at least `least_points` to the outlines that `outline` finds.
    pub fn new(outline: Outline, least_points: usize) -> Self {
        Self { least_points, outline, box_fit: ConvexHullBox::default() }
    }
}

impl Stage<Blobs> for OutlineBoxes {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<Blobs>, output: &mut DetectorOutput) {
        let Frame { grid, clustering, fitted, .. } = frame;
        let Blobs { dense, object_of_dense, object_points, .. } = clustering;
        self.outline.mark(grid, dense, object_of_dense);
        fitted.clear();
        for object_idx in 0..object_points.n_objects() {
            let points = object_points.points(object_idx);
            let n_points = points.len();
            if n_points < self.least_points {
                output.dropped_clusters.push(DroppedCluster { n_points, reason: DropReason::TooFewPoints });
                continue;
            }
            let z_range_m = self.outline.gather(points);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let point_indices = object_points.point_indices(object_idx).iter().copied();
            let points = point_indices.zip(points.iter().map(|it| it.position_m));
            fitted.add(points, bounding_box, self.box_fit.hull_m());
        }
    }

    fn products(&self, _: &PointCloud, frame: &Frame<Blobs>) -> Vec<StageProduct> {
        fitted_boxes(&frame.fitted)
    }
}
