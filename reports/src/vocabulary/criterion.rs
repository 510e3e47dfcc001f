//! By what detections are matched with annotations.

use serde::{Deserialize, Serialize};

/// What a detection and an annotation are compared by, however alike they have to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CriterionKind {
    /// Their points: what the sensor saw.
    Points,
    /// Their boxes on the ground plan.
    BevIou,
    /// Their boxes in space.
    #[serde(rename = "iou-3d")]
    Iou3d,
    /// The distance of their centres on the ground plan.
    Centre,
}

impl CriterionKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Points, Self::BevIou, Self::Iou3d, Self::Centre];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::BevIou => "bev-iou",
            Self::Iou3d => "iou-3d",
            Self::Centre => "centre",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn criteria_are_read_by_the_names_they_are_written_with() {
        check_names(&CriterionKind::ALL, CriterionKind::name);
    }
}
