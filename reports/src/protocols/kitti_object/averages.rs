//! Recalls over which a mean is taken.

use std::ops::RangeInclusive;

use super::recall_curve::{N_RECALLS, RecallCurve};
use crate::vocabulary::named::named;

named! {
    /// The recalls of a mean.
    pub enum Recalls {
        /// 0, 0.1, …, 1: until 8 October 2019.
        R11 = "r11",
        /// 1/40, 2/40, …, 1: since then. Recall 0, where a single detection that is right gives precision 1, is left out.
        R40 = "r40",
    }
}

impl Recalls {
    /// The recalls in steps, and how many steps make a recall of 1.
    pub fn steps(self) -> (RangeInclusive<u64>, u64) {
        match self {
            Self::R11 => (0..=10, 10),
            Self::R40 => (1..=40, 40),
        }
    }

    /// Mean of values that were looked up at 41 recalls; `None` if one of them is NaN.
    fn mean_of(self, values: &[f64; N_RECALLS]) -> Option<f64> {
        let (steps, n_steps) = self.steps();
        let stride = (N_RECALLS - 1) / n_steps as usize;
        let n = steps.clone().count();
        let sum: f64 = steps.map(|step| values[step as usize * stride]).sum();
        Some(sum / n as f64).filter(|it| it.is_finite())
    }
}

impl RecallCurve {
    /// Average precision, 0 to 1.
    pub fn average_precision(&self, recalls: Recalls) -> Option<f64> {
        recalls.mean_of(&self.precision)
    }

    /// Average similarity of headings, 0 to 1.
    pub fn average_similarity(&self, recalls: Recalls) -> Option<f64> {
        recalls.mean_of(&self.similarity)
    }
}
