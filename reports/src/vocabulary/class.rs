//! What objects are: as people annotate them, and as detectors take them.

use serde::{Deserialize, Serialize};

/// What an annotated object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnnotationClass {
    /// Passenger car.
    Car,
    /// Van or large people carrier.
    Van,
    /// Truck.
    Truck,
    /// Bus.
    Bus,
    /// Person on foot.
    Pedestrian,
    /// Person sitting.
    SittingPerson,
    /// Bicycle or motorcycle with its rider.
    Cyclist,
    /// Bicycle or motorcycle without a rider.
    ParkedCycle,
    /// Tram or train.
    Tram,
    /// Trailer.
    Trailer,
    /// Pole, lamp post, traffic light or sign.
    Pole,
    /// Trunk and crown of a tree.
    Tree,
    /// Hedge or bush.
    Hedge,
    /// Fence or railing.
    Fence,
    /// Mail box, bin, bench, advertising column and the like.
    StreetFurniture,
    /// Labelled, but none of the above.
    Misc,
}

impl AnnotationClass {
    /// All classes, in the order in which tables list them.
    pub const ALL: [Self; 16] = [
        Self::Car,
        Self::Van,
        Self::Truck,
        Self::Bus,
        Self::Pedestrian,
        Self::SittingPerson,
        Self::Cyclist,
        Self::ParkedCycle,
        Self::Tram,
        Self::Trailer,
        Self::Pole,
        Self::Tree,
        Self::Hedge,
        Self::Fence,
        Self::StreetFurniture,
        Self::Misc,
    ];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Van => "van",
            Self::Truck => "truck",
            Self::Bus => "bus",
            Self::Pedestrian => "pedestrian",
            Self::SittingPerson => "sitting-person",
            Self::Cyclist => "cyclist",
            Self::ParkedCycle => "parked-cycle",
            Self::Tram => "tram",
            Self::Trailer => "trailer",
            Self::Pole => "pole",
            Self::Tree => "tree",
            Self::Hedge => "hedge",
            Self::Fence => "fence",
            Self::StreetFurniture => "street-furniture",
            Self::Misc => "misc",
        }
    }
}

/// What a detector takes an object for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DetectionClass {
    /// A free-standing thing on the street that is not known to be a vehicle.
    Object,
    /// A car, van, truck or bus.
    Vehicle,
}

impl DetectionClass {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Object, Self::Vehicle];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Vehicle => "vehicle",
        }
    }
}

/// How much of an object is hidden by others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Occlusion {
    /// Less than a tenth.
    None,
    /// Up to a half.
    Partly,
    /// More than a half.
    Largely,
}

impl Occlusion {
    /// All, from the least on.
    pub const ALL: [Self; 3] = [Self::None, Self::Partly, Self::Largely];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Partly => "partly",
            Self::Largely => "largely",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn classes_are_read_by_the_names_they_are_written_with() {
        check_names(&AnnotationClass::ALL, AnnotationClass::name);
        check_names(&DetectionClass::ALL, DetectionClass::name);
        check_names(&Occlusion::ALL, Occlusion::name);
    }
}
