//! Times of scans, and their statistics.

/// Times in milliseconds, in ascending order.
#[derive(Debug, Clone, PartialEq)]
pub struct Latencies {
    // Invariant: ascending.
    sorted_ms: Vec<f64>,
}

impl Latencies {
    /// Times in milliseconds, in any order.
    pub fn new(mut times_ms: Vec<f64>) -> Self {
        times_ms.sort_unstable_by(f64::total_cmp);
        Self { sorted_ms: times_ms }
    }

    /// Number of times.
    pub fn n(&self) -> usize {
        self.sorted_ms.len()
    }

    /// The `percent`-th percentile in milliseconds by nearest rank: the shortest time that at least `percent` % of the times
    /// do not exceed. 0 gives the shortest. `None` without times.
    pub fn percentile_ms(&self, percent: u32) -> Option<f64> {
        let rank = (self.n() * percent as usize).div_ceil(100);
        self.sorted_ms.get(rank.saturating_sub(1)).copied()
    }

    /// Scans per second as in the papers: one over the mean. `None` without times.
    pub fn fps_mean(&self) -> Option<f64> {
        let total_ms: f64 = self.sorted_ms.iter().sum();
        (total_ms > 0.0).then(|| 1e3 * self.n() as f64 / total_ms)
    }

    /// Scans per second by the median: one over it. `None` without times.
    pub fn fps_p50(&self) -> Option<f64> {
        let p50_ms = self.percentile_ms(50)?;
        (p50_ms > 0.0).then(|| 1e3 / p50_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(percent: u32, times_ms: &[f64], expected_ms: Option<f64>) {
        assert_eq!(Latencies::new(times_ms.to_vec()).percentile_ms(percent), expected_ms, "p{percent}");
    }

    #[test]
    fn percentiles_are_times_that_occurred() {
        let five = [15.0, 20.0, 35.0, 40.0, 50.0];
        check(0, &five, Some(15.0));
        check(30, &five, Some(20.0));
        check(40, &five, Some(20.0));
        check(50, &[50.0, 35.0, 40.0, 20.0, 15.0], Some(35.0));
        check(100, &five, Some(50.0));
        check(99, &[7.0], Some(7.0));
        check(50, &[], None);
    }

    #[test]
    fn scans_per_second_are_one_over_the_mean() {
        let latencies = Latencies::new(vec![10.0, 30.0]);
        assert_eq!((latencies.fps_mean(), latencies.fps_p50()), (Some(50.0), Some(100.0)));
        let nothing = Latencies::new(Vec::new());
        assert_eq!((nothing.fps_mean(), nothing.fps_p50()), (None, None));
    }
}
