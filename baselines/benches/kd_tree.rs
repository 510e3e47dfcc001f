//! Time of [`kd_tree_components`] on the foreground of two real scans, tree included, on one thread.
//!
//! The scans may not be copied into this project; where they are missing, their names are printed and nothing is
//! measured.

use std::io::Write as _;
use std::time::{Duration, Instant};

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};

const SCANS: [&str; 2] = ["obj_000001", "sk00_000000"];
const TOLERANCE_M: f32 = 0.5;
const N_RUNS: usize = 21;

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    for scan in SCANS {
        let path = format!("{}/../../shared/oracle/{scan}_fg.bin", env!("CARGO_MANIFEST_DIR"));
        match std::fs::read(&path) {
            Ok(bytes) => {
                let positions_m = positions_of(&bytes);
                let (n_components, median) = measure(&positions_m);
                let median_ms = median.as_secs_f64() * 1e3;
                writeln!(
                    out,
                    "{scan}: {} points, {n_components} components at {TOLERANCE_M} m, p50 of {N_RUNS} runs {median_ms:.1} ms",
                    positions_m.len(),
                )?;
            }
            Err(error) => writeln!(out, "{scan}: skipped, {path}: {error}")?,
        }
    }
    Ok(())
}

/// Little-endian f32 x, y, z, intensity per point.
fn positions_of(bytes: &[u8]) -> Vec<[f32; 3]> {
    let (points, _) = bytes.as_chunks::<16>();
    let coordinate = |point: &[u8; 16], at: usize| {
        f32::from_le_bytes([point[at], point[at + 1], point[at + 2], point[at + 3]])
    };
    points.iter().map(|point| [0, 4, 8].map(|at| coordinate(point, at))).collect()
}

fn measure(positions_m: &[[f32; 3]]) -> (usize, Duration) {
    let mut scratch = KdTreeScratch::default();
    let mut labels = Vec::new();
    let mut durations = Vec::with_capacity(N_RUNS);
    for _ in 0..N_RUNS {
        let started = Instant::now();
        kd_tree_components(positions_m, TOLERANCE_M, &mut scratch, &mut labels);
        durations.push(started.elapsed());
    }
    durations.sort();
    let n_components = (0..).zip(&labels).filter(|&(point_idx, &label)| label == point_idx).count();
    (n_components, durations[N_RUNS / 2])
}
