//! Logs the scores of detections: how sure a detector is that they are vehicles.

use std::collections::BTreeSet;

use detector::{DetectedClass, Detection, Detections};
use re_sdk_types::components::Radius;
use rerun::{EntityPath, RecordingStream};

use super::error::StreamError;
use super::{archetypes, entity_paths, legend, palette, recording};

/// Logs the boxes of `detections` coloured by their scores, at the current time, and returns their entities. The scores of
/// vehicles are written beside them.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_scores(
    stream: &RecordingStream,
    detector: &str,
    detections: &Detections,
) -> Result<BTreeSet<EntityPath>, StreamError> {
    let mut logged = BTreeSet::new();
    for (class, line_radius_px) in [(DetectedClass::Vehicle, 1.4), (DetectedClass::Object, 0.7)] {
        let of_class: Vec<Detection<'_>> = detections.iter().filter(|it| it.class == class).collect();
        if of_class.is_empty() {
            continue;
        }
        let drawn = archetypes::boxes(of_class.iter().map(|it| it.bounding_box))
            .with_radii([Radius::new_ui_points(line_radius_px)])
            .with_colors(of_class.iter().map(|it| legend::rgba(color(it))))
            .with_labels(of_class.iter().map(label))
            .with_show_labels(
                class == DetectedClass::Vehicle || of_class.iter().any(|it| it.given.is_some()),
            );
        let path = entity_paths::scores_of_class(detector, class);
        recording::log(stream, path.clone(), &drawn)?;
        logged.insert(path);
    }
    Ok(logged)
}

/// Colour of the score; without a score the class alone decides.
fn color(detection: &Detection<'_>) -> palette::Rgb {
    let by_class = match detection.class {
        DetectedClass::Vehicle => f32::INFINITY,
        DetectedClass::Object => f32::NEG_INFINITY,
    };
    palette::score_color(detection.score.unwrap_or(by_class))
}

fn label(detection: &Detection<'_>) -> String {
    match (detection.score, detection.given) {
        (Some(score), None) => format!("{score:.2}"),
        (Some(score), Some(given)) => format!("{} {score:.2}", given.name()),
        (None, _) => detection.class_name().to_owned(),
    }
}
