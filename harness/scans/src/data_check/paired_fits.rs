//! Fits of points to boxes before and after a change, paired for the same vehicles and clouds, and how sure their gain is.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF as _, StudentsT};

/// Worse fits are taken as this one.
const LEAST_FIT: f64 = 0.02;
/// Confidence that a gain is at least as large as its limit.
const CONFIDENCE: f64 = 0.95;
/// A number of cases is no chance if chance gives as many with this probability at most.
const CHANCE: f64 = 0.035;

/// Two numbers for each of some independent groups: before a change, and after it. All pairs of numbers of one object, or of
/// one pair of scans, are a group.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PairedFits {
    of_groups: Vec<[f64; 2]>,
}

impl PairedFits {
    /// Sums `pairs` by the name of their group.
    pub fn of<Key: Ord>(pairs: impl IntoIterator<Item = (Key, [f64; 2])>) -> Self {
        let mut sums: BTreeMap<Key, [f64; 2]> = BTreeMap::new();
        for (key, [before, after]) in pairs {
            let sum = sums.entry(key).or_default();
            *sum = [sum[0] + before, sum[1] + after];
        }
        Self { of_groups: sums.into_values().collect() }
    }

    /// Number of groups.
    pub fn n_groups(&self) -> usize {
        self.of_groups.len()
    }

    /// The ratio of the means after and before the change.
    pub fn gain(&self) -> f64 {
        let [before, after] = self.means();
        after / before.max(LEAST_FIT)
    }

    /// Whether the ratio is surely greater than `gain`: by Student's t of the groups' differences (Fieller's limit of a
    /// ratio).
    pub fn is_surely_over(&self, gain: f64) -> bool {
        let n = self.n_groups() as f64;
        if n < 2.0 {
            return false;
        }
        let over: Vec<f64> =
            self.of_groups.iter().map(|[before, after]| after - gain * before.max(LEAST_FIT)).collect();
        let mean = over.iter().sum::<f64>() / n;
        let variance = over.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let student = StudentsT::new(0.0, 1.0, n - 1.0).expect("there is a degree of freedom");
        mean > student.inverse_cdf(CONFIDENCE) * (variance / n).sqrt()
    }

    /// Share of the groups whose number is larger after the change.
    pub fn share_larger(&self) -> f64 {
        let n_larger = self.of_groups.iter().filter(|[before, after]| after > before).count();
        n_larger as f64 / self.n_groups().max(1) as f64
    }

    fn means(&self) -> [f64; 2] {
        let n = self.n_groups().max(1) as f64;
        [0, 1].map(|side| self.of_groups.iter().map(|it| it[side]).sum::<f64>() / n)
    }
}

/// Whether `n_such` of `n` cases show that their share is surely more than `share`: the binomial test.
pub fn is_surely_more_than(share: f64, n_such: usize, n: usize) -> bool {
    // From the most likely number of cases on, terms become smaller: the rest is nothing.
    let log_term = |k: usize| {
        let choose = (1..=k).map(|it| ((n - k + it) as f64 / it as f64).ln()).sum::<f64>();
        choose + k as f64 * share.ln() + (n - k) as f64 * (1.0 - share).ln()
    };
    n_such > 0 && (n_such..=n).map(|k| log_term(k).exp()).sum::<f64>() <= CHANCE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits(pairs: &[[f64; 2]]) -> PairedFits {
        PairedFits::of(pairs.iter().copied().enumerate())
    }

    #[test]
    fn a_gain_in_all_groups_is_sure_and_one_by_few_is_not() {
        let alike = fits(&[[0.2, 0.4], [0.3, 0.62], [0.25, 0.48], [0.2, 0.41], [0.3, 0.61]]);
        assert!((alike.gain() - 2.016).abs() < 1e-9);
        assert!(alike.is_surely_over(1.5) && !alike.is_surely_over(2.0));
        assert!((alike.share_larger() - 1.0).abs() < 1e-9);
        let of_one = fits(&[[0.2, 2.4], [0.3, 0.29], [0.25, 0.26], [0.2, 0.19], [0.3, 0.31]]);
        assert!(of_one.gain() > 2.0 && !of_one.is_surely_over(1.0));
        // Two can agree by chance, however large the gain.
        assert!(!fits(&[[0.2, 0.4], [0.3, 0.6]]).is_surely_over(1.0));
        assert!(!fits(&[[0.1, 0.9]]).is_surely_over(1.0) && !PairedFits::default().is_surely_over(0.0));
    }

    #[test]
    fn what_a_group_has_several_of_counts_once() {
        let pairs = [("a", [0.1, 0.2]), ("b", [0.1, 0.1]), ("a", [0.1, 0.3])];
        let of_objects = PairedFits::of(pairs);
        assert_eq!((of_objects.n_groups(), of_objects.share_larger()), (2, 0.5));
        assert!((of_objects.gain() - 0.6 / 0.3).abs() < 1e-9);
    }

    #[test]
    fn five_of_five_are_no_chance_and_four_of_five_may_be() {
        assert!(is_surely_more_than(0.5, 5, 5) && !is_surely_more_than(0.5, 4, 5));
        assert!(is_surely_more_than(0.5, 8, 9) && !is_surely_more_than(0.5, 7, 9));
        assert!(!is_surely_more_than(0.5, 0, 0) && !is_surely_more_than(0.1, 0, 9));
        assert!(is_surely_more_than(0.5, 60, 100) && !is_surely_more_than(0.5, 58, 100));
        assert!(is_surely_more_than(0.5, 5100, 10_000));
    }
}
