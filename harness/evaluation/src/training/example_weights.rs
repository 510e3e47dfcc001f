//! Weights of the examples of each data set.

/// The examples of a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatasetExamples {
    /// Whether it was recorded and not simulated.
    pub is_recorded: bool,
    /// Number of its examples.
    pub n_examples: usize,
}

/// Greatest weight of an example of a recorded data set, in simulated examples: a leaf of a tree has to rest on several.
pub const MOST_WEIGHT: f64 = 20.0;

/// Weight of an example of each data set.
///
/// Recorded data sets weigh the same, whatever their size, and together as much as all simulated ones, up to a weight of
/// [`MOST_WEIGHT`] an example. A simulated example weighs 1. Without simulated examples the mean weight is 1.
pub fn example_weights(datasets: &[DatasetExamples]) -> Vec<f64> {
    let n_of = |is_recorded: bool| {
        let of_kind = datasets.iter().filter(|it| it.is_recorded == is_recorded);
        of_kind.map(|it| it.n_examples as f64).sum::<f64>()
    };
    let n_recorded_sets = datasets.iter().filter(|it| it.is_recorded && it.n_examples > 0).count() as f64;
    let together = if n_of(false) > 0.0 { n_of(false) } else { n_of(true) };
    let weight = |it: &DatasetExamples| {
        if it.is_recorded && it.n_examples > 0 {
            (together / (n_recorded_sets * it.n_examples as f64)).min(MOST_WEIGHT)
        } else {
            1.0
        }
    };
    datasets.iter().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(datasets: &[(bool, usize)], expected: &[f64]) {
        let datasets: Vec<_> = datasets
            .iter()
            .map(|&(is_recorded, n_examples)| DatasetExamples { is_recorded, n_examples })
            .collect();
        assert_eq!(example_weights(&datasets), expected);
    }

    #[test]
    fn recorded_data_sets_count_once_and_together_as_much_as_simulated_ones() {
        check(&[(false, 300), (false, 100)], &[1.0, 1.0]);
        // 400 by half: 200 each.
        check(&[(false, 300), (true, 100), (false, 100), (true, 40)], &[1.0, 2.0, 1.0, 5.0]);
        check(&[(true, 100), (true, 300)], &[2.0, 2.0 / 3.0]);
        check(&[(false, 1000), (true, 10), (true, 0)], &[1.0, MOST_WEIGHT, 1.0]);
        check(&[], &[]);
    }
}
