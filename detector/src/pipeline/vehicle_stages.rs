//! What a vehicle model makes of objects: features, decisions, and objects cut and joined by these.

use crate::classify::size_gate::SizeGateParams;
use crate::classify::vehicle_model::{N_FEATURES, VehicleModel};
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::{ObjectRaster, Surroundings};
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::fitted_objects::FittedObjects;
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::regroup::regrouping::{Judge, Regrouping};

/// A vehicle model, with buffers for one scan after another.
#[derive(Debug, Clone)]
pub struct VehicleStages {
    model: VehicleModel,
    bounds: VehicleBoundsParams,
    sizes: SizeGateParams,
    raster: ObjectRaster,
    values: Vec<Option<[f32; N_FEATURES]>>,
    box_fit: ConvexHullBox,
}

impl VehicleStages {
    /// Stages that ask `model` about objects of `min_points` and more.
    pub fn new(model: VehicleModel, params: &HierarchicalParams, min_points: usize) -> Self {
        Self {
            model: model.within(params.vehicle_bounds),
            bounds: params.vehicle_bounds,
            sizes: SizeGateParams { min_points, ..params.vehicle_size.clone() },
            raster: ObjectRaster::new(params.grid.extent_m),
            values: Vec::new(),
            box_fit: ConvexHullBox::default(),
        }
    }

    /// Computes what the model looks at, object by object.
    pub fn describe(&mut self, fitted: &FittedObjects, foreground: &ForegroundStages) {
        let FittedObjects { objects, members, .. } = fitted;
        let Self { model, bounds, raster, .. } = self;
        raster.fill(members.positions_m(&(0..members.len())).iter().copied());
        let values = objects.iter().map(|it| {
            let positions_m = members.positions_m(&it.members).iter().copied();
            let surroundings = surroundings(raster, *bounds, foreground, &it.bounding_box);
            model.values(&it.bounding_box, &surroundings, positions_m)
        });
        self.values.clear();
        self.values.extend(values);
    }

    /// Decides about the objects that [`Self::describe`] was called with.
    pub fn decide(&self, fitted: &mut FittedObjects) {
        for (object, values) in fitted.objects.iter_mut().zip(&self.values) {
            object.decision = Some(self.model.decision_on(values.as_ref()));
        }
    }

    /// Cuts and joins objects that were decided about.
    pub fn regroup(
        &mut self,
        regrouping: &mut Regrouping,
        fitted: &mut FittedObjects,
        foreground: &ForegroundStages,
    ) {
        let Self { model, bounds, sizes, raster, box_fit, .. } = self;
        let surroundings =
            |bounding_box: &OrientedBox| surroundings(raster, *bounds, foreground, bounding_box);
        regrouping.regroup(fitted, Judge { box_fit, model, surroundings, sizes });
    }

    /// What the side profiles of objects are compared with.
    pub fn prototypes(&self) -> &PrototypeLibrary {
        self.model.prototypes()
    }
}

/// What stands around an object. Of those that the model is not asked about, only the ground is found.
fn surroundings(
    raster: &ObjectRaster,
    bounds: VehicleBoundsParams,
    foreground: &ForegroundStages,
    bounding_box: &OrientedBox,
) -> Surroundings {
    let ground_m = foreground.ground_below_m(bounding_box);
    if bounds.allow(bounding_box, ground_m) {
        raster.around(bounding_box, ground_m)
    } else {
        Surroundings { ground_m, ..Surroundings::default() }
    }
}
