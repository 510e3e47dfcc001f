//! Weights that separate the classes.

use rayon::prelude::*;

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
/// Descent with steps of a length of its own for each weight (Kingma and Ba 2015), which shorten to nothing. All threads
/// take part; the weights are the same to the bit with any number of them.
pub fn learn_class_weights(
    bags: &[TrainingBag],
    n_classes: usize,
    n_columns: usize,
    params: &WeightParams,
) -> Vec<ClassWeights> {
    // For each column the numbers of all classes, then the offsets.
    let n_weights = n_classes * (n_columns + 1);
    let mut descent =
        Descent { weights: vec![0.0; n_weights], means: vec![0.0; n_weights], squares: vec![0.0; n_weights] };
    let mut slopes = Slopes {
        by_column: ByColumn::of(bags, n_columns),
        excess: vec![0.0; bags.len() * n_classes],
        of_weights: vec![0.0; n_weights],
    };
    for step in 0..params.n_steps {
        slopes.fill(&descent.weights, bags, n_classes, params.penalty);
        let left = 1.0 - step as f64 / params.n_steps as f64;
        descent.step(&slopes.of_weights, step, params.step_size * left);
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

/// The numbers that are not 0, column by column, and within a column in the order of the bags.
struct ByColumn {
    /// Where each column begins, and where the last one ends.
    starts: Vec<usize>,
    /// Bags and numbers.
    entries: Vec<(u32, f32)>,
}

impl ByColumn {
    fn of(bags: &[TrainingBag], n_columns: usize) -> Self {
        let mut starts = vec![0; n_columns + 1];
        for &(column, _) in bags.iter().flat_map(|it| &it.entries) {
            starts[column as usize + 1] += 1;
        }
        for column in 0..n_columns {
            starts[column + 1] += starts[column];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0, 0.0); starts[n_columns]];
        for (bag_idx, bag) in (0..).zip(bags) {
            for &(column, value) in &bag.entries {
                let index = &mut next[column as usize];
                entries[*index] = (bag_idx, value);
                *index += 1;
            }
        }
        Self { starts, entries }
    }

    fn column(&self, column: usize) -> &[(u32, f32)] {
        &self.entries[self.starts[column]..self.starts[column + 1]]
    }
}

/// Fewest columns or bags that are worth a thread.
const LEAST_SHARE: usize = 64;

/// Slope of the cost along every weight.
struct Slopes {
    by_column: ByColumn,
    /// For each bag: how much more likely each class is than it should be, times the weight of the bag.
    excess: Vec<f64>,
    /// In the order of the weights.
    of_weights: Vec<f64>,
}

impl Slopes {
    /// Every thread adds up whole columns, each in the order of the bags, so that the number of threads changes nothing.
    fn fill(&mut self, weights: &[f64], bags: &[TrainingBag], n_classes: usize, penalty: f64) {
        let Self { by_column, excess, of_weights } = self;
        let n_of_columns = weights.len() - n_classes;
        let (of_columns, offsets) = weights.split_at(n_of_columns);
        let of_bags = excess.par_chunks_mut(n_classes).zip(bags).with_min_len(LEAST_SHARE);
        of_bags.for_each(|(excess, bag)| fill_excess(bag, of_columns, offsets, excess));
        let (slopes_of_columns, slopes_of_offsets) = of_weights.split_at_mut(n_of_columns);
        let columns = slopes_of_columns.par_chunks_mut(n_classes).zip(of_columns.par_chunks(n_classes));
        columns.enumerate().with_min_len(LEAST_SHARE).for_each(|(column, (slopes, weights))| {
            for (slope, weight) in slopes.iter_mut().zip(weights) {
                *slope = 2.0 * penalty * weight;
            }
            for &(bag_idx, value) in by_column.column(column) {
                let excess = &excess[bag_idx as usize * n_classes..][..n_classes];
                for (slope, excess) in slopes.iter_mut().zip(excess) {
                    *slope += excess * f64::from(value);
                }
            }
        });
        slopes_of_offsets.fill(0.0);
        for excess in excess.chunks(n_classes) {
            for (slope, excess) in slopes_of_offsets.iter_mut().zip(excess) {
                *slope += excess;
            }
        }
    }
}

fn fill_excess(bag: &TrainingBag, of_columns: &[f64], offsets: &[f64], excess: &mut [f64]) {
    let n_classes = offsets.len();
    excess.copy_from_slice(offsets);
    for &(column, value) in &bag.entries {
        let weights = &of_columns[column as usize * n_classes..][..n_classes];
        for (score, weight) in excess.iter_mut().zip(weights) {
            *score += weight * f64::from(value);
        }
    }
    softmax(excess);
    excess[bag.class_idx] -= 1.0;
    for excess in excess {
        *excess *= bag.weight;
    }
}

/// Turns scores into chances that add up to 1.
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
        let [first, second] = learn_class_weights(&bags, 2, 3, &params).try_into().unwrap();
        assert!(first.of_columns[0] > 1.0 && first.of_columns[1] < -1.0, "{first:?}");
        assert!(first.of_columns[2].abs() < 0.01 && first.offset.abs() < 0.01, "{first:?}");
        assert!((first.of_columns[0] + second.of_columns[0]).abs() < 1e-4, "{second:?}");
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        // More bags and columns than one thread takes at a time.
        let of_bag = |it: u32| {
            let value = |column: u32| (column, 1.0 / f32::from((it * 7 + column) as u16 % 13 + 1));
            bag(it as usize % 3, &[value(it % 5), value(5 + it % 300), value(305 + it * it % 7)])
        };
        let bags: Vec<TrainingBag> = (0..400).map(of_bag).collect();
        let params = WeightParams { penalty: 1e-3, n_steps: 20, step_size: 0.1 };
        let learned = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| learn_class_weights(&bags, 3, 312, &params))
        };
        assert_eq!(learned(1), learned(5));
        assert!(learned(1)[0].of_columns.iter().any(|it| it.abs() > 0.1));
    }

    #[test]
    fn without_bags_nothing_is_learned() {
        let params = WeightParams { penalty: 0.0, n_steps: 5, step_size: 0.1 };
        let weights = learn_class_weights(&[], 2, 1, &params);
        assert_eq!(weights, vec![ClassWeights { offset: 0.0, of_columns: vec![0.0] }; 2]);
    }
}
