//! From an object to how surely it is a vehicle. Shared with baselines that classify as the paper does.

use crate::classify::nu_svm::NuSvm;
use crate::classify::object_classifier::ObjectClassifier;
use crate::classify::size_gate::{SizeGateParams, size_gate};
use crate::classify::svm_model::{SvmModel, SvmModelError};
use crate::describe::prototype_file::PrototypeFileError;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::AtLine;
use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use crate::detection::DetectedClass;
use crate::oriented_box::OrientedBox;
use crate::stage_product::{Shape, StageProduct};

/// Number of values that the model looks at.
pub const N_FEATURES: usize = VehicleFeatures::NAMES.len();

/// Features and their classifier, with buffers for one object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModel {
    describer: VehicleDescriber,
    svm: NuSvm<N_FEATURES>,
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum VehicleModelError {
    /// The prototypes cannot be used.
    #[error("prototypes: {0}")]
    Prototypes(#[from] AtLine<PrototypeFileError>),
    /// The classifier cannot be used.
    #[error("model: {0}")]
    Svm(#[from] AtLine<SvmModelError>),
}

impl VehicleModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again.
    pub fn shipped() -> Self {
        let [prototypes, svm] = [
            include_str!("../params/vehicle_model/prototypes.toml"),
            include_str!("../params/vehicle_model/model.toml"),
        ];
        Self::from_toml(prototypes, svm).expect("the embedded files are tested")
    }

    /// A model from the text of both of its files.
    ///
    /// # Errors
    ///
    /// [`VehicleModelError`] if one of them is of another kind or version, or damaged, or if the classifier was trained
    /// with other prototypes.
    pub fn from_toml(prototypes: &str, svm: &str) -> Result<Self, VehicleModelError> {
        let library = PrototypeLibrary::from_toml(prototypes)?;
        let svm = SvmModel::from_toml(svm, VehicleFeatures::NAMES, &VehicleDescriber::name(&library))?;
        Ok(Self::new(library, &svm))
    }

    /// A model from the prototypes and the classifier that was trained with them.
    pub fn new(library: PrototypeLibrary, svm: &SvmModel<N_FEATURES>) -> Self {
        Self { describer: VehicleDescriber::new(library), svm: NuSvm::new(svm) }
    }

    /// What the classifier sees of an object with these points, in the sensor frame, above ground of elevation `ground_m`. `None`
    /// without points.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        ground_m: f32,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        Some(self.describer.describe(bounding_box, ground_m, positions_m)?.values())
    }

    /// How surely what is seen like this is a vehicle: above 0 it is one.
    pub fn decision_on(&self, values: &[f32; N_FEATURES]) -> f32 {
        self.svm.decision(values)
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

impl ObjectClassifier for VehicleModel {
    fn decision(
        &mut self,
        bounding_box: &OrientedBox,
        ground_m: f32,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<f32> {
        let values = self.values(bounding_box, ground_m, positions_m)?;
        Some(self.decision_on(&values))
    }
}

/// What an object with these points in a box above ground of some elevation is, by `model` (VM sections 4 and 5), with how sure that is; by its size if there is
/// no model. What has fewer points than a vehicle has by `sizes` is none either way: no model is trained on such.
pub fn classify_object(
    model: Option<&mut impl ObjectClassifier>,
    (bounding_box, ground_m): (&OrientedBox, f32),
    positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    sizes: &SizeGateParams,
) -> (DetectedClass, Option<f32>) {
    let n_points = positions_m.len();
    let Some(model) = model else { return (size_gate(n_points, bounding_box, sizes), None) };
    let decision = model.decision(bounding_box, ground_m, positions_m);
    (class_by_decision(decision, n_points, sizes), decision)
}

/// What an object is of which a model says this.
pub fn class_by_decision(decision: Option<f32>, n_points: usize, sizes: &SizeGateParams) -> DetectedClass {
    let is_vehicle = n_points >= sizes.min_points && decision.is_some_and(|it| it > 0.0);
    if is_vehicle { DetectedClass::Vehicle } else { DetectedClass::Object }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    #[test]
    fn the_shipped_files_are_a_model() {
        let library = VehicleModel::shipped().describer;
        assert_ne!(library, VehicleDescriber::new(PrototypeLibrary::drawn()));
    }

    #[test]
    fn other_prototypes_than_it_was_trained_with_are_refused() {
        let svm = include_str!("../params/vehicle_model/model.toml");
        let error =
            VehicleModel::from_toml(&PrototypeLibrary::drawn().to_toml(), svm).unwrap_err().to_string();
        let shipped =
            PrototypeLibrary::from_toml(include_str!("../params/vehicle_model/prototypes.toml")).unwrap();
        for checksum in [PrototypeLibrary::drawn().checksum(), shipped.checksum()] {
            assert!(error.contains("line 4") && error.contains(&checksum), "{error}");
        }
    }

    #[test]
    fn too_few_points_are_no_vehicle_whatever_they_look_like() {
        let sizes = HierarchicalParams::paper().vehicle_size;
        let bounding_box =
            OrientedBox { center_m: [9.0, 0.0, -1.0], length_width_height_m: [4.2, 1.7, 1.3], yaw_rad: 0.0 };
        let points_m = |n: usize| (0..n).map(move |it| [7.0 + 4.0 * it as f32 / n as f32, 0.85, -1.0]);
        let mut model = VehicleModel::shipped();
        let few = points_m(sizes.min_points - 1);
        let (class, score) = classify_object(Some(&mut model), (&bounding_box, -1.73), few, &sizes);
        assert_eq!(class, DetectedClass::Object);
        assert!(score.is_some_and(f32::is_finite));
        let (class, score) =
            classify_object(None::<&mut VehicleModel>, (&bounding_box, -1.73), points_m(100), &sizes);
        assert_eq!((class, score), (DetectedClass::Vehicle, None));
    }
}
