//! Calibration: expected against observed outcomes.

use std::iter::repeat_n;

use crate::numbers::average_precision::OperatingPoint;

/// Examples whose expected outcomes are in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationBin {
    /// Mean of the expected outcomes.
    pub expected: f64,
    /// Mean of the observed outcomes.
    pub observed: f64,
    /// Number of examples.
    pub n: usize,
}

/// The bins of `judged`, pairs of an expected and an observed outcome, each 0 to 1: ten of equal width, less the empty ones.
pub fn calibration(judged: impl Iterator<Item = (f64, f64)>) -> Vec<CalibrationBin> {
    let mut sums = [(0.0, 0.0, 0); 10];
    for (expected, observed) in judged {
        let bin = &mut sums[((expected * 10.0) as usize).min(9)];
        *bin = (bin.0 + expected, bin.1 + observed, bin.2 + 1);
    }
    let bin = |(expected, observed, n): (f64, f64, usize)| CalibrationBin {
        expected: expected / n as f64,
        observed: observed / n as f64,
        n,
    };
    sums.into_iter().filter(|it| it.2 > 0).map(bin).collect()
}

/// The bins of the detections of an operating curve: their probability by score of being right, and the share that is.
///
/// Scores that all lie within 0 to 1 are probabilities; others are logarithms of odds.
pub fn calibration_of_scores(curve: &[OperatingPoint]) -> Vec<CalibrationBin> {
    let are_probabilities = curve.iter().all(|it| (0.0..=1.0).contains(&it.min_score));
    let probability = |score: f64| if are_probabilities { score } else { 1.0 / (1.0 + (-score).exp()) };
    let before = [(0, 0)].into_iter().chain(curve.iter().map(|it| (it.tp, it.fo)));
    calibration(curve.iter().zip(before).flat_map(|(it, (tp_before, fo_before))| {
        let expected = probability(it.min_score.into());
        let right = repeat_n((expected, 1.0), (it.tp - tp_before) as usize);
        right.chain(repeat_n((expected, 0.0), (it.fo - fo_before) as usize))
    }))
}

/// Expected calibration error: the mean over all examples of the difference between expected and observed in their bin, 0
/// to 1. `None` without bins.
///
/// Naeini, Cooper, Hauskrecht 2015, *Obtaining well calibrated probabilities using Bayesian binning*.
pub fn calibration_error(bins: &[CalibrationBin]) -> Option<f64> {
    let n: usize = bins.iter().map(|it| it.n).sum();
    let differences = bins.iter().map(|it| it.n as f64 * (it.expected - it.observed).abs());
    (n > 0).then(|| differences.sum::<f64>() / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::average_precision::{RankedDetection, operating_points};

    #[test]
    fn scores_are_log_odds_unless_all_are_probabilities() {
        let curve = |scored: &[(f32, bool)]| {
            let ranked: Vec<_> =
                scored.iter().map(|&(score, is_match)| RankedDetection { score, is_match }).collect();
            operating_points(&ranked)
        };
        // Three quarters of the detections with odds of three to one are right, and so is the sure one.
        let odds = 3.0_f32.ln();
        let scored = [(odds, true), (odds, true), (odds, false), (odds, true), (30.0, true)];
        let bins = calibration_of_scores(&curve(&scored));
        assert_eq!(bins.iter().map(|it| it.n).collect::<Vec<_>>(), [4, 1]);
        assert!(bins.iter().all(|it| (it.expected - it.observed).abs() < 1e-6), "{bins:?}");
        assert!(calibration_error(&bins).unwrap() < 1e-6);
        // One of two detections with a probability of 90 % is right: an error of 0.4.
        let bins = calibration_of_scores(&curve(&[(0.9, true), (0.9, false)]));
        assert!((calibration_error(&bins).unwrap() - 0.4).abs() < 1e-6);
        assert_eq!(calibration_error(&[]), None);
    }

    #[test]
    fn a_bin_has_the_means_of_its_examples() {
        let bins = calibration([(0.12, 0.0), (0.18, 1.0), (1.0, 1.0)].into_iter());
        assert_eq!(bins.len(), 2);
        assert!((bins[0].expected - 0.15).abs() < 1e-12 && bins[0].observed == 0.5 && bins[0].n == 2);
        assert_eq!(bins[1], CalibrationBin { expected: 1.0, observed: 1.0, n: 1 });
    }
}
