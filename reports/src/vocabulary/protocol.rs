//! The protocols that others publish numbers under.

use crate::vocabulary::named::named;

named! {
    /// A protocol: what counts, what matches what, and which numbers are made of it, as its makers have it.
    pub enum Protocol {
        /// KITTI's object benchmark: average precision of boxes in the image, from above and in space.
        KittiObject = "kitti-object",
        /// nuScenes' detection task: NDS.
        Nuscenes = "nuscenes",
        /// The same with one class for all that moves, as detectors without classes are compared.
        NuscenesAgnostic = "nuscenes-agnostic",
        /// Argoverse 2's detection challenge: CDS.
        Argoverse2 = "argoverse2",
        /// Instances of SemanticKITTI, whatever their class.
        SemanticKitti = "semantic-kitti",
        /// Points of the ground.
        Ground = "ground",
    }
}

/// The input that the numbers of a protocol are computed from. Protocols of one family share rows, the file of these and the
/// words of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProtocolFamily {
    /// Boxes and regions that are left out, as KITTI's object benchmark has them.
    KittiObjects,
    /// Ranked boxes, matched by the distance of their centres.
    RankedBoxes,
    /// Labels of the points of objects.
    Instances,
    /// Labels of the points of the ground.
    Ground,
}

/// Distances of centres below which a detection finds an annotation, in metres, in the order of all rows. The third is that
/// of the errors.
pub const PAIR_DISTANCES_M: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Index among [`PAIR_DISTANCES_M`] of the distance of errors.
pub const ERROR_DISTANCE: usize = 2;

/// The only class of the protocol that has one for all that moves.
pub const MOBILE: &str = "mobile";

impl Protocol {
    /// The family of its input.
    pub fn family(self) -> ProtocolFamily {
        match self {
            Self::KittiObject => ProtocolFamily::KittiObjects,
            Self::Nuscenes | Self::NuscenesAgnostic | Self::Argoverse2 => ProtocolFamily::RankedBoxes,
            Self::SemanticKitti => ProtocolFamily::Instances,
            Self::Ground => ProtocolFamily::Ground,
        }
    }

    /// The classes that it evaluates, in the makers' order; none where it does not rank boxes by the distance of centres.
    pub fn ranked_classes(self) -> &'static [&'static str] {
        match self {
            Self::Nuscenes => &NUSCENES_CLASSES,
            Self::NuscenesAgnostic => &[MOBILE],
            Self::Argoverse2 => &ARGOVERSE2_CLASSES,
            Self::KittiObject | Self::SemanticKitti | Self::Ground => &[],
        }
    }

    /// The class of [`Self::ranked_classes`] with this name; `None` if it is not evaluated.
    pub fn class_named(self, name: &str) -> Option<&'static str> {
        self.ranked_classes().iter().copied().find(|it| *it == name)
    }

    /// The metrics that it is known by.
    pub fn principal_metrics(self) -> &'static [&'static str] {
        match self {
            Self::KittiObject => &["ap_3d_moderate_r40", "ap_bev_moderate_r40"],
            Self::Nuscenes | Self::NuscenesAgnostic => &["ap", "nds"],
            Self::Argoverse2 => &["ap", "cds"],
            Self::SemanticKitti => &["s_assoc", "s_assoc_over_50_points", "unknown_quality"],
            Self::Ground => &["f1"],
        }
    }

    /// Published values of these numbers; `None` where nothing is known. `docs/published.md` has more, with sources.
    pub fn published(self) -> Option<&'static str> {
        match self {
            Self::KittiObject => Some(
                "Published, not measured here: PointRCNN has 78.85 % in ap_3d_moderate_r11 and 87.89 % in ap_bev_moderate_r11 of Car on \
                 KITTI's validation split.",
            ),
            Self::SemanticKitti => Some(
                "Published, not measured here: UNIT has 0.715 in s_assoc and 0.811 over 50 points on SemanticKITTI's drive 08.",
            ),
            Self::Ground => Some(
                "Published, not measured here, on SemanticKITTI's drive 08: Patchwork++ has an f1 of 96.74 % by groundgrid and 93.43 % by \
                 patchwork; continuous_clustering has 92.66 % by continuous-clustering.",
            ),
            Self::NuscenesAgnostic => Some(
                "Published, not measured here, on nuScenes' validation split, as UNION (NeurIPS 2024) lists them, ap of HDBSCAN is \
                 13.8 %, of OYSTER 9.1 %, of LISO 10.9 % and of UNION 39.5 %; nds are in docs/published.md.",
            ),
            Self::Nuscenes | Self::Argoverse2 => None,
        }
    }
}

impl ProtocolFamily {
    /// Whether objects have classes that a detector may give or not.
    pub fn has_classes(self) -> bool {
        matches!(self, Self::KittiObjects | Self::RankedBoxes)
    }

    /// The things that its numbers are made of.
    pub fn counted(self) -> &'static str {
        match self {
            Self::KittiObjects | Self::RankedBoxes => "annotations that count",
            Self::Instances => "instances, scans, or segments of a class",
            Self::Ground => "points, or scans",
        }
    }

    /// The remark that its numbers need.
    pub fn remark(self) -> &'static str {
        match self {
            Self::KittiObjects | Self::RankedBoxes => {
                "Detections without a score have 1; detections have the class that their detector gives, vehicles without one are cars."
            }
            Self::Instances => {
                "All points count, whatever their range, and objects of a single point. The entropies are sums over a scan."
            }
            Self::Ground => {
                "class: which labels are ground, by whose definition. Numbers of one are not to be compared with those of another."
            }
        }
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
