//! From an object to how surely it is a vehicle. Shared with baselines that classify as the paper does.

use crate::classify::nu_svm::NuSvm;
use crate::classify::svm_model::SvmModel;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use crate::oriented_box::OrientedBox;
use crate::stage_product::{Shape, StageProduct};

/// Number of values that the model looks at.
pub const N_FEATURES: usize = VehicleFeatures::NAMES.len();

/// Features and their classifier, with buffers for one object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone)]
pub struct VehicleModel {
    describer: VehicleDescriber,
    svm: NuSvm<N_FEATURES>,
}

impl VehicleModel {
    /// A model from the prototypes and the classifier that was trained with them.
    pub fn new(library: PrototypeLibrary, svm: &SvmModel<N_FEATURES>) -> Self {
        Self { describer: VehicleDescriber::new(library), svm: NuSvm::new(svm) }
    }

    /// How surely an object with these points, in the sensor frame, is a vehicle: above 0 it is one. `None` without
    /// points.
    pub fn decision(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<f32> {
        let features = self.describer.describe(bounding_box, positions_m)?;
        Some(self.svm.decision(&features.values()))
    }

    /// What the features of `objects`, boxes with their points, were taken from.
    pub fn stage_products<P: ExactSizeIterator<Item = [f32; 3]>>(
        &self,
        objects: impl Iterator<Item = (OrientedBox, P)>,
    ) -> Vec<StageProduct> {
        let shapes =
            objects.filter_map(|(bounding_box, points_m)| self.describer.shapes(&bounding_box, points_m));
        let (mut spheres, mut convex, mut concave, mut nearest) = (vec![], vec![], vec![], vec![]);
        for it in shapes {
            spheres.extend(it.spheres);
            convex.push(it.convex_m);
            concave.push(it.concave_m);
            nearest.extend(it.nearest_prototype_m);
        }
        let product = |name, shape| StageProduct { stage: "classify", name, shape };
        vec![
            product("corner_spheres", Shape::Spheres(spheres)),
            product("convex_profiles", Shape::Contours(convex)),
            product("concave_profiles", Shape::Contours(concave)),
            product("nearest_prototypes", Shape::Contours(nearest)),
        ]
    }
}
