//! `curves.csv` and its points: the rates of a classifier as its threshold falls.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;

row! {
    /// One threshold, with what the rates are made of.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct OperatingRow {
        threshold: Fixed<6>,
        n_vehicles: usize,
        n_others: usize,
        n_true: usize,
        n_false: usize,
        recall: Option<Fixed<6>>,
        false_positive_rate: Option<Fixed<6>>,
        precision: Option<Fixed<6>>,
    }
}

impl OperatingRow {
    /// The row of `threshold`, at which `n_true` of `n_vehicles` and `n_false` of `n_others` are classified as vehicles.
    pub fn new(threshold: f32, [n_true, n_false]: [usize; 2], [n_vehicles, n_others]: [usize; 2]) -> Self {
        let share = |part: usize, whole: usize| (whole > 0).then(|| Fixed(part as f64 / whole as f64));
        Self {
            threshold: Fixed(threshold.into()),
            n_vehicles,
            n_others,
            n_true,
            n_false,
            recall: share(n_true, n_vehicles),
            false_positive_rate: share(n_false, n_others),
            precision: share(n_true, n_true + n_false),
        }
    }

    /// False-positive rate and recall.
    pub(crate) fn roc_position(&self) -> Option<(f64, f64)> {
        Some((self.false_positive_rate.as_ref()?.0, self.recall.as_ref()?.0))
    }

    /// Recall and precision.
    pub(crate) fn precision_recall_position(&self) -> Option<(f64, f64)> {
        Some((self.recall.as_ref()?.0, self.precision.as_ref()?.0))
    }
}
