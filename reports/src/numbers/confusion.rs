//! Annotated classes by the classes that detectors give.

use std::collections::BTreeMap;

use crate::rows::confusion_row::{ConfusionRow, NONE};
use crate::rows::match_outcome::MatchOutcome;
use crate::rows::match_row::MatchRow;
use crate::vocabulary::task::Task;

/// Counts of annotated classes by given classes, in the pairs of the task *objects*.
#[derive(Debug, Default)]
pub struct Confusion {
    // By data set and detector: the counts by annotated and detected class, and whether any class was given.
    counts: BTreeMap<(String, String), Counted>,
}

#[derive(Debug, Default)]
struct Counted {
    gives_classes: bool,
    n: BTreeMap<[&'static str; 2], u64>,
}

impl Confusion {
    /// Adds the outcome of an annotation, a detection or a pair of them.
    pub fn add_match(&mut self, row: &MatchRow) {
        if row.task != Task::Objects {
            return;
        }
        let (annotated, detection) = match &row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => (annotation.class.name(), Some(detection)),
            MatchOutcome::Missed { annotation, .. } => (annotation.class.name(), None),
            MatchOutcome::False { detection, .. } => (NONE, Some(detection)),
            _ => return,
        };
        let counted = self.counts.entry((row.dataset.clone(), row.detector.clone())).or_default();
        counted.gives_classes |= detection.is_some_and(|it| it.class.given().is_some());
        let detected = detection.map_or(NONE, |it| it.class.name());
        *counted.n.entry([annotated, detected]).or_default() += 1;
    }

    /// The counts of detectors that give classes: data set by data set, detector by detector.
    pub fn rows(&self) -> Vec<ConfusionRow> {
        let of_classes = self.counts.iter().filter(|(_, it)| it.gives_classes);
        let rows = of_classes.flat_map(|((dataset, detector), counted)| {
            counted.n.iter().map(|([annotated, detected], n)| ConfusionRow {
                dataset: dataset.clone(),
                detector: detector.clone(),
                annotated: (*annotated).to_owned(),
                detected: (*detected).to_owned(),
                n: *n,
            })
        });
        rows.collect()
    }
}
