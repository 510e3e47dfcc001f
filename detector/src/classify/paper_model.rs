//! From an object to how surely it is a vehicle, by the values of the paper alone.

use std::sync::LazyLock;

use crate::classify::nu_svm::NuSvm;
use crate::classify::svm_model::SvmModel;
use crate::classify::svm_model_error::SvmModelError;
use crate::describe::paper_features::{N_PAPER_FEATURES, PaperDescriber, PaperFeatures};
use crate::describe::prototype_file::PrototypeFileError;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::AtLine;
use crate::describe::vehicle_features::VehicleDescriber;
use crate::oriented_box::OrientedBox;

/// The decision on what has no points: on the margin of the background.
pub const NO_VEHICLE: f32 = -1.0;

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum PaperModelError {
    /// The prototypes cannot be used.
    #[error("bad prototypes")]
    Prototypes(#[from] AtLine<PrototypeFileError>),
    /// The classifier cannot be used.
    #[error("bad model")]
    Svm(#[from] AtLine<SvmModelError>),
}

/// The paper's features and their classifier, with buffers for one object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperModel {
    describer: PaperDescriber,
    svm: NuSvm<N_PAPER_FEATURES>,
}

impl PaperModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again. It is read when it is
    /// first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<PaperModel> = LazyLock::new(|| {
            let [prototypes, svm] = [
                include_str!("../params/paper_model/prototypes.toml"),
                include_str!("../params/paper_model/model.toml"),
            ];
            PaperModel::from_toml(prototypes, svm).expect("the embedded files are tested")
        });
        SHIPPED.clone()
    }

    /// The same, trained with ν and γ as they are printed, where [`Self::shipped`] has those that are best on held-out drives.
    ///
    /// Paper: VM section 5.
    pub fn as_printed() -> Self {
        static AS_PRINTED: LazyLock<PaperModel> = LazyLock::new(|| {
            let [prototypes, svm] = [
                include_str!("../params/paper_model/as_printed/prototypes.toml"),
                include_str!("../params/paper_model/as_printed/model.toml"),
            ];
            PaperModel::from_toml(prototypes, svm).expect("the embedded files are tested")
        });
        AS_PRINTED.clone()
    }

    /// A model from the text of both of its files.
    ///
    /// # Errors
    ///
    /// [`PaperModelError`] if one of them is of another kind or version, or damaged, or if the classifier was trained
    /// with other prototypes or for other values.
    pub fn from_toml(prototypes: &str, svm: &str) -> Result<Self, PaperModelError> {
        let library = PrototypeLibrary::from_toml(prototypes)?;
        let svm = SvmModel::from_toml(svm, PaperFeatures::NAMES, &VehicleDescriber::name(&library))?;
        Ok(Self { describer: PaperDescriber::new(library), svm: NuSvm::new(&svm) })
    }

    /// What the classifier sees of an object with these points, in the sensor frame. `None` without points.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PAPER_FEATURES]> {
        Some(self.describer.describe(bounding_box, positions_m)?.values())
    }

    /// How surely what is seen like this is a vehicle: above 0 it is one. What shows nothing has the margin of the background.
    pub fn decision_on(&self, values: Option<&[f32; N_PAPER_FEATURES]>) -> f32 {
        values.map_or(NO_VEHICLE, |it| self.svm.decision(it))
    }

    /// What the side profiles of objects are compared with.
    pub fn prototypes(&self) -> &PrototypeLibrary {
        self.describer.library()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROTOTYPES: &str = include_str!("../params/paper_model/prototypes.toml");
    const MODEL: &str = include_str!("../params/paper_model/model.toml");

    #[test]
    fn the_shipped_files_are_models_of_eight_values_one_of_them_with_the_printed_numbers() {
        let printed = [
            include_str!("../params/paper_model/as_printed/prototypes.toml"),
            include_str!("../params/paper_model/as_printed/model.toml"),
        ];
        for ([prototypes, svm], numbers) in
            [([PROTOTYPES, MODEL], (8, 0.2156, 0.4)), (printed, (8, 0.1078, 0.0377))]
        {
            let library = PrototypeLibrary::from_toml(prototypes).unwrap();
            let svm =
                SvmModel::from_toml(svm, PaperFeatures::NAMES, &VehicleDescriber::name(&library)).unwrap();
            assert_eq!((svm.features.len(), svm.gamma, svm.nu), numbers);
        }
        assert_ne!(PaperModel::shipped(), PaperModel::as_printed());
    }

    #[test]
    fn other_prototypes_than_it_was_trained_with_are_refused() {
        let error = PaperModel::from_toml(&PrototypeLibrary::drawn().to_toml(), MODEL).unwrap_err();
        let error = std::error::Error::source(&error).expect("what is bad about it").to_string();
        let shipped = PrototypeLibrary::from_toml(PROTOTYPES).unwrap();
        for checksum in [PrototypeLibrary::drawn().checksum(), shipped.checksum()] {
            assert!(error.contains("line 4") && error.contains(&checksum), "{error}");
        }
    }

    #[test]
    fn what_has_no_points_is_no_vehicle() {
        let bounding_box =
            OrientedBox { center_m: [9.0, 0.0, -1.0], length_width_height_m: [4.2, 1.7, 1.3], yaw_rad: 0.0 };
        let mut model = PaperModel::shipped();
        let values = model.values(&bounding_box, std::iter::empty());
        assert_eq!((values, model.decision_on(values.as_ref())), (None, NO_VEHICLE));
    }
}
