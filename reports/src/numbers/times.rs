//! Times of detection, gathered from rows.

use std::collections::BTreeMap;

use crate::vocabulary::task::Task;

/// Times of the scans of one data set, by task and detector, and of the stages, by detector. Detectors are indices in a
/// tally.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times {
    // In milliseconds, as all times here.
    scans_ms: BTreeMap<(TimeKind, Task, usize), Vec<f64>>,
    // Number of scans, and of those whose detector gave no answer.
    failures: BTreeMap<(Task, usize), [u64; 2]>,
    stages_ms: BTreeMap<usize, Vec<(String, Vec<f64>)>>,
}

/// A time of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TimeKind {
    /// Time of the detection.
    Latency,
    /// Processor time during the detection.
    Cpu,
    /// Time to a detector that is a program of its own, and back.
    Overhead,
}

impl Times {
    /// Adds the time of a scan.
    pub(crate) fn add_scan(&mut self, kind: TimeKind, task: Task, detector_idx: usize, time_ms: f64) {
        self.scans_ms.entry((kind, task, detector_idx)).or_default().push(time_ms);
    }

    /// Adds a scan, and whether its detector gave no answer.
    pub(crate) fn add_failures(&mut self, task: Task, detector_idx: usize, has_failed: bool) {
        let [n_scans, n_failed] = self.failures.entry((task, detector_idx)).or_default();
        *n_scans += 1;
        *n_failed += u64::from(has_failed);
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
        for (key, [n_scans, n_failed]) in &other.failures {
            let sum = self.failures.entry(*key).or_default();
            *sum = [sum[0] + n_scans, sum[1] + n_failed];
        }
        for (detector_idx, stages) in &other.stages_ms {
            for (stage, times_ms) in stages {
                self.extend_stage(*detector_idx, stage, times_ms);
            }
        }
    }

    /// The times of the scans.
    pub(crate) fn scans_ms(&self, kind: TimeKind, task: Task, detector_idx: usize) -> &[f64] {
        self.scans_ms.get(&(kind, task, detector_idx)).map_or(&[], Vec::as_slice)
    }

    /// Number of scans, and of those among them whose detector gave no answer.
    pub(crate) fn failures(&self, task: Task, detector_idx: usize) -> [u64; 2] {
        self.failures.get(&(task, detector_idx)).copied().unwrap_or_default()
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
