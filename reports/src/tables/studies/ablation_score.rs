//! The worth of each part of a method: scores of the whole, and of variants that lack a part.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::blocks::Interval;
use crate::numbers::run_report::{RunReport, Subject};
use crate::rows::counts::Counts;
use crate::tables::task_table::{MeasuredRow, Score, TableRow, TaskTable};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::{LatencyStatistic, Metric};
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// The score of one variant on one data set, or on all together.
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
    /// Found, missed and false objects.
    pub counts: Counts,
    /// How sure the F-rate is, where that is known.
    pub f_rate_within: Option<Interval>,
    /// Share of the annotations that are in several detections; `None` without annotations.
    pub over_segmentation: Option<f64>,
    /// Detections that hold an annotation.
    pub n_holding: u64,
    /// Share of these that hold several; `None` if none holds any.
    pub under_segmentation: Option<f64>,
    /// Shortest time of a scan in milliseconds; `None` if no scan was timed.
    pub latency_min_ms: Option<f64>,
    /// Median time of a scan in milliseconds; `None` if no scan was timed.
    pub latency_p50_ms: Option<f64>,
}

impl AblationScore {
    /// The scores in `table` of all variants, which are the detectors of the run that `report` is of: data set by data set
    /// and then overall, and within these variant by variant.
    pub fn all(table: &TaskTable, report: &RunReport) -> Vec<Self> {
        let measured = table.rows.iter().filter_map(|it| match it {
            TableRow::Measured(row) => Some(row),
            TableRow::Paper(_) => None,
        });
        let of_row = |row: &MeasuredRow| {
            let variants = table.detectors.iter().zip(&row.scores);
            variants.map(|(variant, score)| Self::new(table, report, row, score, variant)).collect::<Vec<_>>()
        };
        measured.flat_map(of_row).collect()
    }

    fn new(table: &TaskTable, report: &RunReport, row: &MeasuredRow, score: &Score, variant: &str) -> Self {
        let subject = Subject::of_all(row.extent.name(), table.task, variant);
        let value = |metric| report.row(&subject, &metric)?.value();
        Self {
            extent: row.extent.clone(),
            origin: row.origin,
            variant: variant.to_owned(),
            n_scans: score.n_scans,
            counts: score.counts,
            f_rate_within: score.intervals.f_rate,
            over_segmentation: value(Metric::OverSegmentation),
            n_holding: report.row(&subject, &Metric::UnderSegmentation).map_or(0, |it| it.n),
            under_segmentation: value(Metric::UnderSegmentation),
            latency_min_ms: value(Metric::Latency(LatencyStatistic::Min)),
            latency_p50_ms: value(Metric::Latency(LatencyStatistic::P50)),
        }
    }
}

row! {
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
        over_segmentation: Option<Fixed<6>>,
        n_holding: u64,
        under_segmentation: Option<Fixed<6>>,
        latency_min_ms: Option<Fixed<4>>,
        latency_p50_ms: Option<Fixed<4>>,
        f_rate_low: Option<Fixed<6>>,
        f_rate_high: Option<Fixed<6>>,
        few_blocks: Option<bool>,
    }
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
            over_segmentation: score.over_segmentation.map(Fixed),
            n_holding: score.n_holding,
            under_segmentation: score.under_segmentation.map(Fixed),
            latency_min_ms: score.latency_min_ms.map(Fixed),
            latency_p50_ms: score.latency_p50_ms.map(Fixed),
            f_rate_low: score.f_rate_within.map(|it| Fixed(it.ends[0])),
            f_rate_high: score.f_rate_within.map(|it| Fixed(it.ends[1])),
            few_blocks: score.f_rate_within.map(|it| it.blocks.decide_nothing()),
        }
    }
}
