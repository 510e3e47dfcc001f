//! Interval of a share.

use crate::numbers::gap_curve::PairCounts;

/// The 95 % interval of the share `n_hits` of `n`, by Wilson's score; `None` if `n` is 0.
///
/// It stays within 0 to 1, and has a width even if all or none are hits.
///
/// ```
/// use reports::uncertainty::wilson_interval::wilson_interval;
///
/// let [low, high] = wilson_interval(0, 20).expect("twenty is more than none");
/// assert!(low == 0.0 && (high - 0.161).abs() < 0.001);
/// ```
pub fn wilson_interval(n_hits: u64, n: u64) -> Option<[f64; 2]> {
    const Z: f64 = 1.959_963_984_540_054;
    if n == 0 {
        return None;
    }
    let (n, share) = (n as f64, n_hits as f64 / n as f64);
    let middle = share + Z * Z / (2.0 * n);
    let reach = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    Some([((middle - reach) / scale).max(0.0), ((middle + reach) / scale).min(1.0)])
}

impl PairCounts {
    /// The 95 % interval of the share that was separated; `None` if no pair was seen.
    pub fn separated_within(&self) -> Option<[f64; 2]> {
        wilson_interval(self.n_separated, self.n_seen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(n_hits: u64, n: u64, expected: [f64; 2]) {
        let found = wilson_interval(n_hits, n).unwrap();
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 5e-4), "{found:?}");
    }

    #[test]
    fn intervals_are_those_of_textbooks() {
        // Newcombe 1998, table I, method 3.
        check(81, 263, [0.2553, 0.3662]);
        check(15, 148, [0.0624, 0.1605]);
        check(0, 20, [0.0, 0.1611]);
        check(29, 29, [0.8830, 1.0]);
        assert_eq!(wilson_interval(0, 0), None);
    }
}
