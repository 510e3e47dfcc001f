//! What a vehicle model makes of objects: features and decisions.

use crate::classify::vehicle_model::{N_FEATURES, VehicleModel};
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::{ObjectRaster, Surroundings};
use crate::fit::fitted_objects::FittedObjects;
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;

/// A vehicle model, with buffers for one scan after another.
#[derive(Debug, Clone)]
pub struct VehicleStages {
    model: VehicleModel,
    bounds: VehicleBoundsParams,
    raster: ObjectRaster,
    values: Vec<Option<[f32; N_FEATURES]>>,
}

impl VehicleStages {
    /// Stages that ask `model`.
    pub fn new(model: VehicleModel, params: &HierarchicalParams) -> Self {
        Self {
            model: model.within(params.vehicle_bounds),
            bounds: params.vehicle_bounds,
            raster: ObjectRaster::new(params.grid.extent_m),
            values: Vec::new(),
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
