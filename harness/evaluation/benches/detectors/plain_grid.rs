//! The default detector as a multiple of writing one coarse grid: the least that any grid method has to do.

use std::time::{Duration, Instant};

use detector::{DetectorOutput, PointCloud};
use evaluation::run::config::RunConfig;
use evaluation::run::grid_write::GridWrite;

use crate::rows::{default_detector, latencies, ms, print_rows};
use crate::{N_ROUNDS, N_WARMUP_ROUNDS};

/// Measures and prints. Both find the points of a scan as cold as each other: last read half a round ago.
pub fn measure(clouds: &[PointCloud], config: &RunConfig, sensor_height_m: f32) {
    let mut grid = GridWrite::default();
    let mut detector = default_detector(config, sensor_height_m);
    let mut output = DetectorOutput::default();
    let (mut of_detector, mut of_grid) = (Vec::new(), Vec::new());
    for round in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for scan_idx in 0..clouds.len() {
            let detection = timed(|| detector.detect(&clouds[scan_idx], &mut output));
            let other = &clouds[(scan_idx + clouds.len() / 2) % clouds.len()];
            let writing = grid.time_once(other);
            if round >= N_WARMUP_ROUNDS {
                of_detector.push(detection);
                of_grid.push(writing);
            }
        }
    }
    let [whole, floor] = [&of_detector, &of_grid].map(|it| latencies(it));
    let rows = [(detector.name(), of_detector), ("plain grid write", of_grid)];
    print_rows("against the floor", rows.into_iter());
    let [at_min, at_p50] = [0, 50].map(|percent| ms(&whole, percent) / ms(&floor, percent));
    println!("{:<24} {at_min:>10.2} {at_p50:>10.2}", "ratio");
}

fn timed(work: impl FnOnce()) -> Duration {
    let started = Instant::now();
    work();
    started.elapsed()
}
