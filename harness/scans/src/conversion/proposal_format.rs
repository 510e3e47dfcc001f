//! The annotation tools that proposals can be written for.

use std::fmt;

/// The tool that is to open them, by the files it reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProposalFormat {
    /// KITTI's object benchmark: `velodyne/*.bin`, `label_2/*.txt`.
    Kitti,
    /// labelCloud: `pointclouds/*.bin`, `labels/*.json` in its format `centroid_rel`.
    Labelcloud,
    /// `SUSTechPOINTS`: a scene with `lidar/*.pcd` and `label/*.json`.
    Sustechpoints,
}

impl ProposalFormat {
    /// The name used on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kitti => "kitti",
            Self::Labelcloud => "labelcloud",
            Self::Sustechpoints => "sustechpoints",
        }
    }
}

impl fmt::Display for ProposalFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}
