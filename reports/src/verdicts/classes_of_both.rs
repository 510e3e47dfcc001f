//! Two runs with the same tasks of classes: a detector that does not give a class has found nothing of it.
//!
//! A scan has rows of a class only where that is annotated, and its detector gives classes, or where it is given. So what one
//! side says of a class may be missing on the other one.

use std::collections::{BTreeMap, BTreeSet};

use crate::rows::counts::Counts;
use crate::rows::match_outcome::{AnnotationFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow, SegmentationNumbers};
use crate::run_folder::run_archive::RunArchive;
use crate::vocabulary::reason::MissReason;
use crate::vocabulary::task::Task;

/// Data set, drive, number and detector of a scan.
type ScanKey<'a> = (&'a str, &'a str, u32, &'a str);

/// Both runs, each with rows of the classes that only the other one has: nothing of them is found, and nothing is false.
pub fn with_classes_of_both([mut before, mut after]: [RunArchive; 2]) -> [RunArchive; 2] {
    let missing = [Missing::rows(&before, &after), Missing::rows(&after, &before)];
    for (side, missing) in [&mut before, &mut after].into_iter().zip(missing) {
        side.scans.extend(missing.scans);
        side.matches.extend(missing.matches);
    }
    [before, after]
}

/// Rows that a run lacks.
struct Missing {
    scans: Vec<ScanRow>,
    matches: Vec<MatchRow>,
}

impl Missing {
    /// The rows of classes that `run` lacks and `other` has, of the scans and detectors that both have.
    fn rows(run: &RunArchive, other: &RunArchive) -> Self {
        let known: BTreeSet<_> = run.scans.iter().map(|it| (key_of(it), it.task)).collect();
        let lacks = |key: ScanKey<'_>, task: Task| task.class().is_some() && !known.contains(&(key, task));
        let seen: BTreeMap<_, _> =
            run.scans.iter().filter(|it| it.task == Task::Objects).map(|it| (key_of(it), it)).collect();
        let scans = other.scans.iter().filter(|it| lacks(key_of(it), it.task));
        let scans: Vec<ScanRow> =
            scans.filter_map(|row| nothing_found(row, seen.get(&key_of(row))?)).collect();
        if scans.is_empty() {
            return Self { scans, matches: Vec::new() };
        }
        let outcomes = Outcomes::of(run);
        let matches = other.matches.iter().filter_map(|row| {
            let key = (row.dataset.as_str(), row.sequence.as_str(), row.scan, row.detector.as_str());
            let annotation = annotation_of(&row.outcome).filter(|_| lacks(key, row.task))?;
            seen.get(&key)?.numbers()?;
            let reason = outcomes.why_missed(key, annotation.id);
            let outcome = MatchOutcome::Missed { annotation: annotation.clone(), reason };
            Some(MatchRow { outcome, ..row.clone() })
        });
        Self { scans, matches: matches.collect() }
    }
}

fn key_of(row: &ScanRow) -> ScanKey<'_> {
    (&row.dataset, &row.sequence, row.scan, &row.detector)
}

/// `row` of a detector that finds nothing of its class, whose row of all objects is `seen`; `None` if it was not asked.
fn nothing_found(row: &ScanRow, seen: &ScanRow) -> Option<ScanRow> {
    let (theirs, ours) = (row.numbers()?, seen.numbers()?);
    let no_false = theirs.counts.fo().map(|_| 0);
    let outcome = ScanOutcome::Evaluated(ScanNumbers {
        counts: Counts::new(theirs.counts.no(), 0, no_false)?,
        n_ignored_annotations: theirs.n_ignored_annotations,
        n_ignored_detections: 0,
        n_unknowable_detections: 0,
        segmentation: SegmentationNumbers::default(),
        ..ours.clone()
    });
    Some(ScanRow { task: row.task, outcome, ..seen.clone() })
}

/// The annotation of an outcome that counts.
fn annotation_of(outcome: &MatchOutcome) -> Option<&AnnotationFacts> {
    match outcome {
        MatchOutcome::Matched { annotation, .. } | MatchOutcome::Missed { annotation, .. } => {
            Some(annotation)
        }
        _ => None,
    }
}

/// Outcomes of annotations among all objects.
struct Outcomes<'a>(BTreeMap<(ScanKey<'a>, u64), &'a MatchOutcome>);

impl<'a> Outcomes<'a> {
    fn of(run: &'a RunArchive) -> Self {
        let of_objects = run.matches.iter().filter(|it| it.task == Task::Objects);
        let keyed = of_objects.filter_map(|row| {
            let key = (row.dataset.as_str(), row.sequence.as_str(), row.scan, row.detector.as_str());
            Some(((key, annotation_of(&row.outcome)?.id), &row.outcome))
        });
        Self(keyed.collect())
    }

    fn why_missed(&self, key: ScanKey<'_>, annotation_id: u64) -> MissReason {
        match self.0.get(&(key, annotation_id)) {
            Some(MatchOutcome::Matched { .. }) => MissReason::WrongClass,
            Some(MatchOutcome::Missed { reason, .. }) => *reason,
            _ => MissReason::NothingThere,
        }
    }
}
