//! `agreement.csv`: how far the detectors of a run agree on scans without labels.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::CsvRow;
use crate::vocabulary::task::Task;

/// What two detectors found in the scans of a data set.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AgreementRow {
    /// The data set.
    pub dataset: String,
    /// What is asked for.
    pub task: Task,
    /// The detector.
    pub detector: String,
    /// The one that it is compared with.
    pub other: String,
    /// Scans.
    pub n_scans: u64,
    /// Detections of the detector.
    pub n_detections: u64,
    /// Detections of the other one.
    pub n_other: u64,
    /// Those of them that are one.
    pub n_both: u64,
}

impl CsvRow for AgreementRow {
    const COLUMNS: &'static [&'static str] =
        &["dataset", "task", "detector", "other", "n_scans", "n_detections", "n_other", "n_both"];
}
