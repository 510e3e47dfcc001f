//! Sums over scans, each of which may occur several times.

use std::collections::BTreeMap;

use crate::rows::scan_name::ScanName;

/// Terms of `N` sums for every scan with rows.
#[derive(Debug, Clone)]
pub(super) struct ScanTerms<const N: usize> {
    // The index of the scan, ascending, and its terms.
    of_scans: Vec<(usize, [f64; N])>,
}

impl<const N: usize> ScanTerms<N> {
    /// Terms of the `rows` of `scans`, which ascend; `terms_of` makes the terms of the rows of one scan.
    pub(super) fn new<R>(
        scans: &[ScanName],
        rows: &BTreeMap<ScanName, R>,
        terms_of: impl Fn(&R) -> [f64; N],
    ) -> Self {
        let placed = rows.iter().filter_map(|(name, it)| Some((scans.binary_search(name).ok()?, it)));
        Self { of_scans: placed.map(|(index, it)| (index, terms_of(it))).collect() }
    }

    /// The sums where scan *i* is there `times[i]` times.
    pub(super) fn sums(&self, times: &[u16]) -> [f64; N] {
        let mut sums = [0.0; N];
        for (index, terms) in &self.of_scans {
            let times = f64::from(times[*index]);
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += times * term;
            }
        }
        sums
    }

    /// The sums of all scans once.
    pub(super) fn total(&self) -> [f64; N] {
        let n_indices = self.of_scans.last().map_or(0, |(index, _)| index + 1);
        self.sums(&vec![1; n_indices])
    }
}

/// `part` / `whole`; `None` if `whole` is 0.
pub(super) fn ratio(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| part / whole)
}

/// Number of values, their sum and the sum of their squares, as terms of a mean and a deviation; zeros without a value.
pub(super) fn moments(value: Option<f64>) -> [f64; 3] {
    value.map_or([0.0; 3], |it| [1.0, it, it * it])
}

/// Mean of values, and their standard deviation as that of a whole population.
pub(super) fn mean_and_deviation([n, sum, squares]: [f64; 3]) -> [Option<f64>; 2] {
    let mean = ratio(sum, n);
    let deviation = mean.map(|mean| (squares / n - mean * mean).max(0.0).sqrt());
    [mean, deviation]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(scan: u32) -> ScanName {
        ScanName { dataset: "d".to_owned(), sequence: "08".to_owned(), scan }
    }

    #[test]
    fn scans_count_as_often_as_they_are_there() {
        let rows = BTreeMap::from([(name(1), 5.0), (name(3), 7.0), (name(9), 11.0)]);
        let terms = ScanTerms::new(&[1, 2, 3].map(name), &rows, |it| [1.0, *it]);
        assert_eq!(terms.sums(&[2, 9, 1]), [3.0, 17.0]);
        assert_eq!(terms.total(), [2.0, 12.0]);
        assert_eq!(ScanTerms::new(&[], &rows, |it| [*it]).total(), [0.0]);
    }

    #[test]
    fn deviations_are_of_the_whole_population() {
        let sums = [2.0, 4.0].map(|it| moments(Some(it)));
        let sums = std::array::from_fn(|it| sums[0][it] + sums[1][it] + moments(None)[it]);
        assert_eq!(mean_and_deviation(sums), [Some(3.0), Some(1.0)]);
        assert_eq!(mean_and_deviation([0.0; 3]), [None, None]);
    }
}
