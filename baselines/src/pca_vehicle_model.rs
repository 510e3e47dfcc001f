//! The rival of the vehicle model: decides whether an object is a vehicle.

use std::sync::LazyLock;

use detector::OrientedBox;
use detector::classify::model_file::{ModelFile, ModelFileError};
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use detector::describe::object_describer::ObjectDescriber as _;
use detector::describe::trained_file::Provenance;

use crate::pca_features::{N_PCA_FEATURES, PcaDescriber};

/// Kind of the model in its file.
const PCA_MODEL: &str = "pca";

/// Features and their classifier, with buffers for one object after another.
///
/// The classifier is of the same kind as that of the hierarchical detector's model, trained on the same drives, so that a
/// comparison is about the features.
///
/// Paper: VM section 6.
#[derive(Debug, Clone, PartialEq)]
pub struct PcaVehicleModel {
    describer: PcaDescriber,
    svm: NuSvm<N_PCA_FEATURES>,
}

impl PcaVehicleModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again. It is read when it
    /// is first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<PcaVehicleModel> = LazyLock::new(|| {
            let model = PcaVehicleModel::from_bytes(include_bytes!("params/pca.model"));
            model.expect("the embedded file is tested")
        });
        SHIPPED.clone()
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, trained with other constants, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let file = ModelFile::from_bytes(bytes, PCA_MODEL, &PcaDescriber::constants())?;
        let svm = SvmModel::of(&file, PcaDescriber::NAMES)?;
        Ok(Self { describer: PcaDescriber::default(), svm: NuSvm::new(&svm) })
    }

    /// The file of a classifier.
    pub fn file(svm: &SvmModel<N_PCA_FEATURES>, made: Provenance) -> ModelFile {
        svm.put_into(ModelFile::new(PCA_MODEL, made, PcaDescriber::constants()))
    }

    /// The values that the classifier sees of an object with these points, in the sensor frame. `None` without points.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PCA_FEATURES]> {
        self.describer.describe(bounding_box, positions_m)
    }

    /// The decision value of an object with these features: above 0 it is classified as a vehicle.
    pub fn decision_on(&self, values: &[f32; N_PCA_FEATURES]) -> f32 {
        self.svm.decision(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::fit::principal_axes_box::principal_axes_box;

    #[test]
    fn the_shipped_file_is_a_model_and_that_of_the_other_detector_is_none() {
        assert_eq!(PcaVehicleModel::shipped(), PcaVehicleModel::shipped().clone());
        let other = include_bytes!("../../detector/src/params/paper.model");
        let error = PcaVehicleModel::from_bytes(other).unwrap_err().to_string();
        assert_eq!(error, "it is a model of \"paper\", not of \"pca\"");
    }

    #[test]
    fn a_car_and_a_pedestrian_are_distinguished() {
        let steps = |n: u8| (0..n).map(move |it| f32::from(it) / f32::from(n - 1));
        // The near side and the end of a car, in rings.
        let side =
            steps(12).flat_map(|up| steps(80).map(move |along| [8.0 + 4.2 * along, 2.0, -1.5 + 1.3 * up]));
        let end =
            steps(12).flat_map(|up| steps(35).map(move |across| [8.0, 2.0 + 1.7 * across, -1.5 + 1.3 * up]));
        let car: Vec<[f32; 3]> = side.chain(end).collect();
        // The near half of a cylinder as wide as a person.
        let angle = |turn: f32| (std::f32::consts::PI * turn).sin_cos();
        let around =
            |turn: f32, up: f32| [9.0 - 0.25 * angle(turn).0, 2.0 + 0.25 * angle(turn).1, -1.6 + 1.7 * up];
        let person: Vec<[f32; 3]> =
            steps(18).flat_map(|up| steps(20).map(move |turn| around(turn, up))).collect();
        let mut model = PcaVehicleModel::shipped();
        let mut decide = |points: &[[f32; 3]]| {
            let bounding_box = principal_axes_box(points.iter().copied()).unwrap();
            let values = model.values(&bounding_box, points.iter().copied()).unwrap();
            model.decision_on(&values)
        };
        let [car, person] = [decide(&car), decide(&person)];
        assert!(car > 0.0 && person < 0.0, "{car} and {person}");
    }
}
