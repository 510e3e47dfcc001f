//! `agreement.csv`: how far the detectors of a run agree on scans without labels.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::shown_text::printable_name;
use crate::vocabulary::task::Task;

row! {
    /// What two detectors found in the scans of a data set.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
    pub struct AgreementRow {
        /// The data set.
        #[serde(deserialize_with = "printable_name")]
        pub dataset: String,
        /// What is asked for.
        pub task: Task,
        /// The detector.
        #[serde(deserialize_with = "printable_name")]
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
        /// Detections of the detector that no other one of the run has.
        pub n_alone: u64,
    }
}

/// Adds `rows` to those of `sums` about the same detectors, task and data set.
pub fn add_agreement(sums: &mut Vec<AgreementRow>, rows: impl IntoIterator<Item = AgreementRow>) {
    for row in rows {
        let about = |it: &AgreementRow| (it.dataset.clone(), it.task, it.detector.clone(), it.other.clone());
        match sums.iter_mut().find(|it| about(it) == about(&row)) {
            None => sums.push(row),
            Some(sum) => {
                sum.n_scans += row.n_scans;
                sum.n_detections += row.n_detections;
                sum.n_other += row.n_other;
                sum.n_both += row.n_both;
                sum.n_alone += row.n_alone;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_about_the_same_detectors_is_summed() {
        let row = |other: &str, n_both| AgreementRow {
            dataset: "street".to_owned(),
            task: Task::Objects,
            detector: "pca".to_owned(),
            other: other.to_owned(),
            n_scans: 1,
            n_detections: 5,
            n_other: 4,
            n_both,
            n_alone: 1,
        };
        let mut sums = Vec::new();
        add_agreement(&mut sums, [row("kd-tree", 3), row("grid", 1), row("kd-tree", 2)]);
        let n: Vec<_> = sums.iter().map(|it| (it.other.as_str(), it.n_scans, it.n_both)).collect();
        assert_eq!(n, [("kd-tree", 2, 5), ("grid", 1, 1)]);
    }
}
