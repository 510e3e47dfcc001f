//! The detector of the paper.

use crate::classify::vehicle_model::VehicleModel;
use crate::detector::{Detector, DetectorOutput, DropReason, DroppedCluster, StageClock};
use crate::drawn::cut_borders::cut_borders;
use crate::drawn::merge_graph::merge_graph;
use crate::drawn::object_cells::object_cells;
use crate::drawn::point_clusters::point_clusters;
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
use crate::stage;
use crate::stage_product::StageProduct;

/// Objects from a hierarchical grid.
///
/// Paper: HG sections 3 to 3.2; boxes as VM section 4.
///
/// ```
/// use detector::classify::vehicle_model::VehicleModel;
/// use detector::params::HierarchicalParams;
/// use detector::pipeline::hierarchical_detector::HierarchicalDetector;
/// use detector::{Detector, Rule};
///
/// let by_size = HierarchicalDetector::new(HierarchicalParams::shipped(), 1.73);
/// assert!(!by_size.rules().contains(&Rule::Regrouping));
/// // With a model, which it asks where clusters are to be cut and joined.
/// let by_model = by_size.with_vehicle_model(VehicleModel::shipped());
/// assert!(by_model.rules().contains(&Rule::Regrouping));
/// ```
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
        clock.lap(stage::DENSE_LEVEL, &mut output.stage_times);
        connected_components(grid, &self.dense, &params.merge, &mut self.links);
        clock.lap(stage::MERGE, &mut output.stage_times);
        // Links and not blobs go in: the separation decides about each link again.
        self.separation.separate(grid, &self.dense, &self.links);
        self.clusters.fill(cloud, self.foreground.point_indices(), &self.dense, &self.separation);
        clock.lap(stage::SEPARATION, &mut output.stage_times);
        // Points inside of an outline are no corners of a hull, so that boxes are fitted to few.
        self.outline.mark(grid, &self.dense, self.separation.object_of_dense());
        self.fit_boxes(output);
        clock.lap(stage::BOXES, &mut output.stage_times);
        self.objects.finish(cloud, &self.foreground, &mut clock, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let (grid, cut_links) = (self.foreground.grid(), self.separation.cut_links());
        let links = merge_graph(grid, &self.dense, &self.links, cut_links);
        let dense_cells = object_cells(grid, &self.dense, &self.clusters);
        let cuts = cut_borders(grid, &self.dense, cut_links);
        let points_of = |cluster_idx| self.clusters.point_indices(cluster_idx).iter().copied();
        let clusters = point_clusters(cloud.len(), (0..self.clusters.n_objects()).map(points_of));
        let mut products = self.foreground.stage_products();
        products.extend([
            StageProduct { stage: stage::MERGE, name: "links", shape: links },
            StageProduct { stage: stage::SEPARATION, name: "dense_cells", shape: dense_cells },
            StageProduct { stage: stage::SEPARATION, name: "cuts", shape: cuts },
            StageProduct { stage: stage::SEPARATION, name: "clusters", shape: clusters },
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
}
