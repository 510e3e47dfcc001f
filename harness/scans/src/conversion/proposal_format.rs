//! The annotation tools that proposals can be written for.

use reports::vocabulary::named::named;

named! {
    /// The tool that is to open them, by the files it reads.
    pub enum ProposalFormat {
        /// KITTI's object benchmark: `velodyne/*.bin`, `label_2/*.txt`.
        Kitti = "kitti",
        /// labelCloud: `pointclouds/*.bin`, `labels/*.json` in its format `centroid_rel`.
        Labelcloud = "labelcloud",
        /// `SUSTechPOINTS`: a scene with `lidar/*.pcd` and `label/*.json`.
        Sustechpoints = "sustechpoints",
    }
}
