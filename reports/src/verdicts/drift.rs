//! Scans whose results changed, object by object.
//!
//! Detection and matching are deterministic: any change has a cause in the program, its parameters or its data.

use std::collections::BTreeMap;

use crate::rows::match_outcome::{AnnotationFacts, DetectionFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::partial_row::{PartialRow, Predicted};
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use crate::run_folder::run_archive::RunArchive;
use crate::verdicts::partial_differences::CurveName;
use crate::vocabulary::reason::MissReason;
use crate::vocabulary::study::Study;

/// A scan on which results of a detector changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanDrift {
    /// Which scan, which detector, which task.
    pub subject: ScanSubject,
    /// What changed, in words, one entry an object.
    pub changes: Vec<String>,
}

/// A scan, a detector and a task.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ScanSubject {
    /// Id of the data set.
    pub dataset: String,
    /// The drive.
    pub sequence: String,
    /// Number of the scan within the drive.
    pub scan: u32,
    /// Name of the task.
    pub task: String,
    /// Name of the detector.
    pub detector: String,
}

impl ScanSubject {
    /// Of a row of partly seen objects: the object is the drive, and its step is the scan.
    fn of_object(row: &PartialRow) -> Self {
        let curve = CurveName::of(row);
        let (sequence, task) = (row.object.clone(), Study::Partial.name().to_owned());
        Self { dataset: curve.on(), sequence, scan: row.step, task, detector: curve.detector() }
    }

    /// For people.
    pub fn in_words(&self) -> String {
        let Self { dataset, sequence, scan, task, detector } = self;
        if task == Study::Partial.name() {
            return format!("{sequence} at step {scan}, {dataset}, {detector}");
        }
        format!("{dataset} {sequence}/{scan:06}, {detector}, {task}")
    }
}

/// All scans on which results of a detector differ between `baseline` and `run`, which is of the same scans.
///
/// What is ignored is compared by its number alone.
pub fn drift(baseline: &RunArchive, run: &RunArchive) -> Vec<ScanDrift> {
    let (before, now) = (scans_of(baseline), scans_of(run));
    let drifts = before.into_iter().filter_map(|(subject, before)| {
        let changes = changes(&before, now.get(&subject)?);
        (!changes.is_empty()).then_some(ScanDrift { subject, changes })
    });
    drifts.chain(changed_classes(baseline, run)).collect()
}

/// Partly seen objects whose predicted class differs.
fn changed_classes(baseline: &RunArchive, run: &RunArchive) -> Vec<ScanDrift> {
    let predicted = |it: &RunArchive| -> BTreeMap<ScanSubject, Predicted> {
        it.objects.iter().map(|row| (ScanSubject::of_object(row), row.predicted)).collect()
    };
    let now = predicted(run);
    let drift = |(subject, before): (ScanSubject, Predicted)| {
        let after = *now.get(&subject).filter(|it| **it != before)?;
        let changes = vec![format!("{}, and now {}", before.name(), after.name())];
        Some(ScanDrift { subject, changes })
    };
    predicted(baseline).into_iter().filter_map(drift).collect()
}

/// What became of the objects of a scan.
#[derive(Default)]
struct ScanObjects<'a> {
    numbers: Option<&'a ScanNumbers>,
    annotations: BTreeMap<u64, (&'a AnnotationFacts, Fate<'a>)>,
    unmatched: BTreeMap<UnmatchedKey, (&'a DetectionFacts, String)>,
}

/// What became of an annotation.
#[derive(PartialEq)]
enum Fate<'a> {
    Matched { detection: &'a DetectionFacts, cost: f64 },
    Missed { reason: MissReason },
}

/// A detection that matched nothing, identified by where it is: its number changes with those of others.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct UnmatchedKey {
    center_mm: [i64; 3],
    n_points: u64,
}

fn scans_of(archive: &RunArchive) -> BTreeMap<ScanSubject, ScanObjects<'_>> {
    let mut scans: BTreeMap<ScanSubject, ScanObjects<'_>> = BTreeMap::new();
    for row in &archive.scans {
        if let ScanOutcome::Evaluated(numbers) = &row.outcome {
            scans.entry(subject_of_scan(row)).or_default().numbers = Some(numbers);
        }
    }
    for row in &archive.matches {
        scans.entry(subject_of_match(row)).or_default().add(&row.outcome);
    }
    scans
}

fn subject_of_scan(row: &ScanRow) -> ScanSubject {
    let ScanRow { dataset, sequence, scan, detector, task, .. } = row.clone();
    ScanSubject { dataset, sequence, scan, task: task.name().to_owned(), detector }
}

fn subject_of_match(row: &MatchRow) -> ScanSubject {
    let [dataset, sequence, detector] = [&row.dataset, &row.sequence, &row.detector].map(String::clone);
    ScanSubject { dataset, sequence, scan: row.scan, task: row.task.name().to_owned(), detector }
}

impl<'a> ScanObjects<'a> {
    fn add(&mut self, outcome: &'a MatchOutcome) {
        match outcome {
            MatchOutcome::Matched { annotation, detection, cost } => {
                let fate = Fate::Matched { detection, cost: *cost };
                self.annotations.insert(annotation.id, (annotation, fate));
            }
            MatchOutcome::Missed { annotation, reason } => {
                self.annotations.insert(annotation.id, (annotation, Fate::Missed { reason: *reason }));
            }
            MatchOutcome::False { detection, reason } => {
                self.unmatched.insert(key(detection), (detection, format!("false ({})", reason.name())));
            }
            MatchOutcome::Unknowable { detection } => {
                self.unmatched.insert(key(detection), (detection, "unknowable".to_owned()));
            }
            MatchOutcome::IgnoredAnnotation { .. }
            | MatchOutcome::Tall { .. }
            | MatchOutcome::IgnoredDetection { .. } => {}
        }
    }
}

fn key(detection: &DetectionFacts) -> UnmatchedKey {
    let center_mm = detection.bounding_box.center_m.map(|it| (f64::from(it) * 1000.0).round() as i64);
    UnmatchedKey { center_mm, n_points: detection.n_points }
}

fn changes(before: &ScanObjects<'_>, now: &ScanObjects<'_>) -> Vec<String> {
    let mut changes = Vec::new();
    for (id, (annotation, fate)) in &now.annotations {
        match before.annotations.get(id) {
            Some((_, old)) => changes.extend(fate_change(annotation, old, fate)),
            None => changes.push(format!("{} counts now", name(annotation))),
        }
    }
    for (id, (annotation, _)) in &before.annotations {
        if !now.annotations.contains_key(id) {
            changes.push(format!("{} no longer counts", name(annotation)));
        }
    }
    for (key, (detection, what)) in &now.unmatched {
        match before.unmatched.get(key) {
            Some((_, old)) if old == what => {}
            Some((_, old)) => {
                changes.push(format!("{}: before {old}, now {what}", unmatched_name(detection)));
            }
            None => changes.push(format!("{}: new, {what}", unmatched_name(detection))),
        }
    }
    for (key, (detection, what)) in &before.unmatched {
        if !now.unmatched.contains_key(key) {
            changes.push(format!("{}: gone, before {what}", unmatched_name(detection)));
        }
    }
    if changes.is_empty() {
        changes.extend(number_changes(before.numbers, now.numbers));
    }
    changes
}

fn fate_change(annotation: &AnnotationFacts, before: &Fate<'_>, now: &Fate<'_>) -> Option<String> {
    let what = match (before, now) {
        _ if before == now => return None,
        (Fate::Matched { detection: old, cost: old_cost }, Fate::Matched { detection, cost }) => {
            let is_same = old_cost == cost
                && old.bounding_box == detection.bounding_box
                && old.n_points == detection.n_points;
            if is_same && old.score == detection.score {
                // Another number of the same detection.
                return None;
            }
            format!(
                "still found, but at cost {cost:.3} with {} points, before at cost {old_cost:.3} with {} points",
                detection.n_points, old.n_points
            )
        }
        (Fate::Matched { .. }, Fate::Missed { reason }) => {
            format!("found before, now missed ({})", reason.name())
        }
        (Fate::Missed { reason }, Fate::Matched { .. }) => {
            format!("missed before ({}), now found", reason.name())
        }
        (Fate::Missed { reason: old }, Fate::Missed { reason }) => {
            format!("missed before ({}), now missed ({})", old.name(), reason.name())
        }
    };
    Some(format!("{}: {what}", name(annotation)))
}

fn name(annotation: &AnnotationFacts) -> String {
    let track = annotation.track.map_or_else(String::new, |it| format!(", track {it}"));
    let position =
        annotation.center_m().map_or_else(String::new, |[x_m, y_m, _]| format!(" at ({x_m:.1}, {y_m:.1}) m"));
    let AnnotationFacts { id, class, n_points, .. } = annotation;
    let class = class.name();
    format!("{class} {id}{track}, {n_points} points{position}")
}

fn unmatched_name(detection: &DetectionFacts) -> String {
    let [x_m, y_m, _] = detection.bounding_box.center_m;
    format!("detection of {} points at ({x_m:.1}, {y_m:.1}) m", detection.n_points)
}

/// What changed in the numbers of a scan all of whose matches are the same; times always do.
fn number_changes(before: Option<&ScanNumbers>, now: Option<&ScanNumbers>) -> Option<String> {
    let untimed = |it: Option<&ScanNumbers>| {
        it.map(|it| ScanNumbers {
            latency_ms: None,
            least_latency_ms: None,
            reference_ms: None,
            cpu_ms: None,
            overhead_ms: None,
            failure: None,
            ..it.clone()
        })
    };
    let (before, now) = (untimed(before), untimed(now));
    (before != now).then(|| {
        let in_words = |it: &Option<ScanNumbers>| {
            it.as_ref().map_or_else(
                || "not evaluated".to_owned(),
                |it| {
                    let segmentation = &it.segmentation;
                    format!(
                        "{} annotations and {} detections ignored, {} split, {} joining, {} too small and {} too large clusters dropped",
                        it.n_ignored_annotations,
                        it.n_ignored_detections,
                        segmentation.n_split,
                        segmentation.n_joining,
                        it.n_dropped_too_small,
                        it.n_dropped_too_large
                    )
                },
            )
        };
        format!("same matches, but before {}; now {}", in_words(&before), in_words(&now))
    })
}
