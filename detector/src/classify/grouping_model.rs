//! Which groups of points are objects, and which objects are vehicles, by boosted trees.

use std::sync::{Arc, LazyLock};

use crate::classify::forest::Forest;
use crate::classify::forest_file::{ForestFileError, read_forest};
use crate::describe::prototype_file::PrototypeFileError;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::AtLine;
use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use crate::group::node_values::{N_NODE_VALUES, NODE_VALUES};

/// Number of the values that tell vehicles.
pub const N_VEHICLE_VALUES: usize = VehicleFeatures::NAMES.len() + N_NODE_VALUES;

/// The names of the values that tell vehicles: those of the vehicle model, and those of the group.
pub const VEHICLE_VALUES: [&str; N_VEHICLE_VALUES] = {
    let mut names = [""; N_VEHICLE_VALUES];
    let mut place = 0;
    while place < N_VEHICLE_VALUES {
        let n_features = VehicleFeatures::NAMES.len();
        names[place] =
            if place < n_features { VehicleFeatures::NAMES[place] } else { NODE_VALUES[place - n_features] };
        place += 1;
    }
    names
};

/// What the forest of objects calls itself in its file.
pub const OBJECTS_PURPOSE: &str = "intersection over union of a group with an object";

/// What the forest of vehicles calls itself in its file, with these prototypes.
pub fn vehicles_purpose(library: &PrototypeLibrary) -> String {
    format!("log odds that an object is a vehicle, by {}", VehicleDescriber::name(library))
}

/// Both forests, and the prototypes that the second was trained with.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupingModel {
    /// What intersection over union with an annotated object is to be expected of a group.
    pub objects: Forest<N_NODE_VALUES>,
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
                include_str!("../params/grouping_model/vehicles.toml"),
            ]);
            Arc::new(model.expect("the embedded files are tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// A model from the text of its files: prototypes, objects, vehicles.
    ///
    /// # Errors
    ///
    /// [`GroupingModelError`] if one of them is of another kind or version, or damaged, or if the second forest was trained
    /// with other prototypes.
    pub fn from_toml([prototypes, objects, vehicles]: [&str; 3]) -> Result<Self, GroupingModelError> {
        let library = PrototypeLibrary::from_toml(prototypes)?;
        Ok(Self {
            objects: read_forest(objects, OBJECTS_PURPOSE, NODE_VALUES)
                .map_err(GroupingModelError::Objects)?,
            vehicles: read_forest(vehicles, &vehicles_purpose(&library), VEHICLE_VALUES)
                .map_err(GroupingModelError::Vehicles)?,
            library,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_files_are_a_model() {
        assert!(!GroupingModel::shipped().objects.trees().is_empty());
    }
}
