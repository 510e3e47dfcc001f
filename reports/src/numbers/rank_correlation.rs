//! Whether one number rises with another.

/// Spearman's rank correlation of pairs, where equal values share the mean of their ranks: 1 if one always rises with the
/// other, −1 if it always falls. `None` of fewer than three pairs, or if either is the same throughout.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let [left, right] = [ranks(pairs.iter().map(|it| it.0)), ranks(pairs.iter().map(|it| it.1))];
    let mean = f64::midpoint(pairs.len() as f64, 1.0);
    let products = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let spread = products(&left, &left) * products(&right, &right);
    (pairs.len() >= 3 && spread > 0.0).then(|| products(&left, &right) / spread.sqrt())
}

/// The rank of every value from 1, equal values sharing the mean of theirs.
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
    fn what_does_not_vary_correlates_with_nothing() {
        check(&[(1.0, 5.0), (2.0, 5.0), (3.0, 5.0)], None);
        check(&[(1.0, 2.0), (2.0, 3.0)], None);
        check(&[], None);
    }
}
