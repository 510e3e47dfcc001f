//! `confusion.csv`: annotated classes by the classes that detectors give.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::shown_text::printable_name;

/// Stands for no annotation, or no detection.
pub const NONE: &str = "none";

row! {
    /// Number of objects of a class that a detector gives a class, in the pairs of the task *objects*.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
    pub struct ConfusionRow {
        /// Id of the data set.
        #[serde(deserialize_with = "printable_name")]
        pub dataset: String,
        /// Name of the detector.
        #[serde(deserialize_with = "printable_name")]
        pub detector: String,
        /// The class of the annotation; `none` of false detections.
        pub annotated: String,
        /// The class that the detector gives, or else its kind; `none` of missed annotations.
        pub detected: String,
        /// How many.
        pub n: u64,
    }
}
