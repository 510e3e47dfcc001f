//! Stages that make detections of objects with boxes.

use std::sync::Arc;

use crate::classify::paper_model::NO_VEHICLE;
use crate::classify::size_gate::{SizeGateParams, size_gate};
use crate::classify::vehicle_model::{VehicleModel, VehicleRule, class_by_decision};
use crate::complete::completed_object::{box_with_points, merge_points};
use crate::complete::completion::Completion;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::{ObjectRaster, Surroundings};
use crate::detection::{DetectedClass, Detection};
use crate::detector::{DetectorOutput, UnlikelyScores};
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::params::{ClusterParams, HierarchicalParams, log_odds};
use crate::pipeline::frame::Frame;
use crate::pipeline::stage_list::{Stage, Stages};
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::stage;
use crate::stage_product::StageProduct;
use crate::whole::box_model::BoxModel;
use crate::whole::reported_boxes::ReportedBoxes;

/// The models of detectors that classify objects with boxes.
#[derive(Debug, Clone, Default)]
pub struct ObjectModels {
    /// Classifies vehicles; without it, their size does.
    pub vehicles: Option<VehicleModel>,
    /// Makes whole boxes; without it, the model of the program does.
    pub boxes: Option<Arc<BoxModel>>,
}

/// Classes, completion and reported boxes.
pub fn object_stages(params: &HierarchicalParams, models: ObjectModels) -> Stages {
    let mut stages = Stages::default();
    if let Some(model) = models.vehicles {
        let (bounds, cluster) = (params.vehicle_bounds, params.cluster.clone());
        let model = model.within(bounds);
        let raster = ObjectRaster::new(params.grid.extent_m);
        stages = stages
            .then(stage::FEATURES, Features { model: model.clone(), bounds, raster })
            .then(stage::CLASSIFICATION, Decisions { model, bounds, cluster });
    }
    stages.and(completion_stages(params, models.boxes))
}

/// Completion and reported boxes.
pub fn completion_stages(params: &HierarchicalParams, box_model: Option<Arc<BoxModel>>) -> Stages {
    let completed = CompletedObjects {
        cluster: params.cluster.clone(),
        sizes: params.vehicle_size.clone(),
        unlikely: UnlikelyScores {
            above: log_odds(params.grouping.ranked_probability),
            up_to: params.cluster.vehicle_rule().least_decision,
        },
        completion: Completion::new(params.completion.clone()),
        point_indices: Vec::new(),
    };
    let boxes = ReportedBoxes::new(params.boxes).with_model(box_model);
    Stages::default().then(stage::COMPLETION, completed).then(stage::REPORTED_BOXES, boxes)
}

/// Fewest points of an object with a box. Objects of fewer than `cluster.min_points` are dropped later, unless `model`
/// classifies them as vehicles.
pub fn least_points(cluster: &ClusterParams, model: Option<&VehicleModel>) -> usize {
    if model.is_some() { cluster.least_vehicle_points() } else { cluster.min_points }
}

/// The class of an object: by the decision of a model and `rule` if there is one; else by its size.
fn class_of(object: &FittedObject, sizes: &SizeGateParams, rule: VehicleRule) -> DetectedClass {
    let n_points = object.members.len();
    match object.decision {
        Some(_) => class_by_decision(object.decision, n_points, rule),
        None => size_gate(n_points, &object.bounding_box, sizes),
    }
}

/// [`Rule::SmallVehicles`], if vehicles may have fewer points than other objects.
pub fn small_vehicles(cluster: &ClusterParams) -> Option<Rule> {
    let min_points = cluster.least_vehicle_points();
    (min_points < cluster.min_points).then_some(Rule::SmallVehicles { min_points })
}

/// Computes the values that a model of trees looks at.
struct Features {
    model: VehicleModel,
    bounds: VehicleBoundsParams,
    raster: ObjectRaster,
}

impl Stage for Features {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame, _: &mut DetectorOutput) {
        let Self { model, bounds, raster } = self;
        let Frame { grid, terrain, fitted, .. } = frame;
        raster.fill(fitted.members.all_positions_m().iter().copied());
        fitted.describe(|bounding_box, positions_m| {
            let [x_m, y_m, _] = bounding_box.center_m;
            let ground_m = terrain.elevation_m(grid.nearest_column_and_row([x_m, y_m]));
            // For objects that the model is not asked about, only the ground is found.
            let surroundings = if bounds.allow(bounding_box, ground_m) {
                raster.around(bounding_box, ground_m)
            } else {
                Surroundings { ground_m, ..Surroundings::default() }
            };
            model.values(bounding_box, &surroundings, positions_m.iter().copied())
        });
    }

    fn products(&self, _: &PointCloud, frame: &Frame) -> Vec<StageProduct> {
        vehicle_shapes(self.model.prototypes(), &frame.fitted)
    }
}

/// A model of trees decides by these values.
struct Decisions {
    model: VehicleModel,
    bounds: VehicleBoundsParams,
    cluster: ClusterParams,
}

impl Stage for Decisions {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame, _: &mut DetectorOutput) {
        frame.fitted.decide(|values| self.model.decision_on(values));
    }

    fn rules(&self, _: &Frame) -> Vec<Rule> {
        let bounds = self.bounds.enabled.then_some(Rule::SizeBounds);
        small_vehicles(&self.cluster).into_iter().chain(bounds).collect()
    }
}

/// Classifies objects by `decide`, and makes a detection of each as it is. A vehicle needs `least_points`, and a decision
/// above 0; objects that `decide` leaves open are classified by `sizes`.
pub fn classification(
    sizes: SizeGateParams,
    least_points: usize,
    decide: impl Fn(&mut FittedObjects) + Send,
) -> impl Stage {
    let rule = VehicleRule { least_points, least_decision: 0.0 };
    let unlikely = UnlikelyScores { above: NO_VEHICLE, up_to: rule.least_decision };
    move |_: &PointCloud, frame: &mut Frame, output: &mut DetectorOutput| {
        decide(&mut frame.fitted);
        let FittedObjects { objects, members, .. } = &frame.fitted;
        for object in objects {
            let class = class_of(object, &sizes, rule);
            output.push_ranked(object.detection(members, class), unlikely);
        }
    }
}

/// Drops objects that are too small and no vehicles, and makes detections of the others, with the points in their boxes that
/// are no foreground.
struct CompletedObjects {
    cluster: ClusterParams,
    sizes: SizeGateParams,
    unlikely: UnlikelyScores,
    completion: Completion,
    point_indices: Vec<u32>,
}

impl CompletedObjects {
    /// Drops objects of too low an expected IoU or too few points, unless they are vehicles: a car far away shows few
    /// points.
    fn drop_background(&self, fitted: &mut FittedObjects, output: &mut DetectorOutput) {
        let FittedObjects { objects, members, .. } = fitted;
        let least_decision = self.cluster.vehicle_rule().least_decision;
        objects.retain(|it| {
            let is_kept = !it.has_low_iou || it.is_predicted_vehicle(least_decision);
            if !is_kept {
                output.rank(it.detection(members, DetectedClass::Object), self.unlikely);
            }
            is_kept
        });
        objects.retain(|it| {
            let is_kept =
                it.members.len() >= self.cluster.min_points || it.is_predicted_vehicle(least_decision);
            if !is_kept {
                output.drop_small(it.detection(members, DetectedClass::Object), self.unlikely);
            }
            is_kept
        });
    }

    /// Indices of the points that were found for an object.
    fn added_to(&self, object_idx: usize) -> impl Iterator<Item = u32> + Clone {
        self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx)
    }
}

impl Stage for CompletedObjects {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame, output: &mut DetectorOutput) {
        self.drop_background(&mut frame.fitted, output);
        let FittedObjects { objects, members, .. } = &frame.fitted;
        let asked = objects.iter().map(|it| {
            let ground_m = frame.ground_below_m(&it.bounding_box);
            (&it.bounding_box, ground_m, members.point_indices(&it.members))
        });
        self.completion.find(cloud, &frame.grid, asked);
        let mut point_indices = std::mem::take(&mut self.point_indices);
        for (object_idx, object) in objects.iter().enumerate() {
            let added = self.added_to(object_idx);
            merge_points(members.point_indices(&object.members), added.clone(), &mut point_indices);
            let bounding_box = box_with_points(object.bounding_box, cloud, added);
            // Points that were added do not count for the class: no model is trained on them.
            let class = class_of(object, &self.sizes, self.cluster.vehicle_rule());
            let detection = Detection::new(&point_indices, bounding_box, class, object.decision);
            output.push_ranked(detection, self.unlikely);
        }
        self.point_indices = point_indices;
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame) -> Vec<StageProduct> {
        let FittedObjects { objects, members, .. } = &frame.fitted;
        let completed = objects.iter().enumerate().map(|(object_idx, object)| {
            let own = members.point_indices(&object.members).iter().copied();
            own.chain(self.added_to(object_idx))
        });
        let shape = point_clusters(cloud.len(), completed);
        vec![StageProduct { stage: stage::COMPLETION, name: "objects", shape }]
    }

    fn rules(&self, _: &Frame) -> Vec<Rule> {
        if self.completion.is_enabled() { vec![Rule::Completion] } else { Vec::new() }
    }
}

impl Stage for ReportedBoxes {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame, output: &mut DetectorOutput) {
        self.replace(cloud, |it| frame.ground_below_m(it), output);
    }

    fn rules(&self, _: &Frame) -> Vec<Rule> {
        if self.are_whole() { vec![Rule::WholeBoxes] } else { Vec::new() }
    }
}
