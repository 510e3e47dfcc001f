//! The meaning of a difference for a gate.

use crate::vocabulary::named::named;

named! {
    /// What a difference means.
    pub enum Finding {
        /// Surely worse than tolerated.
        Regression = "regression",
        /// A number is missing on one side, so nothing can be said.
        Incomparable = "incomparable",
        /// Worse than tolerated, but it may be chance.
        Inconclusive = "inconclusive",
        /// Not worse than tolerated.
        Pass = "pass",
    }
}

impl Finding {
    /// The word that people read.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Regression => "worse",
            Self::Incomparable => "missing",
            Self::Inconclusive => "inconclusive",
            Self::Pass => "passed",
        }
    }

    /// The finding of a number that is worse by `worsening`, and surely by `sure` if anything can be sure.
    pub(super) fn of(worsening: f64, sure: Option<f64>, tolerance: f64) -> Self {
        if sure.is_some_and(|it| it > tolerance) {
            Self::Regression
        } else if worsening > tolerance {
            Self::Inconclusive
        } else {
            Self::Pass
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_surely_worse_than_tolerated_is_a_regression() {
        assert_eq!(Finding::of(0.3, Some(0.11), 0.1), Finding::Regression);
        assert_eq!(Finding::of(0.3, Some(0.1), 0.1), Finding::Inconclusive);
        assert_eq!(Finding::of(0.3, None, 0.1), Finding::Inconclusive);
        assert_eq!(Finding::of(0.1, None, 0.1), Finding::Pass);
        assert_eq!(Finding::of(-0.3, Some(-0.4), 0.0), Finding::Pass);
    }
}
