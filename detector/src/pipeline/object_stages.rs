//! Stages that make detections of objects with boxes.

use std::sync::Arc;

use crate::classify::paper_model::NO_VEHICLE;
use crate::classify::size_gate::{SizeGateParams, size_gate};
use crate::classify::vehicle_model::VehicleModel;
use crate::complete::completed_object::{box_with_points, merge_points};
use crate::complete::completion::Completion;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::{ObjectRaster, Surroundings};
use crate::detection::{DetectedClass, Detection, GivenClass};
use crate::detector::{DetectorOutput, UnlikelyOdds};
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::params::{ClusterParams, HierarchicalParams, log_odds};
use crate::pipeline::frame::Frame;
use crate::pipeline::stage_list::{Stage, Stages};
use crate::point_cloud::PointCloud;
use crate::road_user::{RoadUser, RoadUserOdds, RoadUserRule};
use crate::rule::Rule;
use crate::stage;
use crate::stage_product::StageProduct;
use crate::whole::box_model::BoxModels;
use crate::whole::reported_boxes::ReportedBoxes;

/// The models of detectors that classify objects with boxes.
#[derive(Debug, Clone, Default)]
pub struct ObjectModels {
    /// Classifies vehicles; without it, their size does.
    pub vehicles: Option<VehicleModel>,
    /// Makes whole boxes; without it, the model of the program does.
    pub boxes: Option<Arc<BoxModels>>,
}

/// Classes, completion and reported boxes.
pub fn object_stages<C: 'static>(params: &HierarchicalParams, models: ObjectModels) -> Stages<C> {
    let mut stages = Stages::default();
    if let Some(model) = models.vehicles {
        let (bounds, cluster) = (params.vehicle_bounds, params.cluster.clone());
        let model = model.within(bounds);
        let raster = ObjectRaster::new(params.grid.extent_m);
        stages = stages
            .then(stage::FEATURES, Features { model: model.clone(), raster })
            .then(stage::CLASSIFICATION, Decisions { model, bounds, cluster });
    }
    stages.and(completion_stages(params, models.boxes))
}

/// Completion and reported boxes.
pub fn completion_stages<C>(params: &HierarchicalParams, box_model: Option<Arc<BoxModels>>) -> Stages<C> {
    let completed = CompletedObjects {
        cluster: params.cluster.clone(),
        sizes: params.vehicle_size.clone(),
        unlikely: UnlikelyOdds {
            above: log_odds(params.grouping.ranked_probability),
            up_to: params.cluster.road_user_rule().least_odds,
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

/// Appends `detection` of `object` with its class: by the odds of a model and `rule` if there are some; else by its size. It
/// is added to the unlikely road users of the other classes, too.
fn push_classified(
    object: &FittedObject,
    detection: Detection<'_>,
    (sizes, rule): (&SizeGateParams, RoadUserRule),
    unlikely: UnlikelyOdds,
    output: &mut DetectorOutput,
) {
    let n_points = object.members.len();
    let Some(odds) = object.odds else {
        let class = size_gate(n_points, &object.bounding_box, sizes);
        output.detections.push(Detection { class, ..detection });
        return;
    };
    let found = rule.road_user(odds, n_points);
    // How sure it is of a vehicle, where it is no other road user.
    let of = found.unwrap_or(RoadUser::Vehicle);
    let class = found.map_or(DetectedClass::Object, RoadUser::class);
    let given = found.and_then(RoadUser::given);
    output.detections.push(Detection { class, given, score: Some(odds.of(of)), ..detection });
    output.rank(detection, odds, unlikely);
}

/// [`Rule::SmallVehicles`], if vehicles may have fewer points than other objects.
pub fn small_vehicles(cluster: &ClusterParams) -> Option<Rule> {
    let min_points = cluster.least_vehicle_points();
    (min_points < cluster.min_points).then_some(Rule::SmallVehicles { min_points })
}

/// Computes the values that a model of trees looks at.
struct Features {
    model: VehicleModel,
    raster: ObjectRaster,
}

impl<C> Stage<C> for Features {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        let Self { model, raster } = self;
        let Frame { grid, terrain, fitted, .. } = frame;
        raster.fill(fitted.members.all_positions_m().iter().copied());
        fitted.describe(|object, positions_m| {
            let bounding_box = &object.bounding_box;
            let [x_m, y_m, _] = bounding_box.center_m;
            let ground_m = terrain.elevation_m(grid.nearest_column_and_row([x_m, y_m]));
            object.may_be = model.may_be(bounding_box, ground_m);
            // For objects that the model is not asked about, only the ground is found.
            let surroundings = if object.may_be.allows_any() {
                raster.around(bounding_box, ground_m)
            } else {
                Surroundings { ground_m, ..Surroundings::default() }
            };
            model.values(bounding_box, &surroundings, positions_m.iter().copied())
        });
    }

    fn products(&self, _: &PointCloud, frame: &Frame<C>) -> Vec<StageProduct> {
        vehicle_shapes(self.model.prototypes(), &frame.fitted)
    }
}

/// A model of trees decides by these values.
struct Decisions {
    model: VehicleModel,
    bounds: VehicleBoundsParams,
    cluster: ClusterParams,
}

impl<C> Stage<C> for Decisions {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        frame.fitted.decide(|may_be, values| self.model.odds(may_be, values));
    }

    fn given_classes(&self) -> Vec<GivenClass> {
        self.model.given_classes()
    }

    fn rules(&self, _: &Frame<C>) -> Vec<Rule> {
        let bounds = self.bounds.enabled.then_some(Rule::SizeBounds);
        small_vehicles(&self.cluster).into_iter().chain(bounds).collect()
    }
}

/// Classifies objects by `decide`, and makes a detection of each as it is. A vehicle needs `least_points`, and a decision
/// above 0; objects that `decide` leaves open are classified by `sizes`.
pub fn classification<C>(
    sizes: SizeGateParams,
    least_points: usize,
    decide: impl Fn(&mut FittedObjects) + Send,
) -> impl Stage<C> {
    let rule = RoadUserRule { least_points, least_odds: RoadUserOdds::of_vehicle(0.0) };
    let unlikely = UnlikelyOdds { above: NO_VEHICLE, up_to: rule.least_odds };
    move |_: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput| {
        decide(&mut frame.fitted);
        let FittedObjects { objects, members, .. } = &frame.fitted;
        for object in objects {
            push_classified(object, object.detection(members), (&sizes, rule), unlikely, output);
        }
    }
}

/// Drops objects that are too small and no vehicles, and makes detections of the others, with the points in their boxes that
/// are no foreground.
struct CompletedObjects {
    cluster: ClusterParams,
    sizes: SizeGateParams,
    unlikely: UnlikelyOdds,
    completion: Completion,
    point_indices: Vec<u32>,
}

impl CompletedObjects {
    /// Drops objects of too low an expected IoU or too few points, unless they are road users: a car far away shows few
    /// points.
    fn drop_background(&self, fitted: &mut FittedObjects, output: &mut DetectorOutput) {
        let FittedObjects { objects, members, .. } = fitted;
        // Those of fewer points were dropped before.
        let rule = self.cluster.road_user_rule();
        let is_road_user =
            |it: &FittedObject| it.odds.is_some_and(|odds| rule.road_user(odds, it.members.len()).is_some());
        let odds = |it: &FittedObject| it.odds.unwrap_or(RoadUserOdds::NONE);
        objects.retain(|it| {
            let is_kept = !it.has_low_iou || is_road_user(it);
            if !is_kept {
                output.rank(it.detection(members), odds(it), self.unlikely);
            }
            is_kept
        });
        objects.retain(|it| {
            let is_kept = it.members.len() >= self.cluster.min_points || is_road_user(it);
            if !is_kept {
                output.drop_small(it.detection(members), odds(it), self.unlikely);
            }
            is_kept
        });
    }

    /// Indices of the points that were found for an object.
    fn added_to(&self, object_idx: usize) -> impl Iterator<Item = u32> + Clone {
        self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx)
    }
}

impl<C> Stage<C> for CompletedObjects {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput) {
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
            let detection = Detection::new(&point_indices, bounding_box, DetectedClass::Object, None);
            let rules = (&self.sizes, self.cluster.road_user_rule());
            push_classified(object, detection, rules, self.unlikely, output);
        }
        self.point_indices = point_indices;
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<C>) -> Vec<StageProduct> {
        let FittedObjects { objects, members, .. } = &frame.fitted;
        let completed = objects.iter().enumerate().map(|(object_idx, object)| {
            let own = members.point_indices(&object.members).iter().copied();
            own.chain(self.added_to(object_idx))
        });
        let shape = point_clusters(cloud.len(), completed);
        vec![StageProduct { stage: stage::COMPLETION, name: "objects", shape }]
    }

    fn rules(&self, _: &Frame<C>) -> Vec<Rule> {
        if self.completion.is_enabled() { vec![Rule::Completion] } else { Vec::new() }
    }
}

impl<C> Stage<C> for ReportedBoxes {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput) {
        self.replace(cloud, |it| frame.ground_below_m(it), output);
    }

    fn rules(&self, _: &Frame<C>) -> Vec<Rule> {
        if self.are_whole() { vec![Rule::WholeBoxes] } else { Vec::new() }
    }
}
