//! The boxes of the scans with worst mistakes.

use std::collections::BTreeMap;

use crate::rows::match_outcome::{BoxFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::task::Task;
use crate::worst::objects::{WorstObject, WorstObjects};

/// A box in a scan.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SeenBox {
    pub(crate) task: Task,
    /// Detector that found it; `None` for an annotation.
    pub(crate) detector: Option<String>,
    pub(crate) id: u64,
    pub(crate) bounding_box: BoxFacts,
}

/// All boxes of the scans with worst mistakes, each annotation once per task. The rows of a scan must be consecutive.
#[derive(Debug, Clone, Default)]
pub(crate) struct SeenBoxes {
    of_scan: BTreeMap<ScanName, Vec<SeenBox>>,
    // Rows of the scan that is being read.
    latest: Option<(ScanName, Vec<SeenBox>)>,
}

impl SeenBoxes {
    /// Adds the boxes of a row; `worst` must hold all rows before it.
    pub(crate) fn add<T>(&mut self, row: &MatchRow, worst: &WorstObjects<T>) {
        let is_of_row =
            |it: &ScanName| it.scan == row.scan && it.sequence == row.sequence && it.dataset == row.dataset;
        if self.latest.as_ref().is_none_or(|(scan, _)| !is_of_row(scan)) {
            self.keep_latest(worst);
            let scan =
                ScanName { dataset: row.dataset.clone(), sequence: row.sequence.clone(), scan: row.scan };
            self.latest = Some((scan, Vec::new()));
        }
        let Some((_, boxes)) = &mut self.latest else { return };
        let (annotation, detection) = match &row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => (Some(annotation), Some(detection)),
            MatchOutcome::Missed { annotation, .. } | MatchOutcome::IgnoredAnnotation { annotation, .. } => {
                (Some(annotation), None)
            }
            MatchOutcome::Tall { annotation, found_by } => {
                (Some(annotation), found_by.as_ref().map(|it| &it.detection))
            }
            MatchOutcome::False { detection, .. }
            | MatchOutcome::IgnoredDetection { detection, .. }
            | MatchOutcome::Unknowable { detection, .. } => (None, Some(detection)),
        };
        if let Some((id, bounding_box)) = annotation.and_then(|it| Some((it.id, it.bounding_box?))) {
            boxes.push(SeenBox { task: row.task, detector: None, id, bounding_box });
        }
        if let Some(detection) = detection {
            let (detector, id, bounding_box) =
                (Some(row.detector.clone()), detection.id, detection.bounding_box);
            boxes.push(SeenBox { task: row.task, detector, id, bounding_box });
        }
    }

    /// The boxes by scan; `worst` must hold all rows.
    pub(crate) fn finish<T>(mut self, worst: &WorstObjects<T>) -> BTreeMap<ScanName, Vec<SeenBox>> {
        self.keep_latest(worst);
        let mut of_scan = BTreeMap::new();
        for worst in worst.lists().flat_map(|(_, objects)| objects) {
            let scan = scan_name(worst);
            if let Some(boxes) = self.of_scan.remove(&scan) {
                of_scan.insert(scan, boxes);
            }
        }
        of_scan
    }

    /// Keeps the boxes of the latest scan if one of its mistakes is among the worst so far.
    fn keep_latest<T>(&mut self, worst: &WorstObjects<T>) {
        let Some((scan, boxes)) = self.latest.take() else { return };
        if !worst.lists().flat_map(|(_, objects)| objects).any(|it| scan_name(it) == scan) {
            return;
        }
        let mut once: Vec<SeenBox> = Vec::with_capacity(boxes.len());
        for seen in boxes {
            // Every detector has a row about an annotation.
            if seen.detector.is_some() || !once.contains(&seen) {
                once.push(seen);
            }
        }
        self.of_scan.insert(scan, once);
    }
}

/// The scan of a mistake.
pub(crate) fn scan_name<T>(worst: &WorstObject<T>) -> ScanName {
    let object = &worst.object;
    ScanName { dataset: object.dataset.clone(), sequence: object.sequence.clone(), scan: object.scan }
}
