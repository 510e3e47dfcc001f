//! What the journal of a sweep holds.

use serde::{Deserialize, Serialize};

use crate::sweep::scan_at_point::ScanAtPoint;

/// A result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// Of the detections.
    Quality(ScanAtPoint),
    /// Of the clock.
    Times(TimedScan),
}

/// The times of one scan at all points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedScan {
    /// Index of the data set among those of the sweep.
    pub dataset_idx: usize,
    /// Index of the scan among those taken from the data set.
    pub scan_idx: usize,
    /// The processor's own name.
    pub processor: String,
    /// For each point and then for each detector, in nanoseconds.
    pub times_ns: Vec<Vec<Vec<u64>>>,
}

impl TimedScan {
    /// The order of results: data set, scan.
    pub fn key(&self) -> (usize, usize) {
        (self.dataset_idx, self.scan_idx)
    }
}
