//! The formats that can be written.

use reports::vocabulary::named::named;

named! {
    /// How scans are written.
    pub enum OutputFormat {
        /// One recording with clouds and scenes as Foxglove has them.
        Mcap = "mcap",
        /// KITTI tracking: drives with tracks.
        KittiTracking = "kitti-tracking",
        /// KITTI object: single scans.
        KittiObject = "kitti-object",
        /// `SemanticKITTI`: drives with a label for every point.
        SemanticKitti = "semantic-kitti",
    }
}
