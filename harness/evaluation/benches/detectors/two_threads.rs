//! Scans per second with one detector, and with two on a thread each. One scan is never split: what is won is throughput,
//! not latency.

use std::time::{Duration, Instant};

use detector::{Detector, DetectorOutput, PointCloud};
use evaluation::run::config::RunConfig;

use crate::rows::default_detector;
use crate::{N_ROUNDS, N_WARMUP_ROUNDS};

/// Passes over the scans that are timed as one, so that starting threads does not count.
const N_PASSES: usize = 10;

/// A detector and where it writes.
type Station = (Box<dyn Detector>, DetectorOutput);

/// Measures and prints the best of all rounds.
pub fn measure(clouds: &[PointCloud], config: &RunConfig, sensor_height_m: f32) {
    let mut stations: [Station; 2] =
        std::array::from_fn(|_| (default_detector(config, sensor_height_m), DetectorOutput::default()));
    let mut best = [Duration::MAX; 2];
    for _ in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for (best, n_threads) in best.iter_mut().zip(1..) {
            *best = time_of_all(clouds, &mut stations[..n_threads]).min(*best);
        }
    }
    println!("\n{:<24} {:>10}", "threads", "scans/s");
    let per_second = best.map(|it| (N_PASSES * clouds.len()) as f64 / it.as_secs_f64());
    for (n_threads, per_second) in (1..).zip(per_second) {
        println!("{n_threads:<24} {per_second:>10.0}");
    }
    println!("{:<24} {:>10.2}", "ratio", per_second[1] / per_second[0]);
}

/// Time until the scans are done, each by one of `stations`, which work at the same time.
fn time_of_all(clouds: &[PointCloud], stations: &mut [Station]) -> Duration {
    let n_threads = stations.len();
    let started = Instant::now();
    std::thread::scope(|scope| {
        for (first, (detector, output)) in stations.iter_mut().enumerate() {
            scope.spawn(move || {
                for _ in 0..N_PASSES {
                    for cloud in clouds.iter().skip(first).step_by(n_threads) {
                        detector.detect(cloud, output);
                    }
                }
            });
        }
    });
    started.elapsed()
}
