//! How sure a decision is: scores turned into chances that are right as often as they say.

use crate::portable_math::{exp, ln};

/// The scores of a cloud that was not learned from, and its class.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutScores {
    /// A score for each class, of which the largest decides.
    pub scores: Vec<f32>,
    /// Its class.
    pub class_idx: usize,
}

/// The logarithms of the least and the largest factor.
const LOG_RANGE: [f64; 2] = [-6.0, 8.0];
/// The range is cut by a third in each.
const N_CUTS: usize = 40;

/// The factor of scores that makes the right classes most likely; 1 without scores.
///
/// The cost is convex in the factor, so that a search by thirds finds its least.
pub fn learn_sharpness(held_out: &[HeldOutScores]) -> f32 {
    if held_out.is_empty() {
        return 1.0;
    }
    let [mut low, mut high] = LOG_RANGE;
    for _ in 0..N_CUTS {
        let third = (high - low) / 3.0;
        if cost(held_out, exp(low + third)) <= cost(held_out, exp(high - third)) {
            high -= third;
        } else {
            low += third;
        }
    }
    exp(0.5 * (low + high)) as f32
}

/// The mean of the negative logarithms of the chances of the right classes.
fn cost(held_out: &[HeldOutScores], sharpness: f64) -> f64 {
    let of_cloud = |it: &HeldOutScores| {
        let right = f64::from(it.scores[it.class_idx]);
        let odds = |&score: &f32| exp((sharpness * (f64::from(score) - right)).clamp(-500.0, 500.0));
        ln(it.scores.iter().map(odds).sum())
    };
    held_out.iter().map(of_cloud).sum::<f64>() / held_out.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_that_are_right_three_times_of_four_get_that_chance() {
        let score = |class_idx| HeldOutScores { scores: vec![0.5, 0.0], class_idx };
        let sharpness = learn_sharpness(&[score(0), score(0), score(0), score(1)]);
        // exp(sharpness / 2) has to be 3.
        assert!((f64::from(sharpness) - 2.0 * 3.0_f64.ln()).abs() < 1e-4, "{sharpness}");
        assert_eq!(learn_sharpness(&[]), 1.0);
    }

    #[test]
    fn scores_that_say_nothing_are_not_trusted() {
        let score = |class_idx| HeldOutScores { scores: vec![0.5, 0.0], class_idx };
        assert!(learn_sharpness(&[score(0), score(1)]) < 0.01);
    }
}
