//! Intervals of a median and of a mean.

use crate::numbers::box_errors::NumberWithin;
use crate::uncertainty::bootstrap::{Distribution, Resamples};

/// The lower median of `values`, with its 95 % interval over resamples of blocks. Each value comes with the index of its
/// block. `None` without values.
pub fn median_within(values: &[(f64, usize)], resamples: &Resamples) -> Option<NumberWithin> {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    within(|n_drawn| weighted_median(&sorted, n_drawn), resamples)
}

/// The mean of `values`, with its 95 % interval as in [`median_within`]. `None` without values.
pub fn mean_within(values: &[(f64, usize)], resamples: &Resamples) -> Option<NumberWithin> {
    let mut of_groups = vec![(0.0, 0_u32); resamples.blocks().n_blocks as usize];
    for &(value, group) in values {
        of_groups[group] = (of_groups[group].0 + value, of_groups[group].1 + 1);
    }
    let mean = |n_drawn: &[u16]| {
        let n: u64 = of_groups.iter().zip(n_drawn).map(|(it, &n)| u64::from(it.1) * u64::from(n)).sum();
        let sum: f64 = of_groups.iter().zip(n_drawn).map(|(it, &n)| it.0 * f64::from(n)).sum();
        (n > 0).then(|| sum / n as f64)
    };
    within(mean, resamples)
}

/// A number that depends on how often each block is drawn, with its interval.
fn within(number: impl Fn(&[u16]) -> Option<f64>, resamples: &Resamples) -> Option<NumberWithin> {
    let blocks = resamples.blocks();
    let value = number(&vec![1; blocks.n_blocks as usize])?;
    let within = Distribution::new(resamples.all_times_drawn().map(number), blocks).map(|it| it.interval());
    Some(NumberWithin { value, within })
}

/// The least of ascending values at which half of the weight is reached; `None` without weight.
fn weighted_median(sorted: &[(f64, usize)], weight_of_group: &[u16]) -> Option<f64> {
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
    use crate::numbers::blocks::{BlockCount, BlockKind};

    fn tracks(n_groups: u64) -> Resamples {
        Resamples::draw("street", BlockCount::of_dataset(n_groups, BlockKind::Tracks))
    }

    fn interval(values: &[(f64, usize)], n_groups: u64) -> NumberWithin {
        median_within(values, &tracks(n_groups)).unwrap()
    }

    fn ends(it: NumberWithin) -> [f64; 2] {
        it.within.unwrap().ends
    }

    #[test]
    fn nothing_has_no_median_and_one_value_is_it() {
        assert_eq!(median_within(&[], &tracks(0)), None);
        assert_eq!(interval(&[(3.0, 0)], 1), NumberWithin { value: 3.0, within: None });
    }

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(interval(&[(5.0, 2), (1.0, 0), (2.0, 1)], 3).value, 2.0);
        assert_eq!(interval(&[(4.0, 3), (1.0, 0), (2.0, 1), (3.0, 2)], 4).value, 2.0);
    }

    #[test]
    fn the_interval_is_that_of_order_statistics() {
        // Of 101 values the 95 % interval of the median reaches from about the 41st to the 61st.
        let values: Vec<(f64, usize)> = (0..101).map(|it| (f64::from(it as u8), it)).collect();
        let it = interval(&values, 101);
        assert_eq!(it.value, 50.0);
        let [low, high] = ends(it);
        assert!((39.0..=42.0).contains(&low) && (58.0..=61.0).contains(&high), "{it:?}");
    }

    #[test]
    fn of_zeros_and_ones_the_mean_is_the_share_with_the_interval_of_shares() {
        let values: Vec<(f64, usize)> = (0..400).map(|it| (f64::from(u8::from(it % 4 == 0)), it)).collect();
        let it = mean_within(&values, &tracks(400)).unwrap();
        assert_eq!(it.value, 0.25);
        // 1.96 times the square root of 0.25 * 0.75 / 400 is 0.042.
        let [low, high] = ends(it);
        assert!((low - 0.208).abs() < 0.006 && (high - 0.292).abs() < 0.006, "{it:?}");
        assert_eq!(mean_within(&[], &tracks(0)), None);
    }

    #[test]
    fn values_of_one_group_are_no_more_than_one() {
        let apart: Vec<(f64, usize)> = (0..100).map(|it| (f64::from(it as u8), it)).collect();
        let together: Vec<(f64, usize)> = apart.iter().map(|&(value, it)| (value, it / 20)).collect();
        let width = |it: NumberWithin| ends(it)[1] - ends(it)[0];
        assert!(width(interval(&together, 5)) > 1.5 * width(interval(&apart, 100)));
        assert_eq!(interval(&together, 5), interval(&together, 5));
        assert!(interval(&together, 5).within.unwrap().blocks.are_too_few());
    }
}
