//! From what became of a scan to rows of the archive.

use detector::detector::DropReason;
use detector::{Detection, OrientedBox};
use evaluation::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};
use evaluation::metrics::counts::{Counts, FalseDetections};
use evaluation::metrics::segmentation_quality::SegmentationQuality;
use evaluation::run::side_by_side::DetectorScan;
use reports::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MatchOutcome};
use reports::match_row::MatchRow;
use reports::scan_row::{ScanNumbers, ScanOutcome, ScanRow, SegmentationNumbers};
use scans::annotation::{LabeledScan, Occlusion};
use scans::dataset::DatasetDescription;

/// The row of one scan, detector and task in `scans.csv`.
pub fn scan_row(
    dataset: &DatasetDescription,
    scan: &LabeledScan,
    result: &DetectorScan,
    assignment: &Assignment,
) -> ScanRow {
    let counts = Counts::of(assignment);
    let segmentation = SegmentationQuality::of(scan, &result.output.detections, assignment);
    let n_dropped = |reasons: &[DropReason]| {
        let dropped = result.output.dropped_clusters.iter();
        dropped.filter(|cluster| reasons.contains(&cluster.reason)).count() as u64
    };
    ScanRow {
        dataset: dataset.id.clone(),
        sequence: scan.id.sequence.clone(),
        scan: scan.id.index,
        detector: result.detector.to_owned(),
        task: assignment.task.name().to_owned(),
        outcome: ScanOutcome::Evaluated(ScanNumbers {
            n_points: scan.cloud.len() as u64,
            latency_ms: Some(result.latency.as_secs_f64() * 1e3),
            counts: counts.scored(FalseDetections::of(&dataset.annotated, assignment.task)),
            n_ignored_annotations: counts.n_ignored_annotations,
            n_ignored_detections: counts.n_ignored_detections,
            n_unknowable_detections: counts.n_unknowable,
            segmentation: SegmentationNumbers {
                n_split: segmentation.n_split,
                n_holding: segmentation.n_holding,
                n_joining: segmentation.n_joining,
                n_touching: segmentation.n_touching,
                over_entropy_nats: segmentation.over_entropy_nats,
                under_entropy_nats: segmentation.under_entropy_nats,
            },
            n_dropped_too_small: n_dropped(&[DropReason::TooFewPoints]),
            n_dropped_too_large: n_dropped(&[DropReason::TooManyPoints, DropReason::TooLarge]),
        }),
    }
}

/// The rows of one scan, detector and task in `matches.csv`: annotations with what found them, then the detections
/// that found none.
pub fn match_rows(
    dataset: &DatasetDescription,
    criterion: &str,
    scan: &LabeledScan,
    result: &DetectorScan,
    assignment: &Assignment,
) -> Vec<MatchRow> {
    let annotation = |idx: usize| annotation_facts(scan, idx);
    let detection = |idx: usize| detection_facts(idx, &result.output.detections.get(idx));
    let of_annotations = assignment.annotations.iter().enumerate().filter_map(|(idx, outcome)| {
        Some(match *outcome {
            AnnotationOutcome::NotAsked => return None,
            AnnotationOutcome::Ignored(reason) => MatchOutcome::IgnoredAnnotation {
                annotation: annotation(idx),
                reason: reason.name().to_owned(),
            },
            AnnotationOutcome::Matched { detection_idx, cost } => {
                let (annotation, detection) = (annotation(idx), detection(detection_idx));
                MatchOutcome::Matched { annotation, detection, cost }
            }
            AnnotationOutcome::Missed(reason) => {
                MatchOutcome::Missed { annotation: annotation(idx), reason: reason.name().to_owned() }
            }
        })
    });
    let of_detections = assignment.detections.iter().enumerate().filter_map(|(idx, outcome)| {
        Some(match outcome {
            DetectionOutcome::NotAsked | DetectionOutcome::Matched { .. } => return None,
            DetectionOutcome::Ignored(reason) => {
                MatchOutcome::IgnoredDetection { detection: detection(idx), reason: reason.name().to_owned() }
            }
            DetectionOutcome::False(reason) => {
                MatchOutcome::False { detection: detection(idx), reason: reason.name().to_owned() }
            }
            DetectionOutcome::Unknowable => MatchOutcome::Unknowable { detection: detection(idx) },
        })
    });
    let row = |outcome| MatchRow {
        dataset: dataset.id.clone(),
        sequence: scan.id.sequence.clone(),
        scan: scan.id.index,
        detector: result.detector.to_owned(),
        task: assignment.task.name().to_owned(),
        criterion: criterion.to_owned(),
        outcome,
    };
    of_annotations.chain(of_detections).map(row).collect()
}

fn annotation_facts(scan: &LabeledScan, annotation_idx: usize) -> AnnotationFacts {
    let annotation = &scan.annotations[annotation_idx];
    AnnotationFacts {
        id: annotation_idx as u64,
        track: annotation.track,
        class: annotation.class.name().to_owned(),
        occlusion: annotation.occlusion.map(Occlusion::name).map(str::to_owned),
        n_points: annotation.point_indices.len() as u64,
        bounding_box: annotation.bounding_box.as_ref().map(box_facts),
    }
}

/// What files say of a detection; its id is its place among those of the scan.
pub fn detection_facts(detection_idx: usize, detection: &Detection<'_>) -> DetectionFacts {
    DetectionFacts {
        id: detection_idx as u64,
        class: detection.class.name().to_owned(),
        score: detection.score,
        n_points: detection.point_indices.len() as u64,
        bounding_box: box_facts(&detection.bounding_box),
    }
}

fn box_facts(bounding_box: &OrientedBox) -> BoxFacts {
    BoxFacts {
        center_m: bounding_box.center_m,
        length_width_height_m: bounding_box.length_width_height_m,
        yaw_rad: bounding_box.yaw_rad,
    }
}
