//! Times of detection, gathered from rows.

use std::collections::BTreeMap;

use crate::vocabulary::task::Task;

/// Times of the scans of one data set, by task and detector, and of the stages, by detector. Detectors are places in a tally.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times {
    // In milliseconds, as all times here.
    scans_ms: BTreeMap<(Task, usize), Vec<f64>>,
    stages_ms: BTreeMap<usize, Vec<(String, Vec<f64>)>>,
}

impl Times {
    /// Adds the time of a scan.
    pub(crate) fn add_scan(&mut self, task: Task, detector_idx: usize, time_ms: f64) {
        self.scans_ms.entry((task, detector_idx)).or_default().push(time_ms);
    }

    /// Adds the time of a stage.
    pub(crate) fn add_stage(&mut self, detector_idx: usize, stage: &str, time_ms: f64) {
        self.extend_stage(detector_idx, stage, &[time_ms]);
    }

    /// Adds all times of `other`.
    pub(crate) fn add(&mut self, other: &Self) {
        for (key, times_ms) in &other.scans_ms {
            self.scans_ms.entry(*key).or_default().extend(times_ms);
        }
        for (detector_idx, stages) in &other.stages_ms {
            for (stage, times_ms) in stages {
                self.extend_stage(*detector_idx, stage, times_ms);
            }
        }
    }

    /// The times of the scans.
    pub(crate) fn scans_ms(&self, task: Task, detector_idx: usize) -> &[f64] {
        self.scans_ms.get(&(task, detector_idx)).map_or(&[], Vec::as_slice)
    }

    /// The times of each stage, in the order in which the stages were first seen.
    pub(crate) fn stages_ms(&self, detector_idx: usize) -> &[(String, Vec<f64>)] {
        self.stages_ms.get(&detector_idx).map_or(&[], Vec::as_slice)
    }

    fn extend_stage(&mut self, detector_idx: usize, stage: &str, times_ms: &[f64]) {
        let stages = self.stages_ms.entry(detector_idx).or_default();
        match stages.iter_mut().find(|(name, _)| name == stage) {
            Some((_, all)) => all.extend(times_ms),
            None => stages.push((stage.to_owned(), times_ms.to_vec())),
        }
    }
}
