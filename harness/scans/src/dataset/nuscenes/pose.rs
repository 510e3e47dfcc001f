//! Poses as the tables have them.

use nalgebra::Isometry3;

use crate::dataset::mcap::ros_messages::isometry;

/// Of a translation and a quaternion whose real part comes first. Errors are the rest of a sentence about the file.
pub fn pose(translation: [f64; 3], [w, x, y, z]: [f64; 4]) -> Result<Isometry3<f64>, String> {
    isometry(translation, [x, y, z, w])
}
