//! Judgement of a slice alone.

use detector::{Detections, OrientedBox};
use reports::vocabulary::own_slice::{Extents, SliceBounds};
use reports::vocabulary::reason::{IgnoredAnnotation, IgnoredDetection};
use scans::annotation::LabeledScan;

use super::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};

/// Ignores what is outside of the slice, after everything was matched with everything: so the numbers are those of the slice in
/// a run that judges all. An annotation is outside by its own box and points, and so is a detection that found nothing; one that
/// found an annotation shares its fate.
pub fn judge_only(
    slice: &SliceBounds,
    scan: &LabeledScan,
    detections: &Detections,
    mut assignment: Assignment,
) -> Assignment {
    let is_outside: Vec<bool> = scan
        .annotations
        .iter()
        .map(|it| {
            let length_width_height_m = it.bounding_box.map(|it| it.length_width_height_m);
            let (center_m, n_points) = (it.center_m(&scan.cloud), it.point_indices.len() as u64);
            !slice.holds(&Extents { center_m, length_width_height_m, n_points })
        })
        .collect();
    for (outcome, is_outside) in assignment.annotations.iter_mut().zip(&is_outside) {
        if *is_outside && *outcome != AnnotationOutcome::NotAsked {
            *outcome = AnnotationOutcome::Ignored(IgnoredAnnotation::OutsideSlice);
        }
    }
    for (outcome, detection) in assignment.detections.iter_mut().zip(detections.iter()) {
        let OrientedBox { center_m, length_width_height_m, .. } = detection.bounding_box;
        let extents = Extents {
            center_m: Some(center_m),
            length_width_height_m: Some(length_width_height_m),
            n_points: detection.point_indices.len() as u64,
        };
        let ignored = match outcome {
            DetectionOutcome::Matched { annotation_idx, .. } if is_outside[*annotation_idx] => {
                Some(IgnoredDetection::OnIgnoredAnnotation)
            }
            DetectionOutcome::False(_) | DetectionOutcome::Unknowable(_) if !slice.holds(&extents) => {
                Some(IgnoredDetection::OutsideSlice)
            }
            _ => None,
        };
        if let Some(reason) = ignored {
            *outcome = DetectionOutcome::Ignored(reason);
        }
    }
    assignment.found_tall.retain(|it| !is_outside[it.annotation_idx]);
    assignment
}
