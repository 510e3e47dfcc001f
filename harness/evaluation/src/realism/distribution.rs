//! Spread over the scans of a number that each scan has.

use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};

/// Least, median and greatest of the `values` of the scans of either side, a bin each. The `n` of a bin is the number of
/// values.
pub fn spread_over_scans(
    statistic: &'static str,
    title: &'static str,
    unit: &'static str,
    values: Sides<Vec<f64>>,
) -> CurvePair {
    let sorted = values.map(|mut values| {
        values.sort_by(f64::total_cmp);
        values
    });
    let bin = |name: &str, pick: fn(&[f64]) -> Option<f64>| CurveBin {
        name: name.to_owned(),
        ends_m: None,
        measured: sorted.as_ref().map(|values| Measured { value: pick(values), n: values.len() as u64 }),
    };
    let bins = vec![
        bin("least", |sorted| sorted.first().copied()),
        bin("median", median_of_sorted),
        bin("greatest", |sorted| sorted.last().copied()),
    ];
    let (counted, least_n) = ("scans", Sides { left: 1, right: 1 });
    CurvePair { statistic, title, bins_of: None, focus_m: None, unit, counted, least_n, bins }
}

/// [`spread_over_scans`] of counts.
pub fn spread_of_counts(
    statistic: &'static str,
    title: &'static str,
    unit: &'static str,
    counts: &Sides<Vec<u64>>,
) -> CurvePair {
    let values = counts.as_ref().map(|scans| scans.iter().map(|&n| n as f64).collect());
    spread_over_scans(statistic, title, unit, values)
}

/// Median of ascending values; of an even number the smaller of the middle two, so that it is one of the values. `None`
/// without values.
pub fn median_of_sorted(sorted: &[f64]) -> Option<f64> {
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bins(left: Vec<f64>, right: Vec<f64>) -> Vec<CurveBin> {
        spread_over_scans("drawn", "values", "m", Sides { left, right }).bins
    }

    #[test]
    fn least_median_and_greatest_are_values_that_occurred() {
        let bins = bins(vec![9.0, 1.0, 5.0, 2.0], vec![7.0]);
        let values: Vec<_> = bins.iter().map(|it| it.measured.map(|it| it.value.unwrap())).collect();
        let expected = [(1.0, 7.0), (2.0, 7.0), (9.0, 7.0)].map(|(left, right)| Sides { left, right });
        assert_eq!(values, expected);
        assert_eq!(bins[0].measured.map(|it| it.n), Sides { left: 4, right: 1 });
    }

    #[test]
    fn of_no_values_there_is_no_median() {
        assert_eq!(bins(Vec::new(), vec![1.0])[1].measured.left, Measured { value: None, n: 0 });
    }

    #[test]
    fn ratios_are_left_over_right() {
        let curves = spread_of_counts("drawn", "things", "", &Sides { left: vec![4, 2, 6], right: vec![8] });
        assert_eq!([0, 1, 2].map(|it| curves.ratio(it)), [Some(0.25), Some(0.5), Some(0.75)]);
    }
}
