//! The decision whether an object is a vehicle, by the values of the paper alone.

use std::sync::LazyLock;

use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::classify::nu_svm::NuSvm;
use crate::classify::svm_model::SvmModel;
use crate::describe::object_describer::ObjectDescriber as _;
use crate::describe::paper_features::{N_PAPER_FEATURES, PaperDescriber};
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::Provenance;
use crate::oriented_box::OrientedBox;

/// The decision on an object without points: on the margin of the background.
pub const NO_VEHICLE: f32 = -1.0;

/// Kind of the model in its file.
const PAPER_MODEL: &str = "paper";

/// The paper's features and their classifier, with buffers for one object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperModel {
    describer: PaperDescriber,
    svm: NuSvm<N_PAPER_FEATURES>,
}

impl PaperModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again. It is read when it
    /// is first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<PaperModel> = LazyLock::new(|| {
            let model = PaperModel::from_bytes(include_bytes!("../params/paper.model"));
            model.expect("the embedded file is tested")
        });
        SHIPPED.clone()
    }

    /// The model of the program trained with ν and γ as they are printed, where [`Self::shipped`] has those that are best on
    /// held-out drives.
    ///
    /// Paper: VM section 5.
    pub fn as_printed() -> Self {
        static AS_PRINTED: LazyLock<PaperModel> = LazyLock::new(|| {
            let model = PaperModel::from_bytes(include_bytes!("../params/paper_as_printed.model"));
            model.expect("the embedded file is tested")
        });
        AS_PRINTED.clone()
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        Self::of(&ModelFile::from_bytes(bytes, PAPER_MODEL, &toml::Table::new())?)
    }

    /// The model that `file` holds.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if a part is missing or damaged.
    pub fn of(file: &ModelFile) -> Result<Self, ModelFileError> {
        let svm = SvmModel::of(file, PaperDescriber::NAMES)?;
        Ok(Self { describer: PaperDescriber::new(file.prototypes()?), svm: NuSvm::new(&svm) })
    }

    /// The file of a classifier and the prototypes that it was trained with.
    pub fn file(library: &PrototypeLibrary, svm: &SvmModel<N_PAPER_FEATURES>, made: Provenance) -> ModelFile {
        svm.put_into(ModelFile::new(PAPER_MODEL, made, toml::Table::new()).with_prototypes(library))
    }

    /// The values that the classifier sees of an object with these points, in the sensor frame. `None` without points.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PAPER_FEATURES]> {
        self.describer.describe(bounding_box, positions_m)
    }

    /// The decision value of an object with these values: above 0 it is classified as a vehicle. Without values it is on the
    /// margin of the background.
    pub fn decision_on(&self, values: Option<&[f32; N_PAPER_FEATURES]>) -> f32 {
        values.map_or(NO_VEHICLE, |it| self.svm.decision(it))
    }

    /// The prototypes that the side profiles of objects are compared with.
    pub fn prototypes(&self) -> &PrototypeLibrary {
        self.describer.library()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_files_are_models_one_of_them_with_the_printed_numbers() {
        let shipped: &[u8] = include_bytes!("../params/paper.model");
        let printed: &[u8] = include_bytes!("../params/paper_as_printed.model");
        for (bytes, numbers) in [(shipped, (0.2156, 0.4)), (printed, (0.1078, 0.0377))] {
            let file = ModelFile::from_bytes(bytes, PAPER_MODEL, &toml::Table::new()).unwrap();
            let svm = SvmModel::of(&file, PaperDescriber::NAMES).unwrap();
            assert_eq!((svm.gamma, svm.nu), numbers);
        }
        assert_ne!(PaperModel::shipped(), PaperModel::as_printed());
    }

    #[test]
    fn the_model_of_groupings_is_refused() {
        let error = PaperModel::from_bytes(include_bytes!("../params/groupings.model")).unwrap_err();
        assert_eq!(error.to_string(), "it is a model of \"groupings\", not of \"paper\"");
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
