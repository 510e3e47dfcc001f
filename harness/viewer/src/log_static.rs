//! Logs what holds for the whole recording.

use re_sdk_types::archetypes::{AnnotationContext, Arrows3D, LineStrips3D, Points2D, ViewCoordinates};
use re_sdk_types::components::Radius;
use rerun::RecordingStream;

use super::error::StreamError;
use super::legend::LegendDot;
use super::{entity_paths, legend, palette, recording};

/// Logs axes, legend and the position of the sensor.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_static(stream: &RecordingStream) -> Result<(), StreamError> {
    for frame in [entity_paths::WORLD, entity_paths::SENSOR] {
        recording::log_static(stream, frame, &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    }
    let context = AnnotationContext::new(legend::class_descriptions());
    recording::log_static(stream, entity_paths::WORLD, &context)?;
    recording::log_static(stream, entity_paths::FORWARD, &forward_arrow())?;
    recording::log_static(stream, entity_paths::RANGE_RINGS, &range_rings())?;
    log_legend(stream, true)?;
    recording::log_static(stream, entity_paths::LEGEND_STAGES, &drawn_legend(&legend::stage_dots()))
}

/// Logs the legend of outcomes, or of agreement where nothing is labelled.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_legend(stream: &RecordingStream, is_labelled: bool) -> Result<(), StreamError> {
    let dots = legend::outcome_dots(is_labelled);
    recording::log_static(stream, entity_paths::LEGEND_OUTCOMES, &drawn_legend(&dots))
}

/// Logs the colour of the lines of the detector at `detector_idx` into the legend of outcomes.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_detector_legend(
    stream: &RecordingStream,
    detector: &str,
    detector_idx: usize,
) -> Result<(), StreamError> {
    let dot = legend::detector_dot(detector, detector_idx);
    recording::log_static(stream, entity_paths::legend_of_detector(detector), &drawn_legend(&[dot]))
}

/// Shows where the sensor is and which way the car drives.
fn forward_arrow() -> Arrows3D {
    Arrows3D::from_vectors([[2.5_f32, 0.0, 0.0]])
        .with_colors([legend::rgba(palette::GREY)])
        .with_radii([Radius::new_ui_points(2.0)])
}

/// At 10, 20 and 30 m. An eye that goes along keeps all of them in view.
pub fn range_rings() -> LineStrips3D {
    const N_CORNERS: u8 = 72;
    let ring = |radius_m: f32| {
        (0..=N_CORNERS).map(move |corner| {
            let (sin, cos) = (f32::from(corner) / f32::from(N_CORNERS) * std::f32::consts::TAU).sin_cos();
            [radius_m * cos, radius_m * sin, 0.0]
        })
    };
    LineStrips3D::new([10.0, 20.0, 30.0].map(|radius_m| ring(radius_m).collect::<Vec<_>>()))
        .with_colors([legend::rgba(palette::RANGE_RINGS)])
        .with_radii([Radius::new_ui_points(0.5)])
}

fn drawn_legend(dots: &[LegendDot]) -> Points2D {
    Points2D::new(dots.iter().map(|dot| dot.position))
        .with_radii([Radius::new_ui_points(5.0)])
        .with_colors(dots.iter().map(|dot| legend::rgba(dot.color)))
        .with_labels(dots.iter().map(|dot| dot.name.as_str()))
        .with_show_labels(true)
}
