//! From objects with boxes to detections. Shared with baselines that classify as the paper does.

use std::sync::Arc;

use crate::classify::size_gate::size_gate;
use crate::classify::vehicle_model::{VehicleModel, class_by_decision};
use crate::complete::completed_object::{box_with_points, merge_points};
use crate::complete::completion::Completion;
use crate::detection::{DetectedClass, Detection};
use crate::detector::{DetectorOutput, StageClock};
use crate::drawn::fitted_boxes::fitted_boxes;
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::pipeline::vehicle_stages::VehicleStages;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::stage;
use crate::stage_product::StageProduct;
use crate::whole::box_model::BoxModel;
use crate::whole::reported_boxes::ReportedBoxes;

/// Classes and completion of one scan after another.
#[derive(Debug, Clone)]
pub struct ObjectStages {
    params: HierarchicalParams,
    min_points: usize,
    min_vehicle_points: usize,
    fitted: FittedObjects,
    vehicles: Option<VehicleStages>,
    completion: Completion,
    // Log odds of the least likely vehicle that is ranked.
    ranked_log_odds: f32,
    point_indices: Vec<u32>,
    boxes: ReportedBoxes,
}

impl ObjectStages {
    /// Stages that tell vehicles by their size. Objects have at least `min_points`.
    pub fn new(params: &HierarchicalParams, min_points: usize) -> Self {
        Self {
            min_points,
            min_vehicle_points: params.cluster.min_vehicle_points.min(min_points),
            fitted: FittedObjects::default(),
            vehicles: None,
            completion: Completion::new(params.completion.clone()),
            ranked_log_odds: params.grouping.ranked_log_odds(),
            point_indices: Vec::new(),
            boxes: ReportedBoxes::new(params.boxes),
            params: params.clone(),
        }
    }

    /// The same stages, which tell vehicles by `model` instead.
    pub fn with_vehicle_model(self, model: VehicleModel) -> Self {
        let vehicles = VehicleStages::new(model, &self.params);
        Self { vehicles: Some(vehicles), ..self }
    }

    /// The same stages, with the boxes of whole vehicles by `model`, if there is one.
    pub fn with_box_model(self, model: Option<Arc<BoxModel>>) -> Self {
        Self { boxes: self.boxes.with_model(model), ..self }
    }

    /// Fewest points of what may become a detection.
    pub fn min_points(&self) -> usize {
        if self.vehicles.is_some() { self.min_vehicle_points } else { self.min_points }
    }

    /// What becomes of clusters beside their class.
    pub fn rules(&self) -> Vec<Rule> {
        let mut rules = Vec::new();
        if self.vehicles.is_some() {
            if self.min_vehicle_points < self.min_points {
                rules.push(Rule::SmallVehicles { min_points: self.min_vehicle_points });
            }
            if self.params.vehicle_bounds.enabled {
                rules.push(Rule::SizeBounds);
            }
        }
        if self.completion.is_enabled() {
            rules.push(Rule::Completion);
        }
        if self.boxes.are_whole() {
            rules.push(Rule::WholeBoxes);
        }
        rules
    }

    /// Forgets the objects of the scan before.
    pub fn clear(&mut self) {
        self.fitted.clear();
    }

    /// Adds an object of these points, indices ascending, with its box and the hull it was fitted to.
    pub fn add(
        &mut self,
        points: impl Iterator<Item = (u32, [f32; 3])> + Clone,
        bounding_box: OrientedBox,
        hull_m: &[[f32; 2]],
    ) {
        let start = self.fitted.members.len();
        self.fitted.members.extend(points);
        let object = self.fitted.object(start..self.fitted.members.len(), bounding_box, hull_m);
        self.fitted.objects.push(object);
    }

    /// Makes detections of the objects that were added.
    pub fn finish(
        &mut self,
        cloud: &PointCloud,
        foreground: &ForegroundStages,
        clock: &mut StageClock,
        output: &mut DetectorOutput,
    ) {
        if let Some(vehicles) = &mut self.vehicles {
            vehicles.describe(&self.fitted, foreground);
            clock.lap(stage::FEATURES, &mut output.stage_times);
            vehicles.decide(&mut self.fitted);
            clock.lap(stage::CLASSIFICATION, &mut output.stage_times);
        }
        self.drop_small_background(output);
        self.complete(cloud, foreground);
        self.report(cloud, output);
        clock.lap(stage::COMPLETION, &mut output.stage_times);
        self.boxes.replace(cloud, |it| foreground.ground_below_m(it), output);
        clock.lap(stage::REPORTED_BOXES, &mut output.stage_times);
    }

    /// Drops what has too few points for an object and is no vehicle. A car far away shows few points.
    fn drop_small_background(&mut self, output: &mut DetectorOutput) {
        let FittedObjects { objects, members, .. } = &mut self.fitted;
        objects.retain(|it| {
            let n_points = it.members.len();
            let is_kept = n_points >= self.min_points || it.decision.is_some_and(|decision| decision > 0.0);
            if !is_kept {
                output.drop_small(it.detection(members, DetectedClass::Object), self.ranked_log_odds);
            }
            is_kept
        });
    }

    /// Finds the points in the boxes of objects that are no foreground.
    fn complete(&mut self, cloud: &PointCloud, foreground: &ForegroundStages) {
        let FittedObjects { objects, members, .. } = &self.fitted;
        let asked = objects.iter().map(|it| {
            let ground_m = foreground.ground_below_m(&it.bounding_box);
            (&it.bounding_box, ground_m, members.point_indices(&it.members))
        });
        self.completion.find(cloud, foreground.grid(), asked);
    }

    /// Makes a detection of each object, with its own points and those that were found for it.
    fn report(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        for (object_idx, object) in self.fitted.objects.iter().enumerate() {
            let added = self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx);
            let own = self.fitted.members.point_indices(&object.members);
            merge_points(own, added.clone(), &mut self.point_indices);
            let detection = Detection::new(
                &self.point_indices,
                box_with_points(object.bounding_box, cloud, added),
                self.class_of(object),
                object.decision,
            );
            output.push_ranked(detection, self.ranked_log_odds);
        }
    }

    /// By the model if there is one, else by size. Points that completion adds do not count: no model is trained on them.
    fn class_of(&self, object: &FittedObject) -> DetectedClass {
        let n_points = object.members.len();
        match self.vehicles {
            Some(_) => class_by_decision(object.decision, n_points, self.min_vehicle_points),
            None => size_gate(n_points, &object.bounding_box, &self.params.vehicle_size),
        }
    }

    /// What the stages left behind of the latest scan, which has `n_points` points.
    pub fn stage_products(&self, n_points: usize) -> Vec<StageProduct> {
        let FittedObjects { objects, members, .. } = &self.fitted;
        let mut products = fitted_boxes(&self.fitted, objects);
        if let Some(vehicles) = &self.vehicles {
            let described = objects.iter().map(|it| {
                let positions_m = members.positions_m(&it.members).iter().copied();
                (it.bounding_box, positions_m)
            });
            products.extend(vehicle_shapes(vehicles.prototypes(), described));
        }
        let own = |it: &FittedObject| members.point_indices(&it.members).iter().copied();
        let completed = objects.iter().enumerate().map(|(object_idx, object)| {
            let added = self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx);
            own(object).chain(added)
        });
        let shape = point_clusters(n_points, completed);
        products.push(StageProduct { stage: stage::COMPLETION, name: "objects", shape });
        products
    }
}
