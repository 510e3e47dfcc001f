//! The protocols that others publish numbers under.

use serde::{Deserialize, Serialize};

/// A protocol: what counts, what matches what, and which numbers are made of it, as its makers have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Protocol {
    /// KITTI's object benchmark: average precision of boxes in the image, from above and in space.
    KittiObject,
    /// nuScenes' detection task: NDS.
    Nuscenes,
    /// Argoverse 2's detection challenge: CDS.
    Argoverse2,
    /// Instances of SemanticKITTI, whatever their class.
    SemanticKitti,
    /// Points of the ground.
    Ground,
}

impl Protocol {
    /// All protocols, in the order in which tables list them.
    pub const ALL: [Self; 5] =
        [Self::KittiObject, Self::Nuscenes, Self::Argoverse2, Self::SemanticKitti, Self::Ground];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::KittiObject => "kitti-object",
            Self::Nuscenes => "nuscenes",
            Self::Argoverse2 => "argoverse2",
            Self::SemanticKitti => "semantic-kitti",
            Self::Ground => "ground",
        }
    }

    /// The protocol of this name; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

impl std::fmt::Display for Protocol {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn protocols_are_read_by_the_names_they_are_written_with() {
        check_names(&Protocol::ALL, Protocol::name);
        assert_eq!(Protocol::from_name("argoverse2"), Some(Protocol::Argoverse2));
        assert_eq!(Protocol::from_name("Argoverse2"), None);
    }
}
