//! Rows of a scan, made of its outcomes; every number of a report is made of rows.

use std::time::Duration;

use detector::detector::{DropReason, StageTime};
use reports::rows::match_outcome::{AnnotationFacts, FoundBy, MatchOutcome};
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use reports::rows::stage_row::StageRow;
use reports::vocabulary::reason::IgnoredAnnotation;
use scans::annotation::{LabeledScan, PointRegion};
use scans::conversion::results::detection_rows::{box_facts, detection_facts};
use scans::dataset::DatasetDescription;

use super::side_by_side::DetectorScan;
use crate::matching::eligibility::n_points_in;
use crate::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};
use crate::metrics::counts::{Counts, FalseDetections};
use crate::metrics::segmentation_quality::segmentation_quality;

/// The rows of one scan and detector.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorRows {
    /// Rows of each task.
    pub tasks: Vec<TaskRows>,
    /// Rows of `stages.csv`, in the order of the stages.
    pub stages: Vec<StageRow>,
}

/// The rows of one scan, detector and task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskRows {
    /// Row of `scans.csv`.
    pub scan: ScanRow,
    /// Rows of `matches.csv`.
    pub matches: Vec<MatchRow>,
}

/// A scan of which rows are made.
#[derive(Debug, Clone, Copy)]
pub struct RowsOf<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Its checksum, as it was read.
    pub checksum: u32,
    /// Seconds since the first scan of its drive, if known.
    pub time_s: Option<f64>,
}

impl DetectorRows {
    /// Makes the rows of the results of a detector on a scan.
    ///
    /// Values are rounded as in the files, so that numbers made of the files equal those of the run to the last digit.
    pub fn new(dataset: &DatasetDescription, of: RowsOf<'_>, result: &DetectorScan) -> Self {
        let scan = of.scan;
        let of_task = |assignment: &Assignment| TaskRows {
            scan: scan_row(dataset, of, result, assignment).as_written(),
            matches: match_rows(dataset, scan, result, assignment)
                .into_iter()
                .map(MatchRow::as_written)
                .collect(),
        };
        Self {
            tasks: result.assignments.iter().map(of_task).collect(),
            stages: stage_rows(dataset, scan, result).into_iter().map(StageRow::as_written).collect(),
        }
    }
}

fn stage_rows(dataset: &DatasetDescription, scan: &LabeledScan, result: &DetectorScan) -> Vec<StageRow> {
    let row = |time: &StageTime| StageRow {
        dataset: dataset.id.clone(),
        sequence: scan.id.sequence.clone(),
        scan: scan.id.index,
        detector: result.detector.to_owned(),
        stage: time.stage.to_owned(),
        time_ms: ms(time.duration),
    };
    result.output.stage_times.iter().map(row).collect()
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Row of `result` on a scan in the task of `assignment`.
pub(crate) fn scan_row(
    dataset: &DatasetDescription,
    RowsOf { scan, checksum, time_s }: RowsOf<'_>,
    result: &DetectorScan,
    assignment: &Assignment,
) -> ScanRow {
    let counts = Counts::of(assignment);
    // The times are those of the whole detection, and stand in the rows of all objects.
    let time_ms = |time: Option<Duration>| time.filter(|_| assignment.task.class().is_none()).map(ms);
    let counted = result.times.count.filter(|_| assignment.task.class().is_none());
    let n_dropped = |reasons: &[DropReason]| {
        let dropped = result.output.dropped_clusters.iter();
        dropped.filter(|cluster| reasons.contains(&cluster.reason)).count() as u64
    };
    ScanRow {
        dataset: dataset.id.clone(),
        sequence: scan.id.sequence.clone(),
        scan: scan.id.index,
        time_s,
        detector: result.detector.to_owned(),
        task: assignment.task,
        outcome: ScanOutcome::Evaluated(ScanNumbers {
            n_points: scan.cloud.len() as u64,
            checksum,
            failure: result.failure.as_ref().map(|it| it.problem.to_string()),
            latency_ms: time_ms(result.times.first),
            least_latency_ms: time_ms(result.times.least),
            reference_ms: time_ms(result.times.reference),
            cpu_ms: time_ms(result.times.cpu),
            overhead_ms: time_ms(result.times.overhead),
            n_instructions: counted.and_then(|it| it.n_instructions),
            peak_bytes: counted.and_then(|it| it.peak_bytes),
            counts: counts.scored(FalseDetections::of(&dataset.annotated, assignment.task)),
            n_ignored_annotations: counts.n_ignored_annotations,
            n_ignored_detections: counts.n_ignored_detections,
            n_unknowable_detections: counts.n_unknowable,
            segmentation: segmentation_quality(scan, &result.output.detections, assignment),
            n_dropped_too_small: n_dropped(&[DropReason::TooFewPoints]),
            n_dropped_too_large: n_dropped(&[DropReason::TooManyPoints, DropReason::TooLarge]),
        }),
    }
}

/// Annotations with the detections that found them, then the detections that found none. A tall annotation shares a row
/// with the detection that found it, if there is one.
fn match_rows(
    dataset: &DatasetDescription,
    scan: &LabeledScan,
    result: &DetectorScan,
    assignment: &Assignment,
) -> Vec<MatchRow> {
    let annotation = |idx: usize| annotation_facts(scan, idx);
    let detection = |idx: usize| detection_facts(idx, &result.output.detections.get(idx));
    let of_annotations = assignment.annotations.iter().enumerate().filter_map(|(idx, outcome)| {
        Some(match *outcome {
            AnnotationOutcome::NotAsked => return None,
            AnnotationOutcome::Ignored(IgnoredAnnotation::Tall) => {
                let found = assignment.found_tall.iter().find(|it| it.annotation_idx == idx);
                let found_by =
                    found.map(|it| FoundBy { detection: detection(it.detection_idx), cost: it.cost });
                MatchOutcome::Tall { annotation: annotation(idx), found_by }
            }
            AnnotationOutcome::Ignored(reason) => {
                MatchOutcome::IgnoredAnnotation { annotation: annotation(idx), reason }
            }
            AnnotationOutcome::Matched { detection_idx, cost } => {
                let (annotation, detection) = (annotation(idx), detection(detection_idx));
                MatchOutcome::Matched { annotation, detection, cost }
            }
            AnnotationOutcome::Missed(reason) => MatchOutcome::Missed { annotation: annotation(idx), reason },
        })
    });
    let mut is_listed = vec![false; assignment.detections.len()];
    for found in &assignment.found_tall {
        is_listed[found.detection_idx] = true;
    }
    let remaining = assignment.detections.iter().enumerate().filter(|(idx, _)| !is_listed[*idx]);
    let of_detections = remaining.filter_map(|(idx, outcome)| {
        Some(match *outcome {
            DetectionOutcome::NotAsked | DetectionOutcome::Matched { .. } => return None,
            DetectionOutcome::Ignored(reason) => {
                MatchOutcome::IgnoredDetection { detection: detection(idx), reason }
            }
            DetectionOutcome::False(reason) => MatchOutcome::False { detection: detection(idx), reason },
            DetectionOutcome::Unknowable(agreement) => {
                MatchOutcome::Unknowable { detection: detection(idx), agreement }
            }
        })
    });
    let row = |outcome| MatchRow {
        dataset: dataset.id.clone(),
        sequence: scan.id.sequence.clone(),
        scan: scan.id.index,
        detector: result.detector.to_owned(),
        task: assignment.task,
        criterion: assignment.criterion,
        outcome,
    };
    of_annotations.chain(of_detections).map(row).collect()
}

fn annotation_facts(scan: &LabeledScan, annotation_idx: usize) -> AnnotationFacts {
    let annotation = &scan.annotations[annotation_idx];
    AnnotationFacts {
        id: annotation_idx as u64,
        track: annotation.track,
        class: annotation.class,
        occlusion: annotation.occlusion,
        n_points: annotation.point_indices.len() as u64,
        n_points_outside: n_points_in(scan, annotation, PointRegion::Outside) as u64,
        bounding_box: annotation.bounding_box.as_ref().map(box_facts),
        centroid_m: match annotation.bounding_box {
            Some(_) => None,
            None => annotation.center_m(&scan.cloud),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use detector::{DetectedClass, Detection, DetectorOutput, OrientedBox, PointCloud};
    use reports::numbers::tally::Tally;
    use reports::vocabulary::metric::Metric;
    use reports::vocabulary::slice::Slice;

    use crate::matching::assign::{MatchingParams, assign};
    use crate::matching::criterion::Criterion;
    use crate::matching::eligibility::EligibilityParams;
    use crate::run::side_by_side::DetectionTimes;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::task::Task;
    use scans::annotation::{Annotation, ScanId};
    use scans::dataset::AnnotatedClasses;

    /// Clusters of 30 points along x, without boxes: cars at 5, 20 and 40 m, and a tree of 6 m at 60 m.
    fn scan_without_boxes() -> LabeledScan {
        let statistics = [(AnnotationClass::Car, 5.0, 0.05), (AnnotationClass::Car, 20.0, 0.05)];
        let statistics = statistics
            .into_iter()
            .chain([(AnnotationClass::Car, 40.0, 0.05), (AnnotationClass::Tree, 60.0, 0.2)]);
        let mut cloud = PointCloud::default();
        let annotations = statistics.map(|(class, x_m, step_m)| {
            let first = cloud.len() as u32;
            (0..30_u8).for_each(|it| cloud.push([x_m, 0.0, step_m * f32::from(it)], 0.0));
            Annotation { point_indices: (first..first + 30).collect(), ..Annotation::of(class) }
        });
        let annotations = annotations.collect();
        (0..30_u8).for_each(|it| cloud.push([25.0, 0.1 * f32::from(it), 0.0], 0.0));
        LabeledScan::everywhere(ScanId { sequence: "drawn".to_owned(), index: 0 }, cloud, annotations)
    }

    fn dataset() -> DatasetDescription {
        DatasetDescription {
            id: "drawn".to_owned(),
            format: "drawn".to_owned(),
            root: None,
            annotated: AnnotatedClasses::EveryObject,
            sensor_height_m: 1.7,
            sensor: "drawn".to_owned(),
            licence: None,
            checksum: None,
            simulation: None,
        }
    }

    /// Rows for detections of these points, each with a box at `x_m`.
    fn rows_of(scan: &LabeledScan, detections: &[(std::ops::Range<u32>, f32)]) -> (ScanRow, Vec<MatchRow>) {
        let mut output = DetectorOutput::default();
        for (points, x_m) in detections {
            let point_indices: Vec<u32> = points.clone().collect();
            output.detections.push(Detection::new(
                &point_indices,
                OrientedBox { center_m: [*x_m, 0.0, 0.0], length_width_height_m: [1.0; 3], yaw_rad: 0.0 },
                DetectedClass::Object,
                None,
            ));
        }
        let params =
            MatchingParams { criterion: Criterion::POINTS, eligibility: EligibilityParams::STANDARD };
        let assignment =
            assign(scan, &output.detections, Task::Objects, &AnnotatedClasses::EveryObject, &params);
        let result = DetectorScan {
            detector: "drawn",
            output,
            times: DetectionTimes::default(),
            failure: None,
            assignments: vec![assignment],
        };
        let mut rows =
            DetectorRows::new(&dataset(), RowsOf { scan, checksum: 7, time_s: Some(0.0) }, &result);
        let TaskRows { scan, matches } = rows.tasks.remove(0);
        (scan, matches)
    }

    #[test]
    fn without_boxes_the_ranges_add_up_to_everything() {
        let scan = scan_without_boxes();
        let (scan_row, match_rows) = rows_of(&scan, &[(0..30, 5.0), (60..90, 40.0), (120..150, 25.0)]);
        let mut tally = Tally::default();
        tally.add_scan(&scan_row);
        for row in &match_rows {
            tally.add_match(row);
        }
        let rows = tally.metric_rows();
        let sum = |metric: &Metric, is_asked: &dyn Fn(Slice) -> bool| -> f64 {
            let asked = rows.iter().filter(|it| it.metric == *metric && is_asked(it.subject.slice));
            asked.filter_map(reports::numbers::run_report::MetricRow::value).sum()
        };
        for (metric, expected) in [(Metric::No, 3.0), (Metric::Tp, 2.0), (Metric::Fo, 1.0)] {
            assert_eq!(sum(&metric, &|it| it == Slice::All), expected, "{}", metric.id());
            assert_eq!(sum(&metric, &|it| matches!(it, Slice::Range(_))), expected, "{}", metric.id());
        }
        assert_eq!(sum(&Metric::No, &|it| it == Slice::Range(1)), 1.0);
        assert_eq!(sum(&Metric::No, &|it| it == Slice::Tall), 1.0);
    }

    #[test]
    fn a_tall_annotation_and_what_found_it_are_one_row() {
        let scan = scan_without_boxes();
        let of_tree = |detections: &[(std::ops::Range<u32>, f32)]| {
            let rows = rows_of(&scan, detections).1;
            let n_detections =
                rows.iter().filter(|it| matches!(it.outcome, MatchOutcome::IgnoredDetection { .. }));
            let n_detections = n_detections.count();
            let tall = rows.into_iter().find_map(|it| match it.outcome {
                MatchOutcome::Tall { annotation, found_by } => {
                    Some((annotation.id, found_by.map(|it| it.cost)))
                }
                _ => None,
            });
            (tall, n_detections)
        };
        assert_eq!(of_tree(&[]), (Some((3, None)), 0));
        assert_eq!(of_tree(&[(90..120, 60.0)]), (Some((3, Some(0.0))), 0));
        // Too few points to find it, but on it.
        assert_eq!(of_tree(&[(90..100, 60.0)]), (Some((3, None)), 1));
    }

    #[test]
    fn rows_say_where_unboxed_annotations_stand_and_what_is_cut() {
        let mut scan = scan_without_boxes();
        scan.point_regions[..15].fill(PointRegion::Outside);
        let facts = annotation_facts(&scan, 0);
        assert_eq!((facts.n_points_outside, facts.is_truncated()), (15, true));
        let [x_m, y_m, z_m] = facts.centroid_m.unwrap();
        assert!(x_m == 5.0 && y_m == 0.0 && (z_m - 0.725).abs() < 1e-5, "{facts:?}");
        assert!(!annotation_facts(&scan, 1).is_truncated());
    }
}
