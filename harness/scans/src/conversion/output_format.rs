//! The formats that can be written.

use std::fmt;

/// How scans are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputFormat {
    /// One recording with clouds and scenes as Foxglove has them.
    Mcap,
    /// KITTI tracking: drives with tracks.
    KittiTracking,
    /// KITTI object: single scans.
    KittiObject,
    /// `SemanticKITTI`: drives with a label for every point.
    SemanticKitti,
}

impl OutputFormat {
    /// The name used on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::KittiTracking => "kitti-tracking",
            Self::KittiObject => "kitti-object",
            Self::SemanticKitti => "semantic-kitti",
        }
    }
}

impl fmt::Display for OutputFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}
