//! From an object to how surely it is a vehicle. Shared with baselines that classify as the paper does.

use std::sync::LazyLock;

use crate::classify::nu_svm::NuSvm;
use crate::classify::object_classifier::{NO_VEHICLE, ObjectClassifier};
use crate::classify::svm_model::SvmModel;
use crate::classify::svm_model_error::SvmModelError;
use crate::describe::prototype_file::PrototypeFileError;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::Surroundings;
use crate::describe::trained_file::AtLine;
use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use crate::detection::DetectedClass;
use crate::oriented_box::OrientedBox;

/// Number of values that the model looks at.
pub const N_FEATURES: usize = VehicleFeatures::NAMES.len();

/// Features and their classifier, with buffers for one object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModel {
    describer: VehicleDescriber,
    svm: NuSvm<N_FEATURES>,
    bounds: VehicleBoundsParams,
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum VehicleModelError {
    /// The prototypes cannot be used.
    #[error("bad prototypes")]
    Prototypes(#[from] AtLine<PrototypeFileError>),
    /// The classifier cannot be used.
    #[error("bad model")]
    Svm(#[from] AtLine<SvmModelError>),
}

impl VehicleModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again. It is read when it is
    /// first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<VehicleModel> = LazyLock::new(|| {
            let [prototypes, svm] = [
                include_str!("../params/vehicle_model/prototypes.toml"),
                include_str!("../params/vehicle_model/model.toml"),
            ];
            VehicleModel::from_toml(prototypes, svm).expect("the embedded files are tested")
        });
        SHIPPED.clone()
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
        let bounds = VehicleBoundsParams { enabled: true };
        Self { describer: VehicleDescriber::new(library), svm: NuSvm::new(svm), bounds }
    }

    /// The same model, which is asked about what `bounds` allow.
    pub fn within(self, bounds: VehicleBoundsParams) -> Self {
        Self { bounds, ..self }
    }

    /// What the classifier sees of an object with these points, in the sensor frame, and these surroundings. `None` without
    /// points, or if its size says that it is no vehicle.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        if !self.bounds.allow(bounding_box, surroundings.ground_m) {
            return None;
        }
        Some(self.describer.describe(bounding_box, surroundings, positions_m)?.values())
    }

    /// How surely what is seen like this is a vehicle: above 0 it is one. What shows none has the margin of the background.
    pub fn decision_on(&self, values: Option<&[f32; N_FEATURES]>) -> f32 {
        values.map_or(NO_VEHICLE, |it| self.svm.decision(it))
    }

    /// What the side profiles of objects are compared with.
    pub fn prototypes(&self) -> &PrototypeLibrary {
        self.describer.library()
    }
}

impl ObjectClassifier for VehicleModel {
    fn decision(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> f32 {
        let values = self.values(bounding_box, surroundings, positions_m);
        self.decision_on(values.as_ref())
    }
}

/// What an object of `n_points` is of which a model says this. What has fewer than `min_points` is no vehicle either way: no
/// model is trained on such.
pub fn class_by_decision(decision: Option<f32>, n_points: usize, min_points: usize) -> DetectedClass {
    let is_vehicle = n_points >= min_points && decision.is_some_and(|it| it > 0.0);
    if is_vehicle { DetectedClass::Vehicle } else { DetectedClass::Object }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_files_are_a_model() {
        let library = VehicleModel::shipped().describer;
        assert_ne!(library, VehicleDescriber::new(PrototypeLibrary::drawn()));
    }

    #[test]
    fn other_prototypes_than_it_was_trained_with_are_refused() {
        let svm = include_str!("../params/vehicle_model/model.toml");
        let error = VehicleModel::from_toml(&PrototypeLibrary::drawn().to_toml(), svm).unwrap_err();
        let error = std::error::Error::source(&error).expect("what is bad about it").to_string();
        let shipped =
            PrototypeLibrary::from_toml(include_str!("../params/vehicle_model/prototypes.toml")).unwrap();
        for checksum in [PrototypeLibrary::drawn().checksum(), shipped.checksum()] {
            assert!(error.contains("line 4") && error.contains(&checksum), "{error}");
        }
    }

    #[test]
    fn too_few_points_are_no_vehicle_whatever_they_look_like() {
        let class = |n_points: usize, decision: f32| class_by_decision(Some(decision), n_points, 10);
        assert_eq!(class(9, 2.0), DetectedClass::Object);
        assert_eq!(class(10, 2.0), DetectedClass::Vehicle);
        assert_eq!(class(10, 0.0), DetectedClass::Object);
        assert_eq!(class_by_decision(None, 10, 10), DetectedClass::Object);
    }

    #[test]
    fn what_has_not_the_size_of_a_vehicle_is_not_looked_at() {
        let mut model = VehicleModel::shipped();
        let mut bounding_box =
            OrientedBox { center_m: [9.0, 0.0, -1.0], length_width_height_m: [4.2, 1.7, 1.3], yaw_rad: 0.0 };
        let points_m = || (0..40).map(|it| [7.0 + 0.1 * it as f32, 0.85, -1.0]);
        let surroundings = Surroundings { ground_m: -1.73, ..Surroundings::default() };
        assert!(model.values(&bounding_box, &surroundings, points_m()).is_some());
        bounding_box.length_width_height_m[0] = 15.0;
        assert_eq!(model.values(&bounding_box, &surroundings, points_m()), None);
        assert_eq!(model.decision(&bounding_box, &surroundings, points_m()), NO_VEHICLE);
    }
}
