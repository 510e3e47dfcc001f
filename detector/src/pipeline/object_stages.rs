//! From objects with boxes to detections. Shared with baselines that classify as the paper does.

use crate::classify::size_gate::{SizeGateParams, size_gate};
use crate::classify::vehicle_model::{N_FEATURES, VehicleModel, class_by_decision};
use crate::complete::completion::Completion;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::{ObjectRaster, Surroundings};
use crate::detection::Detection;
use crate::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock};
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::point_cloud::PointCloud;
use crate::regroup::regrouping::{Judge, Regrouping};
use crate::rule::Rule;
use crate::stage_product::{Shape, StageProduct};

/// Classes, regrouping and completion of one scan after another.
#[derive(Debug, Clone)]
pub struct ObjectStages {
    min_points: usize,
    min_vehicle_points: usize,
    vehicle_bounds: VehicleBoundsParams,
    fitted: FittedObjects,
    model: Option<VehicleModel>,
    values: Vec<Option<[f32; N_FEATURES]>>,
    regrouping: Option<Regrouping>,
    raster: ObjectRaster,
    box_fit: ConvexHullBox,
    completion: Completion,
    point_indices: Vec<u32>,
}

impl ObjectStages {
    /// Stages that tell vehicles by their size, and leave the objects as they are. Objects have at least `min_points`.
    pub fn new(params: &HierarchicalParams, min_points: usize) -> Self {
        Self {
            min_points,
            min_vehicle_points: params.cluster.min_vehicle_points.min(min_points),
            vehicle_bounds: params.vehicle_bounds,
            fitted: FittedObjects::default(),
            model: None,
            values: Vec::new(),
            regrouping: None,
            raster: ObjectRaster::new(params.grid.extent_m),
            box_fit: ConvexHullBox::default(),
            completion: Completion::new(params.completion.clone()),
            point_indices: Vec::new(),
        }
    }

    /// The same stages, which tell vehicles by `model` instead.
    pub fn with_vehicle_model(self, model: VehicleModel) -> Self {
        Self { model: Some(model.within(self.vehicle_bounds)), ..self }
    }

    /// The same stages, which cut and join objects if there is a vehicle model.
    pub fn with_regrouping(self, regrouping: Regrouping) -> Self {
        Self { regrouping: Some(regrouping), ..self }
    }

    /// Fewest points of what may become a detection.
    pub fn min_points(&self) -> usize {
        if self.model.is_some() { self.min_vehicle_points } else { self.min_points }
    }

    /// What becomes of clusters beside their class.
    pub fn rules(&self) -> Vec<Rule> {
        let mut rules = Vec::new();
        if self.model.is_some() {
            if self.min_vehicle_points < self.min_points {
                rules.push(Rule::SmallVehicles { min_points: self.min_vehicle_points });
            }
            if self.vehicle_bounds.enabled {
                rules.push(Rule::SizeBounds);
            }
            if self.regrouping.as_ref().is_some_and(Regrouping::is_enabled) {
                rules.push(Rule::Regrouping);
            }
        }
        if self.completion.is_enabled() {
            rules.push(Rule::Completion);
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
        let (raster, bounds) = (&mut self.raster, self.vehicle_bounds);
        let surroundings = |raster: &ObjectRaster, bounding_box: &OrientedBox| {
            let ground_m = foreground.ground_below_m(bounding_box);
            // The model does not look at others.
            if bounds.allow(bounding_box, ground_m) {
                raster.around(bounding_box, ground_m)
            } else {
                Surroundings { ground_m, ..Surroundings::default() }
            }
        };
        if let Some(model) = &mut self.model {
            let members = &self.fitted.members;
            raster.fill(members.positions_m(&(0..members.len())).iter().copied());
            let values = self.fitted.objects.iter().map(|it| {
                let positions_m = members.positions_m(&it.members).iter().copied();
                model.values(&it.bounding_box, &surroundings(raster, &it.bounding_box), positions_m)
            });
            self.values.clear();
            self.values.extend(values);
            clock.lap("features", &mut output.stage_times);
            for (object, values) in self.fitted.objects.iter_mut().zip(&self.values) {
                object.decision = Some(model.decision_on(values.as_ref()));
            }
            clock.lap("svm", &mut output.stage_times);
        }
        if let (Some(regrouping), Some(model)) = (&mut self.regrouping, &mut self.model) {
            let surroundings = |bounding_box: &OrientedBox| surroundings(raster, bounding_box);
            let min_points = self.min_vehicle_points;
            let sizes = &SizeGateParams { min_points, ..foreground.params().vehicle_size.clone() };
            let judge = Judge { box_fit: &mut self.box_fit, model, surroundings, sizes };
            regrouping.regroup(&mut self.fitted, judge);
            clock.lap("regroup", &mut output.stage_times);
        }
        self.drop_small_background(output);
        self.complete(cloud, foreground, output);
        clock.lap("completion", &mut output.stage_times);
    }

    /// Drops what has too few points for an object and is no vehicle.
    fn drop_small_background(&mut self, output: &mut DetectorOutput) {
        let is_kept = |it: &FittedObject| {
            let n_points = it.members.len();
            let is_kept = n_points >= self.min_points || it.decision.is_some_and(|decision| decision > 0.0);
            if !is_kept {
                let reason = DropReason::TooFewPoints;
                output.dropped_clusters.push(DroppedCluster { n_points, reason });
            }
            is_kept
        };
        self.fitted.objects.retain(is_kept);
    }

    fn complete(&mut self, cloud: &PointCloud, foreground: &ForegroundStages, output: &mut DetectorOutput) {
        let FittedObjects { objects, members, .. } = &mut self.fitted;
        let asked = objects.iter().map(|it| {
            let ground_m = foreground.ground_below_m(&it.bounding_box);
            (&it.bounding_box, ground_m, members.point_indices(&it.members))
        });
        let mut added = self.completion.find(cloud, foreground.grid(), asked).iter().peekable();
        for (object, object_idx) in objects.iter_mut().zip(0..) {
            let (n_points, sizes) = (object.members.len(), &foreground.params().vehicle_size);
            let class = match self.model {
                Some(_) => class_by_decision(object.decision, n_points, self.min_vehicle_points),
                None => size_gate(n_points, &object.bounding_box, sizes),
            };
            self.point_indices.clear();
            let mut own = members.point_indices(&object.members);
            while let Some(&[_, point_idx]) = added.next_if(|[of_object, _]| *of_object == object_idx) {
                // Rarely more than some points away.
                let n_before = own.iter().position(|it| *it > point_idx).unwrap_or(own.len());
                let (before, behind) = own.split_at(n_before);
                self.point_indices.extend_from_slice(before);
                self.point_indices.push(point_idx);
                own = behind;
                include(&mut object.bounding_box, cloud.z_m()[point_idx as usize]);
            }
            self.point_indices.extend_from_slice(own);
            output.detections.push(Detection {
                point_indices: &self.point_indices,
                bounding_box: object.bounding_box,
                class,
                score: object.decision,
            });
        }
    }

    /// What the stages left behind of the latest scan, which has `n_points` points.
    pub fn stage_products(&self, n_points: usize) -> Vec<StageProduct> {
        let FittedObjects { objects, members, .. } = &self.fitted;
        let hulls = objects.iter().map(|object| self.hull(object)).collect();
        let rectangles = objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        let boxes = objects.iter().map(|object| object.bounding_box).collect();
        let mut products = vec![
            StageProduct { stage: "boxes", name: "hulls", shape: Shape::Contours(hulls) },
            StageProduct { stage: "boxes", name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: "boxes", name: "boxes", shape: Shape::Boxes(boxes) },
        ];
        if let Some(model) = &self.model {
            let positions_m = |it: &FittedObject| members.positions_m(&it.members).iter().copied();
            products
                .extend(model.stage_products(objects.iter().map(|it| (it.bounding_box, positions_m(it)))));
        }
        let clusters = Shape::Clusters(self.object_of_point(n_points));
        products.push(StageProduct { stage: "completion", name: "objects", shape: clusters });
        products
    }

    fn object_of_point(&self, n_points: usize) -> Vec<Option<u32>> {
        let mut object_of_point = vec![None; n_points];
        for (object, object_idx) in self.fitted.objects.iter().zip(0..) {
            for &point_idx in self.fitted.members.point_indices(&object.members) {
                object_of_point[point_idx as usize] = Some(object_idx);
            }
        }
        for &[object_idx, point_idx] in self.completion.added() {
            object_of_point[point_idx as usize] = Some(object_idx);
        }
        object_of_point
    }

    fn hull(&self, object: &FittedObject) -> Vec<[f32; 3]> {
        let [_, _, center_z_m] = object.bounding_box.center_m;
        let bottom_m = center_z_m - object.bounding_box.length_width_height_m[2] / 2.0;
        self.fitted.hull_m(object).iter().map(|&[x, y]| [x, y, bottom_m]).collect()
    }
}

/// Makes a box high enough for a point at this elevation.
fn include(bounding_box: &mut OrientedBox, z_m: f32) {
    let (center_m, height_m) = (&mut bounding_box.center_m[2], &mut bounding_box.length_width_height_m[2]);
    let (low_m, high_m) = (*center_m - 0.5 * *height_m, *center_m + 0.5 * *height_m);
    if z_m < low_m || z_m > high_m {
        let (low_m, high_m) = (low_m.min(z_m), high_m.max(z_m));
        (*center_m, *height_m) = (0.5 * (low_m + high_m), high_m - low_m);
    }
}
