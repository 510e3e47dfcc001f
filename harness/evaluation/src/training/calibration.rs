//! Whether what is expected comes about.

/// Examples of which much the same was expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationBin {
    /// What was expected of them, on average.
    pub expected: f64,
    /// What came about, on average.
    pub observed: f64,
    /// How many they are.
    pub n: usize,
}

/// The bins of `judged`, pairs of what was expected and what came about, each 0 to 1: ten of equal width, without those that
/// hold none.
pub fn calibration(judged: impl Iterator<Item = (f64, f64)>) -> Vec<CalibrationBin> {
    let mut sums = [(0.0, 0.0, 0); 10];
    for (expected, observed) in judged {
        let bin = &mut sums[((expected * 10.0) as usize).min(9)];
        *bin = (bin.0 + expected, bin.1 + observed, bin.2 + 1);
    }
    let bin = |(expected, observed, n): (f64, f64, usize)| CalibrationBin {
        expected: expected / n as f64,
        observed: observed / n as f64,
        n,
    };
    sums.into_iter().filter(|it| it.2 > 0).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bin_has_the_means_of_its_examples() {
        let bins = calibration([(0.12, 0.0), (0.18, 1.0), (1.0, 1.0)].into_iter());
        assert_eq!(bins.len(), 2);
        assert!((bins[0].expected - 0.15).abs() < 1e-12 && bins[0].observed == 0.5 && bins[0].n == 2);
        assert_eq!(bins[1], CalibrationBin { expected: 1.0, observed: 1.0, n: 1 });
    }
}
