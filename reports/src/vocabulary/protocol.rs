//! The protocols that others publish numbers under.

use crate::vocabulary::named::named;

named! {
    /// A protocol: what counts, what matches what, and which numbers are made of it, as its makers have it.
    pub enum Protocol {
        /// KITTI's object benchmark: average precision of boxes in the image, from above and in space.
        KittiObject = "kitti-object",
        /// nuScenes' detection task: NDS.
        Nuscenes = "nuscenes",
        /// Argoverse 2's detection challenge: CDS.
        Argoverse2 = "argoverse2",
        /// Instances of SemanticKITTI, whatever their class.
        SemanticKitti = "semantic-kitti",
        /// Points of the ground.
        Ground = "ground",
    }
}

/// What the numbers of a protocol are computed from. Protocols of one family share rows, the file of these and the words of
/// tables.
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

impl Protocol {
    /// What its numbers are computed from.
    pub fn family(self) -> ProtocolFamily {
        match self {
            Self::KittiObject => ProtocolFamily::KittiObjects,
            Self::Nuscenes | Self::Argoverse2 => ProtocolFamily::RankedBoxes,
            Self::SemanticKitti => ProtocolFamily::Instances,
            Self::Ground => ProtocolFamily::Ground,
        }
    }
}
