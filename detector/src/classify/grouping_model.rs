//! Which groups of points are objects, and which objects are road users, by boosted trees.

use std::sync::{Arc, LazyLock};

use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::classify::refinement_forests::{LEAST_EXPECTED_IOU, N_REFINEMENTS, RefinementForests};
use crate::classify::road_user_forests::RoadUserForests;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::Provenance;
use crate::describe::vehicle_features::{N_FEATURES, VEHICLE_FEATURES, joined};
use crate::group::node_context::{CONTEXT_VALUES, N_REFINEMENT_VALUES, OBJECT_COST};
use crate::group::node_values::{N_NODE_VALUES, NODE_VALUES};

/// Number of the values that distinguish vehicles.
pub const N_VEHICLE_VALUES: usize = N_FEATURES + OF_GROUP.len();

/// The [`NODE_VALUES`] that distinguish vehicles, too: all but those that [`VEHICLE_FEATURES`] has from the points, those of
/// the groups that hold this one, and those of the wall on which it lies.
const OF_GROUP: [&str; 22] = [
    "log_points_over_expected",
    "range_m",
    "height_m",
    "share_above_2.0_m",
    "filled_share",
    "n_hull_corners",
    "level",
    "joined_at",
    "n_cuts",
    "n_parts",
    "largest_part_share",
    "second_part_share",
    "wall_share",
    "behind_wall_share",
    "tall_share",
    "covered_share",
    "beside_tall_share",
    "cut_off_share",
    "log_n_cells",
    "ground_before_share",
    "ground_behind_share",
    "tall_around_share",
];

/// The indices of [`OF_GROUP`] among [`NODE_VALUES`].
static INDICES_OF_GROUP: LazyLock<[usize; OF_GROUP.len()]> = LazyLock::new(|| {
    OF_GROUP.map(|name| NODE_VALUES.iter().position(|it| *it == name).expect("the list of names is tested"))
});

/// The names of the values that distinguish vehicles: those of the vehicle model, and those of the group alone. Each is
/// there once.
pub const VEHICLE_VALUES: [&str; N_VEHICLE_VALUES] = joined(VEHICLE_FEATURES, OF_GROUP);

/// The names of the values that a refinement round sees of a group: those of the group, and its context.
pub const REFINEMENT_VALUES: [&str; N_REFINEMENT_VALUES] = joined(NODE_VALUES, CONTEXT_VALUES);

/// Kind of a model of groupings in its file.
pub const GROUPING_MODEL: &str = "groupings";
/// The forests in it.
const OBJECTS: &str = "objects";
const REFINEMENTS: [&str; N_REFINEMENTS] = ["objects, second round", "objects, third round"];

/// All forests, and the prototypes that the one of vehicles was trained with.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupingModel {
    /// The expected IoU of a group with an annotated object.
    pub objects: RefinementForests,
    /// The odds that a group is a road user.
    pub road_users: RoadUserForests<N_VEHICLE_VALUES>,
    /// The prototypes that side profiles are compared with.
    pub library: PrototypeLibrary,
}

impl GroupingModel {
    /// The model that comes with the program, trained on simulated streets. It is read when it is first asked for, and once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<GroupingModel>> = LazyLock::new(|| {
            let model = GroupingModel::from_bytes(include_bytes!("../params/groupings.model"));
            Arc::new(model.expect("the embedded file is tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, trained with other constants, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        Self::of(&ModelFile::from_bytes(bytes, GROUPING_MODEL, &Self::constants())?)
    }

    /// The model that `file` holds.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if a part is missing, looks at other values, or is damaged.
    pub fn of(file: &ModelFile) -> Result<Self, ModelFileError> {
        let [second, third] = REFINEMENTS;
        Ok(Self {
            objects: RefinementForests {
                first: file.forest(OBJECTS, NODE_VALUES)?,
                more: [file.forest(second, REFINEMENT_VALUES)?, file.forest(third, REFINEMENT_VALUES)?],
            },
            road_users: RoadUserForests::of(file, VEHICLE_VALUES)?,
            library: file.prototypes()?,
        })
    }

    /// The file of this model as one of kind `model`, with `more` constants.
    pub fn to_file(&self, model: &str, made: Provenance, more: toml::Table) -> ModelFile {
        let Self { objects, road_users, library } = self;
        let mut constants = Self::constants();
        constants.extend(more);
        let mut file = ModelFile::new(model, made, constants).with_prototypes(library);
        file = file.with_forest(OBJECTS, NODE_VALUES, &objects.first);
        for (name, forest) in REFINEMENTS.into_iter().zip(&objects.more) {
            file = file.with_forest(name, REFINEMENT_VALUES, forest);
        }
        road_users.in_file(file, VEHICLE_VALUES)
    }

    /// Constants that forests are trained with: a program with other values refuses the forests.
    pub fn constants() -> toml::Table {
        let constants =
            [("context_object_cost", OBJECT_COST), ("least_expected_iou_of_refined", LEAST_EXPECTED_IOU)];
        // As they are written here, and not as the nearest number of single precision.
        let as_written = |it: f32| it.to_string().parse::<f64>().expect("a number was printed");
        constants.into_iter().map(|(name, it)| (name.to_owned(), as_written(it).into())).collect()
    }
}

/// The values that distinguish vehicles: those of the object, and those of the group alone. They do not depend on the groups
/// around.
pub fn vehicle_values(features: &[f32; N_FEATURES], node: &[f32; N_NODE_VALUES]) -> [f32; N_VEHICLE_VALUES] {
    let mut values = [0.0; N_VEHICLE_VALUES];
    values[..N_FEATURES].copy_from_slice(features);
    for (value, &index) in values[N_FEATURES..].iter_mut().zip(&*INDICES_OF_GROUP) {
        *value = node[index];
    }
    values
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn vehicles_are_classified_by_values_of_their_names_each_of_them_once() {
        let features = std::array::from_fn(|index| index as f32);
        let node = std::array::from_fn(|index| 100.0 + index as f32);
        let values = vehicle_values(&features, &node);
        for (value, name) in values.into_iter().zip(VEHICLE_VALUES) {
            let found = if value < 100.0 {
                VEHICLE_FEATURES[value as usize]
            } else {
                NODE_VALUES[value as usize - 100]
            };
            assert_eq!(found, name);
        }
        assert_eq!(BTreeSet::from(VEHICLE_VALUES).len(), N_VEHICLE_VALUES);
    }

    #[test]
    fn a_model_comes_back_from_its_file_and_not_with_other_constants() {
        let model = GroupingModel::shipped();
        let file = model.to_file(GROUPING_MODEL, Provenance::default(), toml::Table::new());
        assert_eq!(GroupingModel::from_bytes(&file.to_bytes()).unwrap(), *model);
        let dearer = [("context_object_cost".to_owned(), 0.5.into())].into_iter().collect();
        let file = model.to_file(GROUPING_MODEL, Provenance::default(), dearer);
        let error = GroupingModel::from_bytes(&file.to_bytes()).unwrap_err().to_string();
        let expected =
            "it was trained with context_object_cost = 0.5, and the program has context_object_cost = 0.42";
        assert_eq!(error, expected);
    }

    #[test]
    fn the_shipped_file_is_a_model() {
        assert!(!GroupingModel::shipped().objects.first.trees().is_empty());
    }
}
