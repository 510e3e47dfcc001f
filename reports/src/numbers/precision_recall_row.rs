//! `precision_recall.csv`: precision and recall of each detector without its detections below a score.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::average_precision::OperatingPoint;
use crate::vocabulary::task::Task;

row! {
    /// One detector on one data set in one task, from one score on.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct PrecisionRecallRow {
        dataset: String,
        task: Task,
        detector: String,
        min_score: Fixed<6>,
        no: u64,
        tp: u64,
        fo: u64,
        precision: Fixed<6>,
        recall: Option<Fixed<6>>,
    }
}

impl PrecisionRecallRow {
    /// The row of `point`, where there are `no` annotations. Recall is undefined without any.
    pub fn new(dataset: &str, task: Task, detector: &str, no: u64, point: &OperatingPoint) -> Self {
        let [dataset, detector] = [dataset, detector].map(str::to_owned);
        Self {
            dataset,
            task,
            detector,
            min_score: Fixed::rounded(f64::from(point.min_score)),
            no,
            tp: point.tp,
            fo: point.fo,
            precision: Fixed::rounded(point.precision()),
            recall: (no > 0).then(|| Fixed::rounded(point.tp as f64 / no as f64)),
        }
    }

    /// Data set, task and detector of the row.
    pub fn subject(&self) -> (&str, Task, &str) {
        (&self.dataset, self.task, &self.detector)
    }

    /// The point itself.
    pub fn point(&self) -> OperatingPoint {
        OperatingPoint { min_score: self.min_score.0 as f32, tp: self.tp, fo: self.fo }
    }

    /// Recall and precision; `None` if recall is undefined.
    pub fn position(&self) -> Option<(f64, f64)> {
        Some((self.recall?.0, self.precision.0))
    }
}
