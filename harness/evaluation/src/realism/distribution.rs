//! The spread of a number that every scan has one of.

use reports::numbers::curve_pair::{CurveBin, Measured, Sides};

/// Least, median and greatest of the values of either side, a bin each. A bin is made of as many things as there are
/// values.
pub fn distribution(values: Sides<Vec<f64>>) -> Vec<CurveBin> {
    let sorted = values.map(|mut values| {
        values.sort_by(f64::total_cmp);
        values
    });
    let bin = |name: &str, pick: fn(&[f64]) -> Option<f64>| CurveBin {
        name: name.to_owned(),
        ends_m: None,
        measured: sorted.as_ref().map(|values| Measured { value: pick(values), n: values.len() as u64 }),
    };
    vec![
        bin("least", |sorted| sorted.first().copied()),
        bin("median", median_of_sorted),
        bin("greatest", |sorted| sorted.last().copied()),
    ]
}

/// The value in the middle of ascending ones; of an even number the smaller of the two there, so that it occurred.
pub fn median_of_sorted(sorted: &[f64]) -> Option<f64> {
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_median_and_greatest_are_values_that_occurred() {
        let bins = distribution(Sides { left: vec![9.0, 1.0, 5.0, 2.0], right: vec![7.0] });
        let values: Vec<_> = bins.iter().map(|it| it.measured.map(|it| it.value.unwrap())).collect();
        let expected = [(1.0, 7.0), (2.0, 7.0), (9.0, 7.0)].map(|(left, right)| Sides { left, right });
        assert_eq!(values, expected);
        assert_eq!(bins[0].measured.map(|it| it.n), Sides { left: 4, right: 1 });
    }

    #[test]
    fn of_no_values_there_is_no_median() {
        let bins = distribution(Sides { left: Vec::new(), right: vec![1.0] });
        assert_eq!(bins[1].measured.left, Measured { value: None, n: 0 });
    }
}
