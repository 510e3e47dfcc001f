//! The decision which road user an object is. Baselines share it.

use std::sync::{Arc, LazyLock};

use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::classify::road_user_forests::RoadUserForests;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::Surroundings;
use crate::describe::trained_file::Provenance;
use crate::describe::vehicle_features::{N_FEATURES, VEHICLE_FEATURES, VehicleDescriber};
use crate::detection::GivenClass;
use crate::oriented_box::OrientedBox;
use crate::road_user::{MayBe, RoadUserOdds};

/// Kind of a model of clusters in its file.
pub const CLUSTER_MODEL: &str = "clusters";

/// Features and their classifier, with buffers for one object after another.
///
/// The paper has a support vector machine for its eight values, as [`PaperModel`](super::paper_model::PaperModel) has; here
/// are more values, and boosted trees like those that classify the vehicles of the tree of groupings.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModel {
    describer: VehicleDescriber,
    forests: Arc<RoadUserForests<N_FEATURES>>,
    bounds: VehicleBoundsParams,
}

impl VehicleModel {
    /// The model that comes with the program, trained on simulated streets. `.ci/train` makes it again. It is read when it
    /// is first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<VehicleModel> = LazyLock::new(|| {
            let model = VehicleModel::from_bytes(include_bytes!("../params/clusters.model"));
            model.expect("the embedded file is tested")
        });
        SHIPPED.clone()
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let file = ModelFile::from_bytes(bytes, CLUSTER_MODEL, &toml::Table::new())?;
        Ok(Self::new(file.prototypes()?, RoadUserForests::of(&file, VEHICLE_FEATURES)?))
    }

    /// A model from the prototypes and the forests that were trained with them.
    pub fn new(library: PrototypeLibrary, forests: RoadUserForests<N_FEATURES>) -> Self {
        let bounds = VehicleBoundsParams { enabled: true };
        Self { describer: VehicleDescriber::new(library), forests: Arc::new(forests), bounds }
    }

    /// The file of this model.
    pub fn to_file(&self, made: Provenance) -> ModelFile {
        let file = ModelFile::new(CLUSTER_MODEL, made, toml::Table::new()).with_prototypes(self.prototypes());
        self.forests.in_file(file, VEHICLE_FEATURES)
    }

    /// Restricts the model to objects that `bounds` allow.
    pub fn within(self, bounds: VehicleBoundsParams) -> Self {
        Self { bounds, ..self }
    }

    /// The classes that an object with this box may have, above ground of elevation `ground_m`.
    pub fn may_be(&self, bounding_box: &OrientedBox, ground_m: f32) -> MayBe {
        self.bounds.allow(bounding_box, ground_m)
    }

    /// The values that the classifier sees of an object with these points, in the sensor frame, and these surroundings.
    /// `None` without points, or if its size says that it is no road user.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        if !self.may_be(bounding_box, surroundings.ground_m).allows_any() {
            return None;
        }
        self.describer.describe(bounding_box, surroundings, positions_m)
    }

    /// The classes that its objects may be given.
    pub fn given_classes(&self) -> Vec<GivenClass> {
        self.forests.given_classes()
    }

    /// The same for vehicles alone.
    pub fn of_vehicles(self) -> Self {
        let forests = RoadUserForests { pedestrians: None, cyclists: None, ..(*self.forests).clone() };
        Self { forests: Arc::new(forests), ..self }
    }

    /// The odds of an object with these features that may be of some classes; [`RoadUserOdds::NONE`] without features.
    pub fn odds(&self, may_be: MayBe, values: Option<&[f32; N_FEATURES]>) -> RoadUserOdds {
        values.map_or(RoadUserOdds::NONE, |it| self.forests.odds(may_be, it))
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
    fn the_shipped_file_is_a_model_that_comes_back_from_its_file() {
        let model = VehicleModel::shipped();
        assert_eq!(
            VehicleModel::from_bytes(&model.to_file(Provenance::default()).to_bytes()).unwrap(),
            model
        );
    }

    #[test]
    fn the_model_of_groupings_is_refused() {
        let error = VehicleModel::from_bytes(include_bytes!("../params/groupings.model")).unwrap_err();
        assert_eq!(error.to_string(), "it is a model of \"groupings\", not of \"clusters\"");
    }

    #[test]
    fn what_has_not_the_size_of_a_road_user_is_not_looked_at() {
        let mut model = VehicleModel::shipped();
        let mut bounding_box =
            OrientedBox { center_m: [9.0, 0.0, -1.0], length_width_height_m: [4.2, 1.7, 1.3], yaw_rad: 0.0 };
        let points_m = || (0..40).map(|it| [7.0 + 0.1 * it as f32, 0.85, -1.0]);
        let surroundings = Surroundings { ground_m: -1.73, ..Surroundings::default() };
        assert!(model.values(&bounding_box, &surroundings, points_m()).is_some());
        bounding_box.length_width_height_m[0] = 15.0;
        assert_eq!(model.values(&bounding_box, &surroundings, points_m()), None);
        assert_eq!(model.odds(MayBe::ALL, None), RoadUserOdds::NONE);
    }
}
