//! The classes of SemanticKITTI whose objects are told from one another.

use serde::{Deserialize, Serialize};

/// A class of things, as the panoptic task of SemanticKITTI has them.
///
/// Source: semantic-kitti-api, `config/semantic-kitti.yaml`, numbers 1 to 8 of `learning_map`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ThingClass {
    /// Cars and vans.
    Car,
    /// Bicycles that nobody rides.
    Bicycle,
    /// Motorcycles that nobody rides.
    Motorcycle,
    /// Trucks.
    Truck,
    /// Buses, trams, trailers and the like.
    OtherVehicle,
    /// People on foot.
    Person,
    /// Bicycles with their riders.
    Bicyclist,
    /// Motorcycles with their riders.
    Motorcyclist,
}

impl ThingClass {
    /// All classes, in the order of their numbers.
    pub const ALL: [Self; 8] = [
        Self::Car,
        Self::Bicycle,
        Self::Motorcycle,
        Self::Truck,
        Self::OtherVehicle,
        Self::Person,
        Self::Bicyclist,
        Self::Motorcyclist,
    ];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Bicycle => "bicycle",
            Self::Motorcycle => "motorcycle",
            Self::Truck => "truck",
            Self::OtherVehicle => "other-vehicle",
            Self::Person => "person",
            Self::Bicyclist => "bicyclist",
            Self::Motorcyclist => "motorcyclist",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn classes_are_read_by_the_names_they_are_written_with() {
        check_names(&ThingClass::ALL, ThingClass::name);
    }
}
