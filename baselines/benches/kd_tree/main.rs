//! The kd-tree on one thread: against PCL on the foreground of two real scans, against the hierarchical grid on whole
//! scans as the paper measured, and on ever denser points, where its cost follows the pairs of neighbours.
//!
//! `cargo bench -p baselines --bench kd_tree`. The scans may not be copied into this project: `SCANBENCH_TEST_DATA` says
//! where they are. Those that are missing are named, and left out.

mod against_pcl;
mod raw_scans;
mod dense_points;

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Points nearer to each other than this are neighbours.
const TOLERANCE_M: f32 = 0.5;

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    against_pcl::measure(&mut out)?;
    raw_scans::measure(&mut out)?;
    dense_points::measure(&mut out)
}

/// Positions from little-endian f32 x, y, z, intensity per point; `None` and a line in `out` where there is no such file.
fn read_positions(path: &str, out: &mut impl std::io::Write) -> std::io::Result<Option<Vec<[f32; 3]>>> {
    let bytes = match std::fs::read(path_of(path)) {
        Ok(bytes) => bytes,
        Err(error) => {
            writeln!(out, "skipped: {path} in the folder that SCANBENCH_TEST_DATA names: {error}")?;
            return Ok(None);
        }
    };
    let coordinate = |point: &[u8; 16], at: usize| {
        f32::from_le_bytes([point[at], point[at + 1], point[at + 2], point[at + 3]])
    };
    let points = bytes.as_chunks::<16>().0.iter();
    Ok(Some(points.map(|point| [0, 4, 8].map(|at| coordinate(point, at))).collect()))
}

/// Where real data of this path are, if they are anywhere.
fn path_of(path: &str) -> PathBuf {
    PathBuf::from(std::env::var_os("SCANBENCH_TEST_DATA").unwrap_or_default()).join(path)
}

/// The median time of `work`.
fn median(n_runs: usize, mut work: impl FnMut()) -> Duration {
    let mut durations: Vec<Duration> = (0..n_runs)
        .map(|_| {
            let started = Instant::now();
            work();
            started.elapsed()
        })
        .collect();
    durations.sort_unstable();
    durations[n_runs / 2]
}

fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}
