//! The decision about the class of a bag.

use serde::{Deserialize, Serialize};

use crate::portable_math::exp;

/// Tuning of [`Decision`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DecisionParams {
    /// The rule that decides.
    pub rule: DecisionRule,
    /// Which mean bags stand for a class.
    pub centers: Centers,
    /// Clouds with fewer keypoints are not judged.
    pub min_keypoints: usize,
    /// Where bins of the number of keypoints end, ascending: how sure a decision is differs from bin to bin.
    pub evidence_edges: Vec<usize>,
    /// Share of the clouds of known classes that are not rejected, in each bin of evidence; clouds stranger than these are
    /// of none of the classes. 1: no cloud is too strange.
    pub near_share: f64,
    /// A class of this name is none of these; empty: there is no such class.
    pub rejected_class: String,
    /// Number of parts in which objects are held out to learn how sure decisions are.
    pub n_folds: usize,
    /// The weights, if they decide.
    pub weights: WeightParams,
}

/// The rule that decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DecisionRule {
    /// The least L1 distance to a mean bag. The paper's.
    Nearest,
    /// The largest weighted sum of the bag, with weights learned to part the classes.
    Weighted,
}

/// Which mean bags stand for a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Centers {
    /// The mean of all its training clouds. The paper's.
    OfClass,
    /// A mean for each part that has been seen of them; the nearest counts.
    OfParts,
}

/// Tuning of weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightParams {
    /// Cost of the square of a weight, in units of the mean cost of a cloud.
    pub penalty: f64,
    /// Steps of the descent.
    pub n_steps: usize,
    /// Length of the first step.
    pub step_size: f64,
}

/// The mean bag of a class, or of a part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Center {
    /// Its class.
    pub class_idx: usize,
    /// A number for each column.
    pub bag: Vec<f32>,
}

/// Weights of a class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassWeights {
    /// Score of an empty bag.
    pub offset: f32,
    /// A number for each column.
    pub of_columns: Vec<f32>,
}

/// Everything that is learned to decide.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// Mean bags.
    pub centers: Vec<Center>,
    /// One for each class; none where the nearest mean bag decides.
    pub weights: Vec<ClassWeights>,
    /// For each bin of the number of keypoints: the factor that makes scores logarithms of odds.
    pub sharpness: Vec<f32>,
    /// For each bin of the number of keypoints: how strange a cloud may be, see [`strangeness`].
    pub strangest: Vec<f32>,
}

/// The possible decisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// A class, or none of these.
    OrNoneOfThese,
    /// One of the classes: no other objects occur.
    OfClasses,
}

/// Inputs of a decision, beside the learned ones.
#[derive(Debug, Clone, Copy)]
pub struct DecidedBy<'a> {
    /// The parameters.
    pub params: &'a DecisionParams,
    /// The class that is none of these.
    pub rejected_idx: Option<usize>,
    /// The possible decisions.
    pub choice: Choice,
}

/// Verdict on a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It has too few keypoints to be judged.
    TooLittleSeen,
    /// None of the learned classes.
    NoneOfThese,
    /// The class with this index.
    Class(usize),
}

/// Everything that is decided about a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// L1 distance to every class; the paper's error.
    pub distances: Vec<f32>,
    /// The chance of every class; they add up to 1.
    pub probabilities: Vec<f32>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Judgement {
    /// The judgement without evidence, among so many classes.
    pub fn of_nothing(n_classes: usize) -> Self {
        let probabilities = vec![1.0 / n_classes as f32; n_classes];
        Self { distances: vec![f32::INFINITY; n_classes], probabilities, verdict: Verdict::TooLittleSeen }
    }
}

impl Decision {
    /// Judges the bag of a cloud with `n_keypoints` keypoints.
    ///
    /// Of equal classes the first counts. Paper: BG section 3.3.
    pub fn judge(&self, bag: &[f32], n_keypoints: usize, by: &DecidedBy<'_>, judgement: &mut Judgement) {
        let Judgement { distances, probabilities, verdict } = judgement;
        self.scores(bag, distances, probabilities);
        let evidence = evidence_bin(n_keypoints, &by.params.evidence_edges);
        let is_strange = by.choice == Choice::OrNoneOfThese
            && strangeness(distances, probabilities, by.rejected_idx) > self.strangest[evidence];
        if by.choice == Choice::OfClasses
            && let Some(rejected_idx) = by.rejected_idx
        {
            probabilities[rejected_idx] = f32::NEG_INFINITY;
        }
        let best = best_known(probabilities, by.rejected_idx);
        to_probabilities(probabilities, self.sharpness[evidence]);
        *verdict = match best {
            Some(best) if n_keypoints >= by.params.min_keypoints => {
                if is_strange {
                    Verdict::NoneOfThese
                } else {
                    Verdict::Class(best)
                }
            }
            _ => Verdict::TooLittleSeen,
        };
    }

    /// Writes the L1 distance of `bag` to every class, and its scores, of which the largest decides.
    pub fn scores(&self, bag: &[f32], distances: &mut [f32], scores: &mut [f32]) {
        distances.fill(f32::INFINITY);
        for center in &self.centers {
            let distance = &mut distances[center.class_idx];
            *distance = l1_distance(bag, &center.bag).min(*distance);
        }
        if self.weights.is_empty() {
            for (score, distance) in scores.iter_mut().zip(distances) {
                *score = -*distance;
            }
        } else {
            for (score, weights) in scores.iter_mut().zip(&self.weights) {
                *score = weights.offset + scalar_product(bag, &weights.of_columns);
            }
        }
    }
}

/// The class with the largest score that is not the rejected one, the first of equals.
fn best_known(scores: &[f32], rejected_idx: Option<usize>) -> Option<usize> {
    let known = (0..scores.len()).filter(|&it| Some(it) != rejected_idx);
    known.reduce(|best, it| if scores[it] > scores[best] { it } else { best })
}

/// How strange a cloud is to all known classes: by how much the score of the rejected class exceeds theirs, or without one,
/// how far the nearest class is.
pub fn strangeness(distances: &[f32], scores: &[f32], rejected_idx: Option<usize>) -> f32 {
    match (rejected_idx, best_known(scores, rejected_idx)) {
        (Some(rejected_idx), Some(best)) => scores[rejected_idx] - scores[best],
        _ => distances.iter().copied().fold(f32::INFINITY, f32::min),
    }
}

/// Sums that are added up side by side, so that an addition need not wait for the one before.
const N_SUMS: usize = 8;

fn l1_distance(a: &[f32], b: &[f32]) -> f32 {
    sum_of(a, b, |a, b| (a - b).abs())
}

fn scalar_product(a: &[f32], b: &[f32]) -> f32 {
    sum_of(a, b, |a, b| a * b)
}

#[inline(always)]
fn sum_of(a: &[f32], b: &[f32], of_pair: impl Fn(f32, f32) -> f32) -> f32 {
    let mut sums = [0.0; N_SUMS];
    let (a_chunks, a_rest) = a.as_chunks::<N_SUMS>();
    let (b_chunks, b_rest) = b.as_chunks::<N_SUMS>();
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..N_SUMS {
            sums[lane] += of_pair(a[lane], b[lane]);
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(&a, &b)| of_pair(a, b)).sum();
    sums.iter().sum::<f32>() + rest
}

/// The bin of a number of keypoints.
pub fn evidence_bin(n_keypoints: usize, edges: &[usize]) -> usize {
    edges.partition_point(|&edge| edge <= n_keypoints)
}

/// Turns scores into chances that add up to 1.
pub fn to_probabilities(scores: &mut [f32], sharpness: f32) {
    let largest = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0;
    for score in &mut *scores {
        let exponent = f64::from(sharpness * (*score - largest));
        // Less than that vanishes beside the largest, which is 1, in single precision.
        *score = if exponent > -80.0 { exp(exponent) as f32 } else { 0.0 };
        sum += *score;
    }
    for score in scores {
        *score /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> DecisionParams {
        DecisionParams {
            rule: DecisionRule::Nearest,
            centers: Centers::OfClass,
            min_keypoints: 2,
            evidence_edges: vec![4],
            near_share: 1.0,
            rejected_class: String::new(),
            n_folds: 2,
            weights: WeightParams { penalty: 0.0, n_steps: 0, step_size: 0.0 },
        }
    }

    fn decision() -> Decision {
        let center = |class_idx, bag: [f32; 2]| Center { class_idx, bag: bag.to_vec() };
        Decision {
            centers: vec![center(0, [1.0, 0.0]), center(1, [0.0, 1.0]), center(1, [0.5, 0.5])],
            weights: Vec::new(),
            sharpness: vec![1.0, 2.0],
            strangest: vec![f32::INFINITY, 0.5],
        }
    }

    fn judged(bag: &[f32], n_keypoints: usize, rejected_idx: Option<usize>, choice: Choice) -> Judgement {
        let mut judgement = Judgement::of_nothing(2);
        let params = params();
        let by = DecidedBy { params: &params, rejected_idx, choice };
        decision().judge(bag, n_keypoints, &by, &mut judgement);
        judgement
    }

    fn known(bag: &[f32], n_keypoints: usize) -> Judgement {
        judged(bag, n_keypoints, None, Choice::OrNoneOfThese)
    }

    #[test]
    fn the_nearest_mean_bag_decides_and_a_class_may_have_several() {
        let judgement = known(&[0.75, 0.25], 4);
        assert_eq!(judgement.distances, [0.5, 0.5]);
        assert_eq!((judgement.verdict, judgement.probabilities), (Verdict::Class(0), vec![0.5, 0.5]));
        let judgement = known(&[0.5, 0.25], 4);
        assert_eq!((&judgement.distances[..], judgement.verdict), (&[0.75, 0.25][..], Verdict::Class(1)));
        // exp(−2 · 0.5) against 1.
        assert!((judgement.probabilities[1] - 1.0 / (1.0 + (-1.0_f32).exp())).abs() < 1e-6);
    }

    #[test]
    fn fewer_keypoints_are_less_evidence_and_too_few_none() {
        assert!(known(&[1.0, 0.0], 3).probabilities[0] < known(&[1.0, 0.0], 4).probabilities[0]);
        assert_eq!(known(&[1.0, 0.0], 1).verdict, Verdict::TooLittleSeen);
    }

    #[test]
    fn what_is_far_from_all_is_none_of_these_unless_nothing_else_occurs() {
        assert_eq!(known(&[9.0, 0.0], 4).verdict, Verdict::NoneOfThese);
        assert_eq!(known(&[9.0, 0.0], 3).verdict, Verdict::Class(0));
        assert_eq!(judged(&[9.0, 0.0], 4, None, Choice::OfClasses).verdict, Verdict::Class(0));
    }

    #[test]
    fn what_is_more_like_the_rejected_class_than_allowed_is_none_of_these() {
        // Scores are distances with the other sign: 0 to the rejected class, -2 to the other one with several means.
        let of_rejected = [1.0, 0.0];
        assert_eq!(strangeness(&[0.0, 1.0], &[0.0, -1.0], Some(0)), 1.0);
        let rejected = judged(&of_rejected, 4, Some(0), Choice::OrNoneOfThese);
        assert_eq!(rejected.verdict, Verdict::NoneOfThese);
        // With so little evidence nothing is too strange, but it is never taken for the rejected class.
        assert_eq!(judged(&of_rejected, 3, Some(0), Choice::OrNoneOfThese).verdict, Verdict::Class(1));
        let known = judged(&of_rejected, 4, Some(0), Choice::OfClasses);
        assert_eq!((known.verdict, &known.probabilities[..]), (Verdict::Class(1), &[0.0, 1.0][..]));
        assert_eq!(judged(&[0.0, 1.0], 4, Some(0), Choice::OrNoneOfThese).verdict, Verdict::Class(1));
    }

    #[test]
    fn weights_decide_where_there_are_some() {
        let weights = |offset, of_columns: [f32; 2]| ClassWeights { offset, of_columns: of_columns.to_vec() };
        let decision =
            Decision { weights: vec![weights(0.0, [1.0, 0.0]), weights(0.5, [1.0, 1.0])], ..decision() };
        let mut judgement = Judgement::of_nothing(2);
        let params = params();
        let by = DecidedBy { params: &params, rejected_idx: None, choice: Choice::OrNoneOfThese };
        decision.judge(&[1.0, 0.0], 3, &by, &mut judgement);
        assert_eq!((judgement.verdict, &judgement.distances[..]), (Verdict::Class(1), &[0.0, 1.0][..]));
    }

    #[test]
    fn long_bags_are_added_up_whole() {
        let bag: Vec<f32> = (0..21).map(|it| it as f32).collect();
        assert_eq!((l1_distance(&bag, &[0.0; 21]), scalar_product(&bag, &[2.0; 21])), (210.0, 420.0));
    }
}
