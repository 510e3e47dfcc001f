//! Single objects, cut out of scans or read from folders.

use detector::PointCloud;
use reports::vocabulary::partial_class::PartialClass;

pub mod uncover;
pub mod growing_cloud;
pub mod object_cloud_set;
pub mod class_of_folder;
pub mod object_sheet;
pub mod class_folders;
pub mod cut_out;
pub mod cut_out_objects;

/// The points of one object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectCloud {
    /// Its name, unique within its data set.
    pub id: String,
    /// Its class.
    pub class: PartialClass,
    /// Its points without the ground: z up, in metres above the ground under it; x and y from any origin.
    pub cloud: PointCloud,
}
