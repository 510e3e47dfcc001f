//! How long scans took.

use std::time::Duration;

/// Durations of the scans of a run, in ascending order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Latencies {
    // Invariant: ascending.
    sorted: Vec<Duration>,
}

impl Latencies {
    /// Latencies in any order.
    pub fn new(mut durations: Vec<Duration>) -> Self {
        durations.sort_unstable();
        Self { sorted: durations }
    }

    /// Number of scans.
    pub fn n(&self) -> usize {
        self.sorted.len()
    }

    /// The `percent`-th percentile by nearest rank: the smallest duration that at least `percent` % of the scans do
    /// not exceed. 0 gives the least. `None` without scans.
    pub fn percentile(&self, percent: u32) -> Option<Duration> {
        let rank = (self.n() * percent as usize).div_ceil(100);
        self.sorted.get(rank.saturating_sub(1)).copied()
    }

    /// Scans per second, as the papers have it: one over the mean. `None` without scans.
    pub fn fps_mean(&self) -> Option<f64> {
        let total_s = self.sorted.iter().sum::<Duration>().as_secs_f64();
        (total_s > 0.0).then(|| self.n() as f64 / total_s)
    }

    /// One over the median time of a scan. `None` without scans.
    pub fn fps_p50(&self) -> Option<f64> {
        let p50_s = self.percentile(50)?.as_secs_f64();
        (p50_s > 0.0).then(|| 1.0 / p50_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(percent: u32, milliseconds: &[u64], expected: Option<u64>) {
        let latencies = Latencies::new(milliseconds.iter().map(|&it| Duration::from_millis(it)).collect());
        assert_eq!(latencies.percentile(percent), expected.map(Duration::from_millis), "p{percent}");
    }

    #[test]
    fn percentiles_are_durations_that_occurred() {
        let five = [15, 20, 35, 40, 50];
        check(0, &five, Some(15));
        check(30, &five, Some(20));
        check(40, &five, Some(20));
        check(50, &[50, 35, 40, 20, 15], Some(35));
        check(100, &five, Some(50));
        check(99, &[7], Some(7));
        check(50, &[], None);
    }

    #[test]
    fn scans_per_second_are_one_over_the_mean() {
        let latencies = Latencies::new(vec![Duration::from_millis(10), Duration::from_millis(30)]);
        assert_eq!(latencies.fps_mean(), Some(50.0));
        assert_eq!(latencies.fps_p50(), Some(100.0));
        assert_eq!(Latencies::new(Vec::new()).fps_mean(), None);
        assert_eq!(Latencies::new(Vec::new()).fps_p50(), None);
    }
}
