//! Scans whose results changed, object by object.
//!
//! Detection and matching are deterministic: any change has a cause in the program, its parameters or its data.

use std::collections::BTreeMap;

use crate::rows::match_outcome::{AnnotationFacts, DetectionFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::partial_row::{PartialRow, Predicted};
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use crate::run_folder::run_archive::RunArchive;
use crate::verdicts::change::{Change, ChangeKind};
use crate::verdicts::partial_differences::CurveName;
use crate::vocabulary::reason::{FalseReason, MissReason};
use crate::vocabulary::study::Study;
use crate::worst::mistakes::scan_address;

/// A scan on which results of a detector changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanDrift {
    /// The scan, the detector and the task.
    pub subject: ScanSubject,
    /// All changes, the worst first: an entry for each object, and one for all changes that are too small to be shown.
    pub changes: Vec<Change>,
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
    /// The subject of a row of partly seen objects: the object is the drive, and its step is the scan.
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
        format!("{}, {detector}, {task}", scan_address(dataset, sequence, *scan))
    }
}

/// All scans on which results of a detector differ between `baseline` and `run`, which is of the same scans.
///
/// Ignored objects are compared by their number alone.
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
    let predicted = |it: &'_ RunArchive| -> BTreeMap<ScanSubject, (Predicted, Predicted)> {
        let of_row = |row: &PartialRow| (row.predicted, Predicted::from(row.true_class));
        it.objects.iter().map(|row| (ScanSubject::of_object(row), of_row(row))).collect()
    };
    let now = predicted(run);
    let drift = |(subject, (before, truth)): (ScanSubject, (Predicted, Predicted))| {
        let (after, _) = *now.get(&subject).filter(|it| it.0 != before)?;
        let kind = match truth {
            _ if before == truth => ChangeKind::Lost,
            _ if after == truth => ChangeKind::Found,
            _ => ChangeKind::OtherClass,
        };
        let text = format!("{}, and now {}", before.name(), after.name());
        Some(ScanDrift { subject, changes: vec![Change::of_object(kind, 0, text)] })
    };
    predicted(baseline).into_iter().filter_map(drift).collect()
}

/// The objects of a scan with their outcomes.
#[derive(Default)]
struct ScanObjects<'a> {
    numbers: Option<&'a ScanNumbers>,
    annotations: BTreeMap<u64, (&'a AnnotationFacts, Fate<'a>)>,
    unmatched: BTreeMap<UnmatchedKey, Unmatched<'a>>,
}

/// The fate of an annotation.
#[derive(PartialEq)]
enum Fate<'a> {
    Matched { detection: &'a DetectionFacts, cost: f64 },
    Missed { reason: MissReason },
}

/// A detection that matched nothing.
struct Unmatched<'a> {
    detection: &'a DetectionFacts,
    /// Why it is false; `None` where it cannot be known whether it is.
    reason: Option<FalseReason>,
}

/// Identifies a detection that matched nothing by its place. Its number changes with those of others.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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
                self.unmatched.insert(key(detection), Unmatched { detection, reason: Some(*reason) });
            }
            MatchOutcome::Unknowable { detection, .. } => {
                self.unmatched.insert(key(detection), Unmatched { detection, reason: None });
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

/// All changes of a scan, the worst first.
fn changes(before: &ScanObjects<'_>, now: &ScanObjects<'_>) -> Vec<Change> {
    let mut all: Vec<Change> = annotation_changes(before, now);
    all.extend(detection_changes(before, now));
    let (shown, not_shown): (Vec<Change>, Vec<Change>) =
        all.into_iter().partition(|it| it.kind != ChangeKind::NotShown);
    let mut changes = shown;
    match not_shown.len() {
        0 if changes.is_empty() => changes.extend(number_changes(before.numbers, now.numbers)),
        0 => {}
        n => {
            let objects = if n == 1 { "object" } else { "objects" };
            let text = format!("box, score or cost of {n} {objects}, by less than is shown");
            changes.push(Change::not_shown(n, text));
        }
    }
    changes.sort_by(|a, b| a.kind.cmp(&b.kind).then(b.n_points.cmp(&a.n_points)));
    changes
}

fn annotation_changes(before: &ScanObjects<'_>, now: &ScanObjects<'_>) -> Vec<Change> {
    let mut changes = Vec::new();
    let mut push = |annotation: &AnnotationFacts, kind, what: &str| {
        let text = format!("{}: {what}", name(annotation));
        changes.push(Change::of_object(kind, annotation.n_points, text).at(annotation.center_m()));
    };
    for (id, (annotation, fate)) in &now.annotations {
        match before.annotations.get(id) {
            Some((_, old)) if old == fate => {}
            Some((_, old)) => {
                if let Some((kind, what)) = fate_change(old, fate) {
                    push(annotation, kind, &what);
                }
            }
            None => push(annotation, ChangeKind::Counting, "counts now"),
        }
    }
    for (id, (annotation, _)) in &before.annotations {
        if !now.annotations.contains_key(id) {
            push(annotation, ChangeKind::Counting, "no longer counts");
        }
    }
    changes
}

/// The change of a fate, and its kind; `None` if only the number of a detection differs.
fn fate_change(before: &Fate<'_>, now: &Fate<'_>) -> Option<(ChangeKind, String)> {
    let change = match (before, now) {
        (Fate::Matched { detection: old, cost: old_cost }, Fate::Matched { detection, cost }) => {
            let renumbered = DetectionFacts { id: detection.id, ..(*old).clone() };
            if old_cost == cost && renumbered == **detection {
                return None;
            }
            let shown =
                |it: &DetectionFacts, cost: f64| format!("at cost {cost:.3} with {} points", it.n_points);
            let [old_text, text] = [shown(old, *old_cost), shown(detection, *cost)];
            if old.class != detection.class {
                let what = format!("found before as {}, now as {}", old.class, detection.class);
                (ChangeKind::OtherClass, what)
            } else if old_text == text {
                (ChangeKind::NotShown, String::new())
            } else {
                (ChangeKind::Otherwise, format!("still found, but {text}, before {old_text}"))
            }
        }
        (Fate::Matched { .. }, Fate::Missed { reason }) => {
            (ChangeKind::Lost, format!("found before, now missed ({})", reason.name()))
        }
        (Fate::Missed { reason }, Fate::Matched { .. }) => {
            (ChangeKind::Found, format!("missed before ({}), now found", reason.name()))
        }
        (Fate::Missed { reason: old }, Fate::Missed { reason }) => {
            let what = format!("missed before ({}), now missed ({})", old.name(), reason.name());
            (ChangeKind::Otherwise, what)
        }
    };
    Some(change)
}

/// Changes of detections that matched nothing. One that moved a little is not a new one.
fn detection_changes(before: &ScanObjects<'_>, now: &ScanObjects<'_>) -> Vec<Change> {
    let mut gone: BTreeMap<UnmatchedKey, &Unmatched<'_>> =
        before.unmatched.iter().map(|(key, it)| (*key, it)).collect();
    let mut changes = Vec::new();
    let mut new = Vec::new();
    for (key, it) in &now.unmatched {
        match gone.remove(key) {
            Some(old) => changes.extend(unmatched_change(old, it)),
            None => new.push((*key, it)),
        }
    }
    for (key, it) in new {
        match nearest(&gone, key, it.detection).and_then(|it| gone.remove(&it)) {
            Some(old) => changes.extend(unmatched_change(old, it)),
            None => changes.push(it.change("new, ", ChangeKind::NewFalse)),
        }
    }
    changes.extend(gone.values().map(|it| it.change("gone, before ", ChangeKind::NoLongerFalse)));
    changes
}

/// The nearest of `candidates` that stands where `detection` does: nearer than half the shorter of both lengths.
fn nearest(
    candidates: &BTreeMap<UnmatchedKey, &Unmatched<'_>>,
    key: UnmatchedKey,
    detection: &DetectionFacts,
) -> Option<UnmatchedKey> {
    let length_m = |it: &DetectionFacts| f64::from(it.bounding_box.length_width_height_m[0]);
    let [x_mm, ..] = key.center_mm;
    let half_mm = (500.0 * length_m(detection)).ceil() as i64;
    // Keys are sorted by x.
    let at = |x_mm| UnmatchedKey { center_mm: [x_mm, i64::MIN, i64::MIN], n_points: 0 };
    let range = candidates.range(at(x_mm.saturating_sub(half_mm))..at(x_mm.saturating_add(half_mm + 1)));
    let near = range.filter_map(|(candidate, it)| {
        let [a, b] = [it.detection, detection].map(|it| it.bounding_box.center_m.map(f64::from));
        let distance_m = (a[0] - b[0]).hypot(a[1] - b[1]);
        let longest_m = length_m(it.detection).min(length_m(detection)) / 2.0;
        (distance_m < longest_m).then_some((distance_m, *candidate))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|it| it.1)
}

/// The change of a detection that matched nothing before, and matches nothing now; `None` if only its number differs.
fn unmatched_change(before: &Unmatched<'_>, now: &Unmatched<'_>) -> Option<Change> {
    let renumbered = DetectionFacts { id: now.detection.id, ..before.detection.clone() };
    if before.reason == now.reason && renumbered == *now.detection {
        return None;
    }
    let [old_name, name] = [before, now].map(|it| unmatched_name(it.detection));
    let (old, what) = (before.in_words(), now.in_words());
    let moved = if old_name == name { String::new() } else { format!(", before {old_name}") };
    let (kind, text) = match (before.reason, now.reason) {
        (None, Some(_)) => (ChangeKind::NewFalse, format!("{name}: before {old}, now {what}{moved}")),
        (Some(_), None) => (ChangeKind::NoLongerFalse, format!("{name}: before {old}, now {what}{moved}")),
        _ if before.detection.class != now.detection.class => {
            let [old, class] = [before, now].map(|it| it.detection.class);
            (ChangeKind::OtherClass, format!("{name}: still {what}, before as {old}, now as {class}{moved}"))
        }
        _ if old != what => (ChangeKind::Otherwise, format!("{name}: before {old}, now {what}{moved}")),
        _ if old_name == name => (ChangeKind::NotShown, String::new()),
        _ => (ChangeKind::Otherwise, format!("{name}: still {what}{moved}")),
    };
    Some(Change::of_object(kind, now.detection.n_points, text).at(Some(now.detection.bounding_box.center_m)))
}

impl Unmatched<'_> {
    fn in_words(&self) -> String {
        self.reason.map_or_else(|| "unknowable".to_owned(), |it| format!("false ({})", it.name()))
    }

    /// The change of a detection that is on one side only: of `kind` if it is false.
    fn change(&self, what: &str, kind: ChangeKind) -> Change {
        let kind = if self.reason.is_some() { kind } else { ChangeKind::Otherwise };
        let text = format!("{}: {what}{}", unmatched_name(self.detection), self.in_words());
        Change::of_object(kind, self.detection.n_points, text).at(Some(self.detection.bounding_box.center_m))
    }
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

/// The change in the numbers of a scan all of whose matches are the same; times, which always change, do not count.
fn number_changes(before: Option<&ScanNumbers>, now: Option<&ScanNumbers>) -> Option<Change> {
    let untimed = |it: Option<&ScanNumbers>| {
        it.map(|it| ScanNumbers {
            latency_ms: None,
            least_latency_ms: None,
            reference_ms: None,
            cpu_ms: None,
            overhead_ms: None,
            n_instructions: None,
            peak_bytes: None,
            failure: None,
            ..it.clone()
        })
    };
    let (before, now) = (untimed(before), untimed(now));
    if before == now {
        return None;
    }
    let [old, text] = [&before, &now].map(|it| numbers_in_words(it.as_ref()));
    Some(if old == text {
        Change::not_shown(1, "same matches; other numbers of the scan".to_owned())
    } else {
        Change::of_object(ChangeKind::Otherwise, 0, format!("same matches, but before {old}; now {text}"))
    })
}

fn numbers_in_words(numbers: Option<&ScanNumbers>) -> String {
    let Some(it) = numbers else { return "not evaluated".to_owned() };
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
}
