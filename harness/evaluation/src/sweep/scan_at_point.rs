//! What a sweep keeps of its scans: results of the detections and of the clock.

use detector::grid::cell_fitness::CellTally;
use reports::numbers::blocks::DriveSecond;
use reports::rows::official_rows::OfficialRows;
use serde::{Deserialize, Serialize};

use crate::metrics::counts::Counts;

/// A line of the journal of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// Of the detections.
    Quality(ScanAtPoint),
    /// Of the clock.
    Times(TimedScan),
}

/// One scan at one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanAtPoint {
    /// Index of the data set among those of the sweep.
    pub dataset_idx: usize,
    /// Index of the scan among those taken from the data set.
    pub scan_idx: usize,
    /// Number of the scan within its drive.
    pub scan: u32,
    /// The drive.
    pub sequence: String,
    /// The second of its drive that it was taken in.
    pub second: DriveSecond,
    /// Index of the point in the plan.
    pub point_idx: usize,
    /// What each detector made of it, in the order of the plan.
    pub detectors: Vec<DetectorAtPoint>,
    /// The rows of protocols of others.
    #[serde(default, skip_serializing_if = "OfficialRows::is_empty")]
    pub official: OfficialRows,
}

impl ScanAtPoint {
    /// The order of results: data set, scan, point.
    pub fn key(&self) -> [usize; 3] {
        [self.dataset_idx, self.scan_idx, self.point_idx]
    }
}

/// What one detector made of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetectorAtPoint {
    /// For each of [`Task::ALL`](reports::vocabulary::task::Task::ALL).
    pub counts: Vec<Counts>,
    /// The cells of its grid, if it starts from one.
    pub cells: Option<CellTally>,
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
