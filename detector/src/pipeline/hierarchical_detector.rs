//! The detector of the paper.

use crate::classify::vehicle_model::VehicleModel;
use crate::detector::{Detector, DetectorOutput, DropReason, DroppedCluster, StageClock};
use crate::drawn::merge_graph::merge_graph;
use crate::drawn::object_cells::object_cells;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::outline::Outline;
use crate::grid::density_weighting::DensityWeighting;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::pipeline::object_stages::ObjectStages;
use crate::point_cloud::PointCloud;
use crate::regroup::regrouping::Regrouping;
use crate::rule::Rule;
use crate::segment::connected_components::connected_components;
use crate::segment::dense_level::DenseLevel;
use crate::segment::dense_separation::DenseSeparation;
use crate::segment::object_points::ObjectPoints;
use crate::stage_product::{Shape, StageProduct};

/// Objects from a hierarchical grid.
///
/// Paper: HG sections 3 to 3.2; boxes as VM section 4.
#[derive(Debug, Clone)]
pub struct HierarchicalDetector {
    foreground: ForegroundStages,
    dense: DenseLevel,
    links: Vec<[u32; 2]>,
    separation: DenseSeparation,
    clusters: ObjectPoints,
    outline: Outline,
    box_fit: ConvexHullBox,
    objects: ObjectStages,
}

impl HierarchicalDetector {
    /// A detector for a sensor `sensor_height_m` above the road.
    pub fn new(params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let weighting = DensityWeighting::new(&params.density_weighting);
        let separation = DenseSeparation::new(params.separation.clone(), &params.grid, &weighting);
        let outline = Outline::new(params.grid.xi);
        let regrouping = Regrouping::new(params.regrouping.clone());
        let objects = ObjectStages::new(&params, params.cluster.min_points).with_regrouping(regrouping);
        Self {
            foreground: ForegroundStages::new(params, sensor_height_m),
            dense: DenseLevel::default(),
            links: Vec::new(),
            separation,
            clusters: ObjectPoints::default(),
            outline,
            box_fit: ConvexHullBox::default(),
            objects,
        }
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: VehicleModel) -> Self {
        self.objects = self.objects.with_vehicle_model(model);
        self
    }
}

impl Detector for HierarchicalDetector {
    fn name(&self) -> &'static str {
        "hierarchical"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.foreground.run(cloud, &mut clock, &mut output.stage_times);
        let grid = self.foreground.grid();
        let params = self.foreground.params();
        self.dense.fill(grid, self.foreground.foreground_cells(), self.foreground.point_indices());
        clock.lap("dense_level", &mut output.stage_times);
        connected_components(grid, &self.dense, &params.merge, &mut self.links);
        clock.lap("merge", &mut output.stage_times);
        self.separation.separate(grid, &self.dense, &self.links);
        self.clusters.fill(cloud, self.foreground.point_indices(), &self.dense, &self.separation);
        clock.lap("separation", &mut output.stage_times);
        self.outline.mark(grid, &self.dense, self.separation.object_of_dense());
        self.fit_boxes(output);
        clock.lap("boxes", &mut output.stage_times);
        self.objects.finish(cloud, &self.foreground, &mut clock, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = self.foreground.stage_products();
        let cuts = self.separation.cut_links().iter().map(|&blocks| self.cut(blocks)).collect();
        let grid = self.foreground.grid();
        products.extend([
            StageProduct {
                stage: "merge",
                name: "links",
                shape: merge_graph(grid, &self.dense, &self.links, self.separation.cut_links()),
            },
            StageProduct {
                stage: "separation",
                name: "dense_cells",
                shape: object_cells(grid, &self.dense, &self.clusters),
            },
            StageProduct { stage: "separation", name: "cuts", shape: Shape::Segments(cuts) },
            StageProduct {
                stage: "separation",
                name: "clusters",
                shape: Shape::Clusters(self.cluster_of_point(cloud.len())),
            },
        ]);
        products.extend(self.objects.stage_products(cloud.len()));
        products
    }

    fn rules(&self) -> Vec<Rule> {
        [self.foreground.rules(), self.objects.rules()].concat()
    }
}

impl HierarchicalDetector {
    fn fit_boxes(&mut self, output: &mut DetectorOutput) {
        self.objects.clear();
        for cluster_idx in 0..self.clusters.n_objects() {
            let points = self.clusters.points(cluster_idx);
            if points.len() < self.objects.min_points() {
                let reason = DropReason::TooFewPoints;
                output.dropped_clusters.push(DroppedCluster { n_points: points.len(), reason });
                continue;
            }
            let z_range_m = self.outline.gather(points);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let point_indices = self.clusters.point_indices(cluster_idx).iter().copied();
            let points = point_indices.zip(points.iter().map(|it| it.position_m));
            self.objects.add(points, bounding_box, self.box_fit.hull_m());
        }
    }

    /// The border between two neighbouring cells whose link was cut, drawn at the height of the lower one's top.
    fn cut(&self, blocks: [u32; 2]) -> [[f32; 3]; 2] {
        let grid = self.foreground.grid();
        let [a, b] = blocks.map(|block_idx| grid.center_m(self.dense.cell_of_block()[block_idx as usize]));
        let [top_a_m, top_b_m] = blocks.map(|block_idx| self.dense.z_max_m(block_idx));
        let top_m = top_a_m.min(top_b_m);
        let middle_m = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        // A quarter turn from the line between the centres, half as long to either side.
        let half_m = [0.5 * (a[1] - b[1]), 0.5 * (b[0] - a[0])];
        [1.0, -1.0].map(|side| [middle_m[0] + side * half_m[0], middle_m[1] + side * half_m[1], top_m])
    }

    fn cluster_of_point(&self, n_points: usize) -> Vec<Option<u32>> {
        let mut cluster_of_point = vec![None; n_points];
        for cluster_idx in 0..self.clusters.n_objects() {
            for &point_idx in self.clusters.point_indices(cluster_idx) {
                cluster_of_point[point_idx as usize] = Some(cluster_idx as u32);
            }
        }
        cluster_of_point
    }
}
