//! The decision whether an object is a vehicle. Baselines that classify as the paper does share it.

use std::sync::{Arc, LazyLock};

use crate::classify::forest::Forest;
use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::surroundings::Surroundings;
use crate::describe::trained_file::Provenance;
use crate::describe::vehicle_features::{N_FEATURES, VEHICLE_FEATURES, VehicleDescriber};
use crate::detection::DetectedClass;
use crate::oriented_box::OrientedBox;

/// The decision for objects that no model needs to judge: less likely a vehicle than any object that is ranked as one.
pub const NO_VEHICLE: f32 = -10.0;

/// Kind of a model of clusters in its file.
pub const CLUSTER_MODEL: &str = "clusters";
/// The forest in it.
const VEHICLES: &str = "vehicles";

/// Features and their classifier, with buffers for one object after another.
///
/// The paper has a support vector machine for its eight values, as [`PaperModel`](super::paper_model::PaperModel) has; here
/// are more values, and boosted trees like those that classify the vehicles of the tree of groupings.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModel {
    describer: VehicleDescriber,
    forest: Arc<Forest<N_FEATURES>>,
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
        Ok(Self::new(file.prototypes()?, file.forest(VEHICLES, VEHICLE_FEATURES)?))
    }

    /// A model from the prototypes and the forest that was trained with them.
    pub fn new(library: PrototypeLibrary, forest: Forest<N_FEATURES>) -> Self {
        let bounds = VehicleBoundsParams { enabled: true };
        Self { describer: VehicleDescriber::new(library), forest: Arc::new(forest), bounds }
    }

    /// The file of this model.
    pub fn to_file(&self, made: Provenance) -> ModelFile {
        let file = ModelFile::new(CLUSTER_MODEL, made, toml::Table::new()).with_prototypes(self.prototypes());
        file.with_forest(VEHICLES, VEHICLE_FEATURES, &self.forest)
    }

    /// Restricts the model to objects that `bounds` allow.
    pub fn within(self, bounds: VehicleBoundsParams) -> Self {
        Self { bounds, ..self }
    }

    /// The values that the classifier sees of an object with these points, in the sensor frame, and these surroundings.
    /// `None` without points, or if its size says that it is no vehicle.
    pub fn values(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        if !self.bounds.allow(bounding_box, surroundings.ground_m) {
            return None;
        }
        self.describer.describe(bounding_box, surroundings, positions_m)
    }

    /// The logarithm of the odds that an object with these features is a vehicle; [`NO_VEHICLE`] without features.
    pub fn decision_on(&self, values: Option<&[f32; N_FEATURES]>) -> f32 {
        values.map_or(NO_VEHICLE, |it| self.forest.sum(it))
    }

    /// The prototypes that the side profiles of objects are compared with.
    pub fn prototypes(&self) -> &PrototypeLibrary {
        self.describer.library()
    }
}

/// Thresholds by which an object that a model judged is a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleRule {
    /// Fewest points: models are trained on larger objects.
    pub least_points: usize,
    /// The decision of the model must be above this.
    pub least_decision: f32,
}

/// The class of an object of `n_points` by the `decision` of a model.
pub fn class_by_decision(decision: Option<f32>, n_points: usize, rule: VehicleRule) -> DetectedClass {
    let is_vehicle = n_points >= rule.least_points && decision.is_some_and(|it| it > rule.least_decision);
    if is_vehicle { DetectedClass::Vehicle } else { DetectedClass::Object }
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
    fn too_few_points_or_too_low_a_decision_are_no_vehicle() {
        let rule = VehicleRule { least_points: 10, least_decision: -0.5 };
        let class = |n_points: usize, decision: f32| class_by_decision(Some(decision), n_points, rule);
        assert_eq!(class(9, 2.0), DetectedClass::Object);
        assert_eq!(class(10, -0.4), DetectedClass::Vehicle);
        assert_eq!(class(10, -0.5), DetectedClass::Object);
        assert_eq!(class_by_decision(None, 10, rule), DetectedClass::Object);
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
        assert_eq!(model.decision_on(None), NO_VEHICLE);
    }
}
