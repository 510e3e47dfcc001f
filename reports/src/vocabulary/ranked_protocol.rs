//! The protocols that rank boxes and match them by the distance of their centres: nuScenes' and Argoverse 2's.

use serde::{Deserialize, Serialize};

use crate::vocabulary::protocol::Protocol;

/// Distances of centres below which a detection finds an annotation, in metres, in the order of all rows. The third is that
/// of the errors.
pub const PAIR_DISTANCES_M: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Which of [`PAIR_DISTANCES_M`] errors are measured at.
pub const ERROR_DISTANCE: usize = 2;

/// A protocol that ranks boxes and matches them by the distance of their centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RankedProtocol {
    /// nuScenes' detection task.
    Nuscenes,
    /// Argoverse 2's detection challenge.
    Argoverse2,
}

impl RankedProtocol {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Nuscenes, Self::Argoverse2];

    /// The protocol.
    pub fn protocol(self) -> Protocol {
        match self {
            Self::Nuscenes => Protocol::Nuscenes,
            Self::Argoverse2 => Protocol::Argoverse2,
        }
    }

    /// The one that `protocol` is; `None` if it does not rank boxes.
    pub fn of(protocol: Protocol) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.protocol() == protocol)
    }

    /// The metrics that it is known by.
    pub fn principal_metrics(self) -> &'static [&'static str] {
        match self {
            Self::Nuscenes => &["ap", "nds"],
            Self::Argoverse2 => &["ap", "cds"],
        }
    }

    /// The classes that are evaluated, in the makers' order.
    pub fn classes(self) -> &'static [&'static str] {
        match self {
            Self::Nuscenes => &NUSCENES_CLASSES,
            Self::Argoverse2 => &ARGOVERSE2_CLASSES,
        }
    }

    /// The class of this name; `None` if it is not evaluated.
    pub fn class_named(self, name: &str) -> Option<&'static str> {
        self.classes().iter().copied().find(|it| *it == name)
    }
}

const NUSCENES_CLASSES: [&str; 10] = [
    "car",
    "truck",
    "bus",
    "trailer",
    "construction_vehicle",
    "pedestrian",
    "motorcycle",
    "bicycle",
    "traffic_cone",
    "barrier",
];

const ARGOVERSE2_CLASSES: [&str; 26] = [
    "ARTICULATED_BUS",
    "BICYCLE",
    "BICYCLIST",
    "BOLLARD",
    "BOX_TRUCK",
    "BUS",
    "CONSTRUCTION_BARREL",
    "CONSTRUCTION_CONE",
    "DOG",
    "LARGE_VEHICLE",
    "MESSAGE_BOARD_TRAILER",
    "MOBILE_PEDESTRIAN_CROSSING_SIGN",
    "MOTORCYCLE",
    "MOTORCYCLIST",
    "PEDESTRIAN",
    "REGULAR_VEHICLE",
    "SCHOOL_BUS",
    "SIGN",
    "STOP_SIGN",
    "STROLLER",
    "TRUCK",
    "TRUCK_CAB",
    "VEHICULAR_TRAILER",
    "WHEELCHAIR",
    "WHEELED_DEVICE",
    "WHEELED_RIDER",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_protocols() {
        for it in RankedProtocol::ALL {
            assert_eq!(serde_json::to_string(&it).unwrap(), format!("{:?}", it.protocol().name()));
        }
        assert_eq!(RankedProtocol::Nuscenes.class_named("bus"), Some("bus"));
        assert_eq!(RankedProtocol::Argoverse2.class_named("bus"), None);
    }
}
