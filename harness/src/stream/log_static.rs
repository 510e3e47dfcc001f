//! Logs what holds for the whole recording.

use rerun::{AnnotationContext, Arrows3D, Points2D, Radius, RecordingStream, ViewCoordinates};

use super::error::StreamError;
use super::{entity_paths, legend, palette, recording};

/// Logs axes, legend and the place of the sensor.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_static(stream: &RecordingStream) -> Result<(), StreamError> {
    recording::log_static(stream, entity_paths::WORLD, &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let context = AnnotationContext::new(legend::class_descriptions());
    recording::log_static(stream, entity_paths::WORLD, &context)?;
    recording::log_static(stream, entity_paths::SENSOR, &forward_arrow())?;
    recording::log_static(stream, entity_paths::LEGEND_COLORS, &drawn_legend())
}

/// Shows where the sensor is and which way the car drives.
fn forward_arrow() -> Arrows3D {
    Arrows3D::from_vectors([[2.5_f32, 0.0, 0.0]])
        .with_colors([legend::rgba(palette::GREY)])
        .with_radii([Radius::new_ui_points(2.0)])
}

fn drawn_legend() -> Points2D {
    let dots = legend::dots();
    Points2D::new(dots.iter().map(|dot| dot.position))
        .with_radii([Radius::new_ui_points(6.0)])
        .with_colors(dots.iter().map(|dot| legend::rgba(dot.color)))
        .with_labels(dots.iter().map(|dot| dot.name))
        .with_show_labels(true)
}
