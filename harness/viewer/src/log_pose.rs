//! Logs where the sensor is in the world.

use nalgebra::Isometry3;
use re_sdk_types::archetypes::{Clear, LineStrips3D, Transform3D};
use re_sdk_types::components::Radius;
use re_sdk_types::datatypes::Quaternion;
use rerun::RecordingStream;

use super::error::StreamError;
use super::{entity_paths, legend, palette, recording};

/// Logs the pose of the sensor at the current time, and where it was lately; where it is not known the frame of the sensor
/// is the world's.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_pose(
    stream: &RecordingStream,
    world_from_sensor: Option<&Isometry3<f64>>,
    drive_m: &[[f32; 3]],
) -> Result<(), StreamError> {
    let Some(pose) = world_from_sensor else {
        recording::log(stream, entity_paths::DRIVE, &Clear::flat())?;
        return recording::log(stream, entity_paths::SENSOR, &Clear::flat());
    };
    let position_m: [f32; 3] = pose.translation.vector.cast::<f32>().into();
    let turn: [f32; 4] = pose.rotation.coords.cast::<f32>().into();
    let transform = Transform3D::from_translation_rotation(position_m, Quaternion::from_xyzw(turn));
    recording::log(stream, entity_paths::SENSOR, &transform)?;
    let drive = LineStrips3D::new([drive_m])
        .with_radii([Radius::new_ui_points(1.5)])
        .with_colors([legend::rgba(palette::SKY_BLUE)]);
    recording::log(stream, entity_paths::DRIVE, &drive)
}
