//! Which groups of points are objects, and which objects are vehicles, by boosted trees.

use std::sync::{Arc, LazyLock};

use crate::classify::forest::Forest;
use crate::classify::forest_file::{ForestFileError, read_forest};
use crate::classify::object_looks::{N_MORE_LOOKS, ObjectLooks};
use crate::classify::vehicle_model::N_FEATURES;
use crate::describe::prototype_file::PrototypeFileError;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::AtLine;
use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use crate::group::node_context::{CONTEXT_VALUES, N_SECOND_LOOK_VALUES};
use crate::group::node_values::{N_NODE_VALUES, NODE_VALUES, VALUES_OF_LARGER};

/// Number of the values that tell vehicles.
pub const N_VEHICLE_VALUES: usize = N_FEATURES + N_NODE_VALUES - N_OF_LARGER;

/// Number of the values of a group that are of what it would be a part of.
const N_OF_LARGER: usize = VALUES_OF_LARGER.end - VALUES_OF_LARGER.start;

/// The names of the values that tell vehicles: those of the vehicle model, and those of the group alone.
pub const VEHICLE_VALUES: [&str; N_VEHICLE_VALUES] = {
    let all: [&str; N_FEATURES + N_NODE_VALUES] = both(VehicleFeatures::NAMES, NODE_VALUES);
    let mut names = [""; N_VEHICLE_VALUES];
    let mut place = 0;
    while place < N_VEHICLE_VALUES {
        let is_before = place < N_FEATURES + VALUES_OF_LARGER.start;
        names[place] = all[if is_before { place } else { place + N_OF_LARGER }];
        place += 1;
    }
    names
};

/// The names of the values that a second look at a group sees: those of the group, and its context.
pub const SECOND_LOOK_VALUES: [&str; N_SECOND_LOOK_VALUES] = both(NODE_VALUES, CONTEXT_VALUES);

/// What the forest of objects that sees each group alone calls itself in its file.
pub const OBJECTS_PURPOSE: &str = "intersection over union of a group with an object";

/// The same of those that look again, with what the look before said.
pub const MORE_LOOKS_PURPOSES: [&str; N_MORE_LOOKS] = [
    "intersection over union of a group with an object, second look",
    "intersection over union of a group with an object, third look",
];

/// What the forest of vehicles calls itself in its file, with these prototypes.
pub fn vehicles_purpose(library: &PrototypeLibrary) -> String {
    format!("log odds that an object is a vehicle, by {}", VehicleDescriber::name(library))
}

/// All forests, and the prototypes that the one of vehicles was trained with.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupingModel {
    /// What intersection over union with an annotated object is to be expected of a group.
    pub objects: ObjectLooks,
    /// The logarithm of the odds that a group is a vehicle.
    pub vehicles: Forest<N_VEHICLE_VALUES>,
    /// What side profiles are compared with.
    pub library: PrototypeLibrary,
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum GroupingModelError {
    /// The prototypes cannot be used.
    #[error("bad prototypes")]
    Prototypes(#[from] AtLine<PrototypeFileError>),
    /// The forest of objects cannot be used.
    #[error("bad forest of objects")]
    Objects(#[source] AtLine<ForestFileError>),
    /// A forest that looks again cannot be used.
    #[error("bad forest of look {}", .look_idx + 2)]
    MoreLooks {
        /// Which, from 0.
        look_idx: usize,
        /// Why.
        source: AtLine<ForestFileError>,
    },
    /// The forest of vehicles cannot be used.
    #[error("bad forest of vehicles")]
    Vehicles(#[source] AtLine<ForestFileError>),
}

impl GroupingModel {
    /// The model that comes with the program, trained on simulated streets. It is read when it is first asked for, and once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<GroupingModel>> = LazyLock::new(|| {
            let model = GroupingModel::from_toml([
                include_str!("../params/vehicle_model/prototypes.toml"),
                include_str!("../params/grouping_model/objects.toml"),
                include_str!("../params/grouping_model/objects_second_look.toml"),
                include_str!("../params/grouping_model/objects_third_look.toml"),
                include_str!("../params/grouping_model/vehicles.toml"),
            ]);
            Arc::new(model.expect("the embedded files are tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// A model from the text of its files: prototypes, objects, its two further looks, vehicles.
    ///
    /// # Errors
    ///
    /// [`GroupingModelError`] if one of them is of another kind or version, or damaged, or if the forest of vehicles was
    /// trained with other prototypes.
    pub fn from_toml(
        [prototypes, objects, second_look, third_look, vehicles]: [&str; 5],
    ) -> Result<Self, GroupingModelError> {
        let library = PrototypeLibrary::from_toml(prototypes)?;
        let look = |look_idx: usize, text| {
            read_forest(text, MORE_LOOKS_PURPOSES[look_idx], SECOND_LOOK_VALUES)
                .map_err(|source| GroupingModelError::MoreLooks { look_idx, source })
        };
        let first = read_forest(objects, OBJECTS_PURPOSE, NODE_VALUES);
        Ok(Self {
            objects: ObjectLooks {
                first: first.map_err(GroupingModelError::Objects)?,
                more: [look(0, second_look)?, look(1, third_look)?],
            },
            vehicles: read_forest(vehicles, &vehicles_purpose(&library), VEHICLE_VALUES)
                .map_err(GroupingModelError::Vehicles)?,
            library,
        })
    }
}

/// The values that tell vehicles: those of the thing, and those of the group alone. What it is grouped with makes it no other thing.
pub fn vehicle_values(features: &[f32; N_FEATURES], node: &[f32; N_NODE_VALUES]) -> [f32; N_VEHICLE_VALUES] {
    let mut values = [0.0; N_VEHICLE_VALUES];
    let (before, after) = (&node[..VALUES_OF_LARGER.start], &node[VALUES_OF_LARGER.end..]);
    for (value, it) in values.iter_mut().zip(features.iter().chain(before).chain(after)) {
        *value = *it;
    }
    values
}

/// Some names, and others behind them.
const fn both<const A: usize, const B: usize, const N: usize>(
    first: [&'static str; A],
    second: [&'static str; B],
) -> [&'static str; N] {
    let mut names = [""; N];
    let mut place = 0;
    while place < N {
        names[place] = if place < A { first[place] } else { second[place - A] };
        place += 1;
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicles_are_told_by_all_values_but_those_of_wholes_and_walls() {
        let features = std::array::from_fn(|place| place as f32);
        let node = std::array::from_fn(|place| 100.0 + place as f32);
        let values = vehicle_values(&features, &node);
        for (value, name) in values.into_iter().zip(VEHICLE_VALUES) {
            let found = if value < 100.0 {
                VehicleFeatures::NAMES[value as usize]
            } else {
                NODE_VALUES[value as usize - 100]
            };
            assert_eq!(found, name);
        }
        let left_out: Vec<&str> = NODE_VALUES.into_iter().filter(|it| !VEHICLE_VALUES.contains(it)).collect();
        let is_of_larger = |it: &&str| it.contains("whole") || it.contains("of_wall");
        assert!(left_out.iter().all(is_of_larger) && left_out.len() == 6, "{left_out:?}");
    }

    #[test]
    fn the_shipped_files_are_a_model() {
        assert!(!GroupingModel::shipped().objects.first.trees().is_empty());
    }
}
