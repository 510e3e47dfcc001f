//! `times_of_processors.csv`: times of a run whose scans were timed on unlike processors, each by itself.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::numbers::run_report::MetricRow;
use crate::vocabulary::task::Task;

row! {
    /// A time on one kind of processor.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct ProcessorTimeRow {
        /// The processor's own name.
        pub processor: String,
        /// Id of the data set.
        pub dataset: String,
        /// The task.
        pub task: Task,
        /// Name of the detector.
        pub detector: String,
        /// Id of the metric.
        pub metric: String,
        /// Its value; `None` where it is undefined.
        pub value: Option<f64>,
        /// Its unit.
        pub unit: String,
        /// Number of timed scans.
        pub n: u64,
    }
}

impl ProcessorTimeRow {
    /// `row` as it was measured on `processor`.
    pub fn new(processor: &str, row: &MetricRow) -> Self {
        Self {
            processor: processor.to_owned(),
            dataset: row.subject.dataset.clone(),
            task: row.subject.task,
            detector: row.subject.detector.clone(),
            metric: row.metric.id(),
            value: row.value(),
            unit: row.metric.unit().to_owned(),
            n: row.n,
        }
    }
}
