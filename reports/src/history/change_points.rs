//! Changes of the distribution of a sequence of numbers.
//!
//! Matteson & James 2014 (E-divisive), as Daly et al. 2020 use it on numbers of a CI: the split with the largest energy distance
//! between what is before it and a stretch after it is a change if permutations of the sequence hardly ever have one as large;
//! then both sides are looked at alike.

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Permutations that a split is held against.
const N_PERMUTATIONS: usize = 999;
/// The share of permutations with a larger distance below which a split is a change.
pub const SIGNIFICANCE: f64 = 0.01;
/// Sequences that are drawn for the uncertainty of a change.
const N_DRAWS: usize = 999;
/// Numbers on either side of a split, at least.
const FEWEST: usize = 2;
/// The draws are the same in every program run.
const SEED: u64 = 20_140_114;

/// A change.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangePoint {
    /// Index of the first number after it.
    pub first_after: usize,
    /// First and last index where it may as well be: the central 95 % of draws from both sides.
    pub within: [usize; 2],
    /// The share of permutations with a split at least as good, that of the sequence itself included.
    pub p_value: f64,
    /// Means from the change before to this one, and from this one to the next.
    pub means: [f64; 2],
    /// 95 % interval of the difference of the means, from the same draws.
    pub difference: [f64; 2],
}

/// The changes in `values`, in their order.
pub fn change_points(values: &[f64]) -> Vec<ChangePoint> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut splits = Vec::new();
    find_splits(values, 0, &mut splits, &mut random);
    splits.sort_unstable_by_key(|it| it.0);
    let ends = |idx: usize| {
        let before = if idx == 0 { 0 } else { splits[idx - 1].0 };
        [before, splits.get(idx + 1).map_or(values.len(), |it| it.0)]
    };
    let change = |(idx, &(at, p_value)): (usize, &(usize, f64))| {
        let [from, to] = ends(idx);
        let (before, after) = (&values[from..at], &values[at..to]);
        let (within, difference) = uncertainty(before, after, &mut random);
        ChangePoint {
            first_after: at,
            within: within.map(|it| from + it),
            p_value,
            means: [mean(before), mean(after)],
            difference,
        }
    };
    splits.iter().enumerate().map(change).collect()
}

/// Adds the significant splits of `values`, which begin at the index `from`, with their p-values.
fn find_splits(values: &[f64], from: usize, splits: &mut Vec<(usize, f64)>, random: &mut ChaCha8Rng) {
    let Some((at, distance)) = best_split(values) else { return };
    let Some(p_value) = significance(values, distance, random) else { return };
    splits.push((from + at, p_value));
    find_splits(&values[..at], from, splits, random);
    find_splits(&values[at..], from + at, splits, random);
}

/// The p-value of a split with this distance; `None` if it is not significant.
fn significance(values: &[f64], distance: f64, random: &mut ChaCha8Rng) -> Option<f64> {
    let mut permuted = values.to_vec();
    let mut n_as_good = 1;
    for _ in 0..N_PERMUTATIONS {
        permuted.shuffle(random);
        let is_as_good = best_split(&permuted).is_some_and(|(_, it)| it >= distance * (1.0 - 1e-12));
        n_as_good += usize::from(is_as_good);
        // It cannot become significant any more.
        if n_as_good as f64 > SIGNIFICANCE * (N_PERMUTATIONS + 1) as f64 {
            return None;
        }
    }
    Some(n_as_good as f64 / (N_PERMUTATIONS + 1) as f64)
}

/// The split with the largest scaled energy distance between what is before it and some stretch after it, of those with
/// [`FEWEST`] numbers on each side; `None` if there is none with any distance.
fn best_split(values: &[f64]) -> Option<(usize, f64)> {
    let n = values.len();
    // Sums of the distances of all pairs from the rows before one to the columns before another.
    let mut sums = vec![0.0; (n + 1) * (n + 1)];
    for row in 0..n {
        let mut of_row = 0.0;
        for column in 0..n {
            of_row += (values[row] - values[column]).abs();
            sums[(row + 1) * (n + 1) + column + 1] = sums[row * (n + 1) + column + 1] + of_row;
        }
    }
    let sum = |rows: [usize; 2], columns: [usize; 2]| {
        let before = |row: usize, column: usize| sums[row * (n + 1) + column];
        before(rows[1], columns[1]) - before(rows[0], columns[1]) - before(rows[1], columns[0])
            + before(rows[0], columns[0])
    };
    let mut best: Option<(usize, f64)> = None;
    for at in FEWEST..n.saturating_sub(FEWEST - 1) {
        for end in at + FEWEST..=n {
            let [left, right] = [at as f64, (end - at) as f64];
            let energy = 2.0 * sum([0, at], [at, end]) / (left * right)
                - sum([0, at], [0, at]) / (left * (left - 1.0))
                - sum([at, end], [at, end]) / (right * (right - 1.0));
            let distance = energy * left * right / (left + right);
            if distance > 1e-9 && best.is_none_or(|(_, most)| distance > most) {
                best = Some((at, distance));
            }
        }
    }
    best
}

/// Where the change may be, from the beginning of `before`, and the difference of the means, in draws with replacement from
/// both sides.
fn uncertainty(before: &[f64], after: &[f64], random: &mut ChaCha8Rng) -> ([usize; 2], [f64; 2]) {
    let mut positions = Vec::with_capacity(N_DRAWS);
    let mut differences = Vec::with_capacity(N_DRAWS);
    for _ in 0..N_DRAWS {
        let mut draw = |of: &[f64]| -> Vec<f64> {
            (0..of.len()).map(|_| of[random.random_range(0..of.len())]).collect()
        };
        let (left, right) = (draw(before), draw(after));
        differences.push(mean(&right) - mean(&left));
        let drawn = [left, right].concat();
        positions.push(best_split(&drawn).map_or(before.len(), |it| it.0));
    }
    positions.sort_unstable();
    differences.sort_by(f64::total_cmp);
    let ends = [N_DRAWS / 40, N_DRAWS - 1 - N_DRAWS / 40];
    (ends.map(|it| positions[it]), ends.map(|it| differences[it]))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal noise of this deviation.
    fn noise(random: &mut ChaCha8Rng, deviation: f64) -> f64 {
        let [a, b]: [f64; 2] = [random.random(), random.random()];
        deviation * (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    #[test]
    fn a_step_is_found_where_it_is() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let values: Vec<f64> =
            (0..40).map(|run| if run < 23 { 88.0 } else { 86.5 } + noise(&mut random, 0.2)).collect();
        let [change] = &change_points(&values)[..] else { panic!("{:?}", change_points(&values)) };
        assert_eq!(change.first_after, 23);
        assert!(change.within[0] >= 22 && change.within[1] <= 24, "{change:?}");
        assert!((change.means[0] - 88.0).abs() < 0.2 && (change.means[1] - 86.5).abs() < 0.2, "{change:?}");
        assert!(change.difference[0] > -1.8 && change.difference[1] < -1.2, "{change:?}");
        assert!(change.p_value <= SIGNIFICANCE);
    }

    #[test]
    fn steps_up_and_down_are_two_changes() {
        let values: Vec<f64> = (0..30)
            .map(|run| if (10..20).contains(&run) { 2.0 } else { 1.0 } + 0.01 * f64::from(run % 3))
            .collect();
        let at: Vec<usize> = change_points(&values).iter().map(|it| it.first_after).collect();
        assert_eq!(at, [10, 20]);
    }

    #[test]
    fn what_never_changes_has_no_change() {
        assert_eq!(change_points(&[]), []);
        assert_eq!(change_points(&[1.0; 3]), []);
        assert_eq!(change_points(&[0.8; 50]), []);
    }

    /// Of 200 sequences of noise about one in a hundred is called a change; twice as many and two more are improbable
    /// (binomial, p < 0.01).
    #[test]
    fn noise_is_seldom_called_a_change() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let is_called = |_: &i32| {
            let values: Vec<f64> = (0..40).map(|_| noise(&mut random, 0.3)).collect();
            !change_points(&values).is_empty()
        };
        let n_called = (0..200).filter(is_called).count();
        assert!(n_called <= 6, "{n_called}");
    }

    #[test]
    fn the_distance_is_that_of_its_definition() {
        let values = [1.0, 2.0, 4.0, 8.0, 9.0];
        // Sides 1 2 4 and 8 9: across 7 + 8 + 6 + 7 + 4 + 5 = 37, within 1 + 3 + 2 = 6 and 1.
        let energy = 2.0 * 37.0 / 6.0 - 2.0 * 6.0 / 6.0 - 2.0 * 1.0 / 2.0;
        let (at, distance) = best_split(&values).unwrap();
        assert_eq!(at, 3);
        assert!((distance - energy * 6.0 / 5.0).abs() < 1e-12);
    }
}
