//! Results that a sweep keeps of its scans: counts and times.

use detector::grid::cell_fitness::CellTally;
use reports::files::csv_rows::csv_text;
use reports::rows::official_rows::OfficialRows;
use reports::rows::scan_row::ScanRow;
use serde::{Deserialize, Serialize};

/// A line of the journal of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// Counts.
    Quality(ScanAtPoint),
    /// Times.
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
    /// Index of the point in the plan.
    pub point_idx: usize,
    /// Rows of `scans.csv`: of each detector of the plan, those of each of
    /// [`Task::ALL`](reports::vocabulary::task::Task::ALL).
    #[serde(with = "csv_text")]
    pub scans: Vec<ScanRow>,
    /// Of each detector of the plan, the tally of the cells of its grid, if it has one.
    pub cells: Vec<Option<CellTally>>,
    /// Rows under official protocols.
    #[serde(default, skip_serializing_if = "OfficialRows::is_empty")]
    pub official: OfficialRows,
}

impl ScanAtPoint {
    /// Sort key of results: data set, scan, point.
    pub fn key(&self) -> [usize; 3] {
        [self.dataset_idx, self.scan_idx, self.point_idx]
    }
}

/// The times of one scan at all points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedScan {
    /// Index of the data set among those of the sweep.
    pub dataset_idx: usize,
    /// Index of the scan among those taken from the data set.
    pub scan_idx: usize,
    /// Name of the processor, as it reports it.
    pub processor: String,
    /// Times in nanoseconds, for each point and then for each detector.
    pub times_ns: Vec<Vec<Vec<u64>>>,
}

impl TimedScan {
    /// Sort key of results: data set, scan.
    pub fn key(&self) -> (usize, usize) {
        (self.dataset_idx, self.scan_idx)
    }
}
