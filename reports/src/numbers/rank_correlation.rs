//! Rank correlation: whether one number rises with another.

/// Spearman's rank correlation of pairs, where equal values share the mean of their ranks: 1 if one number always rises with
/// the other, −1 if it always falls. `None` for fewer than three pairs, or if either number is constant.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    rank_correlation_within([pairs])
}

/// Spearman's rank correlation within groups: pairs are ranked in their group, so that differences between groups do not
/// count. `None` without a group of three pairs, or if either number is constant within every group.
pub fn rank_correlation_within<'a>(groups: impl IntoIterator<Item = &'a [(f64, f64)]>) -> Option<f64> {
    let [mut both, mut of_left, mut of_right] = [0.0; 3];
    for pairs in groups.into_iter().filter(|it| it.len() >= 3) {
        let [left, right] = [ranks(pairs.iter().map(|it| it.0)), ranks(pairs.iter().map(|it| it.1))];
        let mean = f64::midpoint(pairs.len() as f64, 1.0);
        for (left, right) in left.into_iter().zip(right).map(|(a, b)| (a - mean, b - mean)) {
            both += left * right;
            of_left += left * left;
            of_right += right * right;
        }
    }
    let spread: f64 = of_left * of_right;
    (spread > 0.0).then(|| both / spread.sqrt())
}

/// The rank of every value from 1; equal values share the mean of their ranks.
fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let values: Vec<f64> = values.collect();
    let rank = |value: &f64| {
        let n_below = values.iter().filter(|it| *it < value).count();
        let n_equal = values.iter().filter(|it| *it == value).count();
        n_below as f64 + f64::midpoint(n_equal as f64, 1.0)
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(pairs: &[(f64, f64)], expected: Option<f64>) {
        let found = rank_correlation(pairs);
        let is_near = found.zip(expected).map_or(found == expected, |(a, b)| (a - b).abs() < 1e-12);
        assert!(is_near, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn order_alone_counts() {
        check(&[(1.0, 0.1), (2.0, 0.11), (3.0, 900.0)], Some(1.0));
        check(&[(1.0, 3.0), (2.0, 2.0), (3.0, -1.0)], Some(-1.0));
        // Ranks 1 2 3 4 against 2 1 4 3: 1 - 6 · 4 / (4 · 15).
        check(&[(1.0, 2.0), (2.0, 1.0), (3.0, 4.0), (4.0, 3.0)], Some(0.6));
    }

    #[test]
    fn equal_values_share_their_rank() {
        // Ranks 1 2.5 2.5 4 against 1 2 3 4: 4.5 / √(4.5 · 5).
        check(&[(1.0, 1.0), (2.0, 2.0), (2.0, 3.0), (3.0, 4.0)], Some(4.5 / 22.5_f64.sqrt()));
    }

    #[test]
    fn what_sets_groups_apart_does_not_count() {
        // Each group falls, and the second lies far above the first.
        let groups: [&[(f64, f64)]; 3] = [
            &[(1.0, 3.0), (2.0, 2.0), (3.0, 1.0)],
            &[(11.0, 90.0), (12.0, 80.0), (13.0, 70.0)],
            &[(0.0, 0.0)],
        ];
        assert_eq!(rank_correlation_within(groups), Some(-1.0));
        check(&groups.concat(), Some(5.0 / 7.0));
        assert_eq!(rank_correlation_within([]), None);
    }

    #[test]
    fn what_does_not_vary_correlates_with_nothing() {
        check(&[(1.0, 5.0), (2.0, 5.0), (3.0, 5.0)], None);
        check(&[(1.0, 2.0), (2.0, 3.0)], None);
        check(&[], None);
    }
}
