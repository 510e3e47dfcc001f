//! Weights that part the classes.

use super::decision::{ClassWeights, WeightParams};
use crate::portable_math::{exp, ln};

/// The bag of a training cloud: the columns that are not 0, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingBag {
    /// Its class.
    pub class_idx: usize,
    /// Its share of the whole training.
    pub weight: f64,
    /// Columns and numbers.
    pub entries: Vec<(u32, f32)>,
}

/// The weights, a list for each class, under which the bags are most likely: multinomial logistic regression, with a penalty
/// on the squares of weights.
///
/// Descent with steps of a length of its own for each weight (Kingma and Ba 2015), which shorten to nothing.
pub fn learn_class_weights(
    bags: &[TrainingBag],
    (n_classes, n_columns): (usize, usize),
    params: &WeightParams,
) -> Vec<ClassWeights> {
    // For each column the numbers of all classes, then the offsets.
    let n_weights = n_classes * (n_columns + 1);
    let mut descent =
        Descent { weights: vec![0.0; n_weights], means: vec![0.0; n_weights], squares: vec![0.0; n_weights] };
    let mut slopes = vec![0.0; n_weights];
    for step in 0..params.n_steps {
        slopes_at(&descent.weights, bags, (n_classes, params.penalty), &mut slopes);
        let left = 1.0 - step as f64 / params.n_steps as f64;
        descent.step(&slopes, step, params.step_size * left);
    }
    let of_class = |class_idx: usize| ClassWeights {
        offset: descent.weights[n_columns * n_classes + class_idx] as f32,
        of_columns: (0..n_columns).map(|it| descent.weights[it * n_classes + class_idx] as f32).collect(),
    };
    (0..n_classes).map(of_class).collect()
}

struct Descent {
    weights: Vec<f64>,
    means: Vec<f64>,
    squares: Vec<f64>,
}

impl Descent {
    fn step(&mut self, slopes: &[f64], step: usize, step_size: f64) {
        const KEPT_MEAN: f64 = 0.9;
        const KEPT_SQUARE: f64 = 0.999;
        let order = (step + 1) as f64;
        let seen_mean = 1.0 - exp(order * ln(KEPT_MEAN));
        let seen_square = 1.0 - exp(order * ln(KEPT_SQUARE));
        for (it, &slope) in slopes.iter().enumerate() {
            self.means[it] = KEPT_MEAN * self.means[it] + (1.0 - KEPT_MEAN) * slope;
            self.squares[it] = KEPT_SQUARE * self.squares[it] + (1.0 - KEPT_SQUARE) * slope * slope;
            let square = (self.squares[it] / seen_square).sqrt();
            self.weights[it] -= step_size * self.means[it] / seen_mean / (square + 1e-12);
        }
    }
}

/// How the cost grows with every weight.
fn slopes_at(weights: &[f64], bags: &[TrainingBag], (n_classes, penalty): (usize, f64), slopes: &mut [f64]) {
    let n_of_columns = weights.len() - n_classes;
    for (slope, weight) in slopes.iter_mut().zip(weights) {
        *slope = 2.0 * penalty * weight;
    }
    slopes[n_of_columns..].fill(0.0);
    let mut chances = vec![0.0; n_classes];
    for bag in bags {
        chances.copy_from_slice(&weights[n_of_columns..]);
        for &(column, value) in &bag.entries {
            let at = column as usize * n_classes;
            for (chance, weight) in chances.iter_mut().zip(&weights[at..at + n_classes]) {
                *chance += weight * f64::from(value);
            }
        }
        softmax(&mut chances);
        chances[bag.class_idx] -= 1.0;
        for chance in &mut chances {
            *chance *= bag.weight;
        }
        for &(column, value) in &bag.entries {
            let at = column as usize * n_classes;
            for (slope, chance) in slopes[at..at + n_classes].iter_mut().zip(&chances) {
                *slope += chance * f64::from(value);
            }
        }
        for (slope, chance) in slopes[n_of_columns..].iter_mut().zip(&chances) {
            *slope += chance;
        }
    }
}

/// Scores as chances that add up to 1.
fn softmax(scores: &mut [f64]) {
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut sum = 0.0;
    for score in &mut *scores {
        *score = exp((*score - largest).max(-500.0));
        sum += *score;
    }
    for score in scores {
        *score /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bag(class_idx: usize, entries: &[(u32, f32)]) -> TrainingBag {
        TrainingBag { class_idx, weight: 0.25, entries: entries.to_vec() }
    }

    #[test]
    fn what_parts_the_classes_has_weight_and_what_does_not_has_none() {
        let bags = [
            bag(0, &[(0, 1.0), (2, 1.0)]),
            bag(0, &[(0, 1.0)]),
            bag(1, &[(1, 1.0), (2, 1.0)]),
            bag(1, &[(1, 1.0)]),
        ];
        let params = WeightParams { penalty: 1e-3, n_steps: 400, step_size: 0.1 };
        let [first, second] = learn_class_weights(&bags, (2, 3), &params).try_into().unwrap();
        assert!(first.of_columns[0] > 1.0 && first.of_columns[1] < -1.0, "{first:?}");
        assert!(first.of_columns[2].abs() < 0.01 && first.offset.abs() < 0.01, "{first:?}");
        assert!((first.of_columns[0] + second.of_columns[0]).abs() < 1e-4, "{second:?}");
    }

    #[test]
    fn without_bags_nothing_is_learned() {
        let params = WeightParams { penalty: 0.0, n_steps: 5, step_size: 0.1 };
        let weights = learn_class_weights(&[], (2, 1), &params);
        assert_eq!(weights, vec![ClassWeights { offset: 0.0, of_columns: vec![0.0] }; 2]);
    }
}
