//! Why a report makes no table.

use crate::vocabulary::task::Task;

/// Why a report makes no table.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// The report is about a data set that the manifest does not list.
    #[error("the report has the data set {0:?}, but the manifest does not")]
    UnknownDataset(String),
    /// The report is about a detector that the manifest does not list.
    #[error("the report has the detector {0:?}, but the manifest does not")]
    UnknownDetector(String),
    /// A number is missing.
    #[error("the report has no {metric} of {detector} on {dataset} in the task {task}")]
    Missing {
        /// Id of the data set.
        dataset: String,
        /// The task.
        task: Task,
        /// Name of the detector.
        detector: String,
        /// Id of the metric.
        metric: String,
    },
    /// A count is not one.
    #[error("{metric} of {detector} on {dataset} in the task {task} is {value:?}, which is not a count")]
    BadCount {
        /// Id of the data set.
        dataset: String,
        /// The task.
        task: Task,
        /// Name of the detector.
        detector: String,
        /// Id of the metric.
        metric: String,
        /// The value.
        value: Option<f64>,
    },
    /// Two detectors were judged by different annotations.
    #[error("on {dataset}, {first} has {n_first} annotations that count, but {second} has {n_second}")]
    DifferentAnnotations {
        /// Id of the data set.
        dataset: String,
        /// Name of one detector.
        first: String,
        /// NO of it.
        n_first: u64,
        /// Name of the other.
        second: String,
        /// NO of the other.
        n_second: u64,
    },
}
