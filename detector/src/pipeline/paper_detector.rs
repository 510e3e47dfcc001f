//! The detector of the papers to the letter.

use crate::classify::paper_model::{NO_VEHICLE, PaperModel};
use crate::classify::size_gate::size_gate;
use crate::classify::vehicle_model::class_by_decision;
use crate::describe::paper_features::N_PAPER_FEATURES;
use crate::detection::DetectedClass;
use crate::detector::{Detector, DetectorOutput, DropReason, DroppedCluster, StageClock};
use crate::drawn::cut_borders::cut_borders;
use crate::drawn::fitted_boxes::fitted_boxes;
use crate::drawn::merge_graph::merge_graph;
use crate::drawn::object_cells::object_cells;
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::fit::outline::Outline;
use crate::grid::density_weighting::DensityWeighting;
use crate::params::HierarchicalParams;
use crate::params::paper::PaperParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::segment::connected_components::{ConnectedComponentsParams, connected_components};
use crate::segment::dense_level::DenseLevel;
use crate::segment::dense_separation::DenseSeparation;
use crate::segment::object_points::ObjectPoints;
use crate::stage;
use crate::stage_product::StageProduct;

/// Objects from a hierarchical grid, and vehicles by eight values, as the papers print it.
///
/// It has nothing that is in no paper: no size bounds, no trained judge of groups, no completion.
///
/// Paper: HG sections 3 to 4, VM sections 3 to 5.
///
/// ```
/// use detector::classify::paper_model::PaperModel;
/// use detector::params::HierarchicalParams;
/// use detector::params::paper::PaperParams;
/// use detector::pipeline::paper_detector::PaperDetector;
/// use detector::{Detector, Rule};
///
/// let of_sensor = HierarchicalParams::shipped();
/// let detector = PaperDetector::new(&PaperParams::shipped(), &of_sensor, 1.73);
/// let detector = detector.with_vehicle_model(PaperModel::shipped());
/// // Which the paper has.
/// assert_eq!(detector.rules(), [Rule::Walls]);
/// ```
#[derive(Debug, Clone)]
pub struct PaperDetector {
    params: HierarchicalParams,
    merge: ConnectedComponentsParams,
    foreground: ForegroundStages,
    dense: DenseLevel,
    links: Vec<[u32; 2]>,
    separation: DenseSeparation,
    clusters: ObjectPoints,
    outline: Outline,
    box_fit: ConvexHullBox,
    fitted: FittedObjects,
    model: Option<PaperModel>,
    values: Vec<Option<[f32; N_PAPER_FEATURES]>>,
}

impl PaperDetector {
    /// A detector for a sensor `sensor_height_m` above the road, whose density curve is that of `of_sensor`, as are the sizes
    /// by which vehicles are told without a model.
    pub fn new(params: &PaperParams, of_sensor: &HierarchicalParams, sensor_height_m: f32) -> Self {
        let PaperParams { merge, separation, .. } = params.clone();
        let params = params.stages(of_sensor);
        let weighting = DensityWeighting::new(&params.density_weighting);
        Self {
            merge,
            foreground: ForegroundStages::new(params.clone(), sensor_height_m),
            dense: DenseLevel::default(),
            links: Vec::new(),
            separation: DenseSeparation::new(separation, &params.grid, &weighting),
            clusters: ObjectPoints::default(),
            outline: Outline::new(params.grid.xi),
            box_fit: ConvexHullBox::default(),
            fitted: FittedObjects::default(),
            model: None,
            values: Vec::new(),
            params,
        }
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(self, model: PaperModel) -> Self {
        Self { model: Some(model), ..self }
    }
}

impl Detector for PaperDetector {
    fn name(&self) -> &'static str {
        "paper"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.foreground.run(cloud, &mut clock, &mut output.stage_times);
        let grid = self.foreground.grid();
        self.dense.fill(grid, self.foreground.foreground_cells(), self.foreground.point_indices());
        clock.lap(stage::DENSE_LEVEL, &mut output.stage_times);
        connected_components(grid, &self.dense, &self.merge, &mut self.links);
        clock.lap(stage::MERGE, &mut output.stage_times);
        self.separation.separate(grid, &self.dense, &self.links);
        self.clusters.fill(cloud, self.foreground.point_indices(), &self.dense, &self.separation);
        clock.lap(stage::SEPARATION, &mut output.stage_times);
        self.outline.mark(grid, &self.dense, self.separation.object_of_dense());
        self.fit_boxes(output);
        clock.lap(stage::BOXES, &mut output.stage_times);
        if self.model.is_some() {
            self.describe();
            clock.lap(stage::FEATURES, &mut output.stage_times);
        }
        self.decide();
        self.report(output);
        clock.lap(stage::CLASSIFICATION, &mut output.stage_times);
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
        let FittedObjects { objects, members, .. } = &self.fitted;
        products.extend(fitted_boxes(&self.fitted, objects));
        if let Some(model) = &self.model {
            let positions_m = |it: &FittedObject| members.positions_m(&it.members).iter().copied();
            let described = objects.iter().map(|it| (it.bounding_box, positions_m(it)));
            products.extend(vehicle_shapes(model.prototypes(), described));
        }
        products
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        Some(self.foreground.ground_points(cloud))
    }

    fn rules(&self) -> Vec<Rule> {
        self.foreground.rules()
    }
}

impl PaperDetector {
    fn fit_boxes(&mut self, output: &mut DetectorOutput) {
        self.fitted.clear();
        for cluster_idx in 0..self.clusters.n_objects() {
            let points = self.clusters.points(cluster_idx);
            if points.len() < self.params.cluster.min_points {
                let reason = DropReason::TooFewPoints;
                output.dropped_clusters.push(DroppedCluster { n_points: points.len(), reason });
                continue;
            }
            let z_range_m = self.outline.gather(points);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let point_indices = self.clusters.point_indices(cluster_idx).iter().copied();
            let start = self.fitted.members.len();
            self.fitted.members.extend(point_indices.zip(points.iter().map(|it| it.position_m)));
            let members = start..self.fitted.members.len();
            let object = self.fitted.object(members, bounding_box, self.box_fit.hull_m());
            self.fitted.objects.push(object);
        }
    }

    fn describe(&mut self) {
        let Self { model: Some(model), fitted, values, .. } = self else { return };
        let FittedObjects { objects, members, .. } = fitted;
        values.clear();
        values.extend(
            objects
                .iter()
                .map(|it| model.values(&it.bounding_box, members.positions_m(&it.members).iter().copied())),
        );
    }

    fn decide(&mut self) {
        let Some(model) = &self.model else { return };
        for (object, values) in self.fitted.objects.iter_mut().zip(&self.values) {
            object.decision = Some(model.decision_on(values.as_ref()));
        }
    }

    fn report(&self, output: &mut DetectorOutput) {
        for object in &self.fitted.objects {
            output.push_ranked(object.detection(&self.fitted.members, self.class_of(object)), NO_VEHICLE);
        }
    }

    fn class_of(&self, object: &FittedObject) -> DetectedClass {
        let n_points = object.members.len();
        match self.model {
            Some(_) => class_by_decision(object.decision, n_points, self.params.cluster.min_points),
            None => size_gate(n_points, &object.bounding_box, &self.params.vehicle_size),
        }
    }
}
