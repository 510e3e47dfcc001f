//! How sure a median is.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::box_errors::MedianWithin;

/// Resamples of the tracks.
const N_RESAMPLES: usize = 10_000;

/// The lower median of `values`, with its 95 % interval by a bootstrap of the groups that the second of each pair names,
/// 0 to `n_groups`: whole groups are drawn, as values of one group are not independent. The same seed draws the same
/// groups. `None` without values.
pub fn median_within(values: &[(f64, usize)], n_groups: usize, seed: u64) -> Option<MedianWithin> {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = weighted_median(&sorted, &vec![1; n_groups])?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut n_drawn = vec![0_u32; n_groups];
    let mut medians: Vec<f64> = (0..N_RESAMPLES)
        .filter_map(|_| {
            n_drawn.fill(0);
            for _ in 0..n_groups {
                n_drawn[rng.random_range(0..n_groups)] += 1;
            }
            weighted_median(&sorted, &n_drawn)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    // By nearest rank.
    let quantile = |share: f64| medians[((share * medians.len() as f64).ceil() as usize).max(1) - 1];
    Some(MedianWithin { median, within: [quantile(0.025), quantile(0.975)] })
}

/// The least of ascending values to which half of the weight comes; `None` without weight.
fn weighted_median(sorted: &[(f64, usize)], weight_of_group: &[u32]) -> Option<f64> {
    let total: u64 = sorted.iter().map(|it| u64::from(weight_of_group[it.1])).sum();
    let mut sum = 0;
    let middle = sorted.iter().find(|it| {
        sum += 2 * u64::from(weight_of_group[it.1]);
        sum >= total
    });
    middle.filter(|_| total > 0).map(|it| it.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(values: &[(f64, usize)], n_groups: usize) -> MedianWithin {
        median_within(values, n_groups, 1).unwrap()
    }

    #[test]
    fn nothing_has_no_median_and_one_value_is_it() {
        assert_eq!(median_within(&[], 0, 1), None);
        assert_eq!(interval(&[(3.0, 0)], 1), MedianWithin { median: 3.0, within: [3.0, 3.0] });
    }

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(interval(&[(5.0, 2), (1.0, 0), (2.0, 1)], 3).median, 2.0);
        assert_eq!(interval(&[(4.0, 3), (1.0, 0), (2.0, 1), (3.0, 2)], 4).median, 2.0);
    }

    #[test]
    fn the_interval_is_that_of_order_statistics() {
        // Of 101 values the 95 % interval of the median reaches from about the 41st to the 61st.
        let values: Vec<(f64, usize)> = (0..101).map(|it| (f64::from(it as u8), it)).collect();
        let it = interval(&values, 101);
        assert_eq!(it.median, 50.0);
        assert!((39.0..=42.0).contains(&it.within[0]) && (58.0..=61.0).contains(&it.within[1]), "{it:?}");
    }

    #[test]
    fn values_of_one_group_are_no_more_than_one() {
        let apart: Vec<(f64, usize)> = (0..100).map(|it| (f64::from(it as u8), it)).collect();
        let together: Vec<(f64, usize)> = apart.iter().map(|&(value, it)| (value, it / 20)).collect();
        let width = |it: MedianWithin| it.within[1] - it.within[0];
        assert!(width(interval(&together, 5)) > 1.5 * width(interval(&apart, 100)));
        assert_eq!(interval(&together, 5), interval(&together, 5));
    }
}
