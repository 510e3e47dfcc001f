//! What each part of a method is worth: the scores of the whole and of variants that lack a part.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::CsvRow;
use crate::files::fixed_decimals::Fixed;
use crate::rows::counts::Counts;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// What one variant reached on one data set, or on all together.
#[derive(Debug, Clone, PartialEq)]
pub struct AblationScore {
    /// How much it covers.
    pub extent: Extent,
    /// Where the scans come from.
    pub origin: Origin,
    /// The variant.
    pub variant: String,
    /// Number of scans.
    pub n_scans: u64,
    /// What was found, missed and false.
    pub counts: Counts,
    /// Of the annotations, those in several detections.
    pub n_split: u64,
    /// Detections that hold an annotation.
    pub n_holding: u64,
    /// Of these, those that hold several.
    pub n_joining: u64,
    /// Shortest time of a scan in milliseconds; `None` if no scan was timed.
    pub latency_min_ms: Option<f64>,
    /// Median time of a scan in milliseconds; `None` if no scan was timed.
    pub latency_p50_ms: Option<f64>,
}

impl AblationScore {
    /// Share of the annotations that are split; `None` without annotations.
    pub fn over_segmentation(&self) -> Option<f64> {
        (self.counts.no() > 0).then(|| self.n_split as f64 / self.counts.no() as f64)
    }

    /// Share of the detections holding an annotation that hold several; `None` if none holds any.
    pub fn under_segmentation(&self) -> Option<f64> {
        (self.n_holding > 0).then(|| self.n_joining as f64 / self.n_holding as f64)
    }
}

/// A row of `ablation.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AblationRow {
    task: Task,
    dataset: String,
    origin: Origin,
    variant: String,
    n_scans: u64,
    no: u64,
    tp: u64,
    mo: u64,
    fo: Option<u64>,
    f_rate: Option<Fixed<6>>,
    precision: Option<Fixed<6>>,
    recall: Option<Fixed<6>>,
    n_split: u64,
    over_segmentation: Option<Fixed<6>>,
    n_holding: u64,
    n_joining: u64,
    under_segmentation: Option<Fixed<6>>,
    latency_min_ms: Option<Fixed<4>>,
    latency_p50_ms: Option<Fixed<4>>,
}

impl CsvRow for AblationRow {
    const COLUMNS: &'static [&'static str] = &[
        "task",
        "dataset",
        "origin",
        "variant",
        "n_scans",
        "no",
        "tp",
        "mo",
        "fo",
        "f_rate",
        "precision",
        "recall",
        "n_split",
        "over_segmentation",
        "n_holding",
        "n_joining",
        "under_segmentation",
        "latency_min_ms",
        "latency_p50_ms",
    ];
}

impl AblationRow {
    /// The row of `score`, which is of `task`.
    pub fn new(task: Task, score: &AblationScore) -> Self {
        let counts = score.counts;
        Self {
            task,
            dataset: score.extent.name().to_owned(),
            origin: score.origin,
            variant: score.variant.clone(),
            n_scans: score.n_scans,
            no: counts.no(),
            tp: counts.tp(),
            mo: counts.mo(),
            fo: counts.fo(),
            f_rate: counts.f_rate().map(Fixed),
            precision: counts.precision().map(Fixed),
            recall: counts.recall().map(Fixed),
            n_split: score.n_split,
            over_segmentation: score.over_segmentation().map(Fixed),
            n_holding: score.n_holding,
            n_joining: score.n_joining,
            under_segmentation: score.under_segmentation().map(Fixed),
            latency_min_ms: score.latency_min_ms.map(Fixed),
            latency_p50_ms: score.latency_p50_ms.map(Fixed),
        }
    }
}
