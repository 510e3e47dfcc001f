//! The ablation of the hierarchical grid: the same detector without its dense level.

use std::sync::Arc;

use detector::classify::vehicle_model::VehicleModel;
use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock};
use detector::drawn::merge_graph::merge_graph;
use detector::drawn::point_clusters::point_clusters;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::fit::outline::Outline;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use detector::pipeline::object_stages::ObjectStages;
use detector::segment::clusters::Clusters;
use detector::segment::connected_components::{ConnectedComponentsParams, connected_components};
use detector::segment::dense_level::DenseLevel;
use detector::segment::disjoint_sets::DisjointSets;
use detector::segment::object_points::ObjectPoint;
use detector::whole::box_model::BoxModel;
use detector::{Detector, PointCloud, Rule, StageProduct, stage};

/// Objects as connected components of coarse cells.
///
/// Terrain, cell classes, foreground, merging of cells, boxes and classes are those of the hierarchical detector with the
/// same parameters; what a blob joins stays joined. A grid of one level is one whose coarse cells each hold a single
/// dense cell, so ξ is 1 whatever the parameters say.
///
/// Paper: HG section 3.2 and Fig. 7, the *Simple Grid Model*; boxes as VM section 4.
#[derive(Debug, Clone)]
pub struct SimpleGridDetector {
    merge: ConnectedComponentsParams,
    foreground: ForegroundStages,
    cells: DenseLevel,
    links: Vec<[u32; 2]>,
    blobs: DisjointSets,
    blob_of_cell: Vec<u32>,
    clusters: Clusters,
    outline: Outline,
    members: Vec<ObjectPoint>,
    box_fit: ConvexHullBox,
    objects: ObjectStages,
}

impl SimpleGridDetector {
    /// A detector for a sensor `sensor_height_m` above the road; `shared` are the parameters of the hierarchical detector.
    pub fn new(mut shared: HierarchicalParams, sensor_height_m: f32) -> Self {
        shared.grid.xi = 1;
        let objects = ObjectStages::new(&shared, shared.cluster.min_points);
        let max_height_difference_m = shared.grouping.gaps.max_height_difference_m;
        Self {
            merge: ConnectedComponentsParams { max_height_difference_m },
            foreground: ForegroundStages::new(shared, sensor_height_m),
            cells: DenseLevel::default(),
            links: Vec::new(),
            blobs: DisjointSets::default(),
            blob_of_cell: Vec::new(),
            clusters: Clusters::default(),
            outline: Outline::new(1),
            members: Vec::new(),
            box_fit: ConvexHullBox::default(),
            objects,
        }
    }

    /// The same detector, with the boxes of whole vehicles by `model`, if there is one.
    pub fn with_box_model(mut self, model: Option<Arc<BoxModel>>) -> Self {
        self.objects = self.objects.with_box_model(model);
        self
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: VehicleModel) -> Self {
        self.objects = self.objects.with_vehicle_model(model);
        self
    }
}

impl Detector for SimpleGridDetector {
    fn name(&self) -> &'static str {
        "simple-grid"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.foreground.run(cloud, &mut clock, &mut output.stage_times);
        self.merge_cells();
        clock.lap(stage::MERGE, &mut output.stage_times);
        self.outline.mark(self.foreground.grid(), &self.cells, &self.blob_of_cell);
        self.fit_boxes(cloud, output);
        clock.lap(stage::BOXES, &mut output.stage_times);
        self.objects.finish(cloud, &self.foreground, &mut clock, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = self.foreground.stage_products();
        let point_indices = self.foreground.point_indices();
        let members = self.clusters.iter();
        let clusters = members.map(|it| it.iter().map(|&place| point_indices[place as usize]));
        let clusters = point_clusters(cloud.len(), clusters);
        let links = merge_graph(self.foreground.grid(), &self.cells, &self.links, &[]);
        products.extend([
            StageProduct { stage: stage::MERGE, name: "links", shape: links },
            StageProduct { stage: stage::MERGE, name: "clusters", shape: clusters },
        ]);
        products.extend(self.objects.stage_products(cloud.len()));
        products
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        Some(self.foreground.ground_points(cloud))
    }

    fn rules(&self) -> Vec<Rule> {
        [self.foreground.rules(), self.objects.rules()].concat()
    }
}

impl SimpleGridDetector {
    fn merge_cells(&mut self) {
        let grid = self.foreground.grid();
        self.cells.fill(grid, self.foreground.foreground_cells(), self.foreground.point_indices());
        connected_components(grid, &self.cells, &self.merge, &mut self.links);
        let n_cells = self.cells.n_blocks();
        self.blobs.reset(n_cells);
        for &[cell, neighbor] in &self.links {
            self.blobs.join(cell, neighbor);
        }
        self.blob_of_cell.clear();
        self.blob_of_cell.extend((0..n_cells as u32).map(|cell| self.blobs.representative(cell)));
        let labels = self.cells.dense_of_point().iter().map(|&cell| self.blob_of_cell[cell as usize]);
        // The hierarchical detector numbers objects by their first point, too.
        self.clusters.group(labels, n_cells);
    }

    fn fit_boxes(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        self.objects.clear();
        let point_indices = self.foreground.point_indices();
        let cell_of_point = self.cells.dense_of_point();
        for members in self.clusters.iter() {
            let n_points = members.len();
            if n_points < self.objects.min_points() {
                output.dropped_clusters.push(DroppedCluster { n_points, reason: DropReason::TooFewPoints });
                continue;
            }
            self.members.clear();
            self.members.extend(members.iter().map(|&place| ObjectPoint {
                position_m: cloud.position_m(point_indices[place as usize] as usize),
                dense_idx: cell_of_point[place as usize],
            }));
            let z_range_m = self.outline.gather(&self.members);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let indices = members.iter().map(|&place| point_indices[place as usize]);
            let points = indices.zip(self.members.iter().map(|it| it.position_m));
            self.objects.add(points, bounding_box, self.box_fit.hull_m());
        }
    }
}
