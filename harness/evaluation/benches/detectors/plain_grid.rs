//! The hierarchical detector as a multiple of writing one coarse grid: the least that any grid method has to do.

use std::hint::black_box;
use std::time::{Duration, Instant};

use detector::grid::hierarchical_grid::GridParams;
use detector::params::HierarchicalParams;
use detector::{Detector, DetectorOutput, PointCloud};
use evaluation::metrics::latency::Latencies;

use crate::rows::{hierarchical, ms, print_rows};
use crate::{N_ROUNDS, N_WARMUP_ROUNDS};

/// Count, lowest, highest and sum of the points above a cell.
#[derive(Clone, Copy)]
struct PlainCell {
    n_points: u32,
    z_min_m: f32,
    z_max_m: f32,
    z_sum_m: f32,
}

const EMPTY: PlainCell =
    PlainCell { n_points: 0, z_min_m: f32::INFINITY, z_max_m: f32::NEG_INFINITY, z_sum_m: 0.0 };

/// Writes the grid in the plainest way. `cells` are as many as fit.
fn write_grid(cloud: &PointCloud, params: &GridParams, n_columns: usize, cells: &mut [PlainCell]) {
    let extent_m = params.extent_m;
    let cells_per_m = 1.0 / params.cell_size_m;
    for ((&x_m, &y_m), &z_m) in cloud.x_m().iter().zip(cloud.y_m()).zip(cloud.z_m()) {
        if x_m.abs() < extent_m && y_m.abs() < extent_m && z_m.is_finite() {
            let column = ((x_m + extent_m) * cells_per_m) as i32 as usize;
            let row = ((y_m + extent_m) * cells_per_m) as i32 as usize;
            let cell = &mut cells[row * n_columns + column];
            cell.n_points += 1;
            cell.z_min_m = cell.z_min_m.min(z_m);
            cell.z_max_m = cell.z_max_m.max(z_m);
            cell.z_sum_m += z_m;
        }
    }
}

/// Measures and prints. Both find the points of a scan as cold as each other: last read half a round ago.
pub fn measure(clouds: &[PointCloud], sensor_height_m: f32) {
    let params = HierarchicalParams::paper().grid;
    let n_columns = (2.0 * params.extent_m / params.cell_size_m) as usize + 1;
    let mut cells = vec![EMPTY; n_columns * n_columns];
    let mut detector = hierarchical(sensor_height_m);
    let mut output = DetectorOutput::default();
    let (mut of_detector, mut of_grid) = (Vec::new(), Vec::new());
    for round in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for scan_idx in 0..clouds.len() {
            let detection = timed(|| detector.detect(&clouds[scan_idx], &mut output));
            // Emptied outside of the stopwatch: writing alone is the floor.
            cells.fill(EMPTY);
            let other = &clouds[(scan_idx + clouds.len() / 2) % clouds.len()];
            let writing = timed(|| write_grid(other, &params, n_columns, &mut cells));
            black_box(&cells);
            if round >= N_WARMUP_ROUNDS {
                of_detector.push(detection);
                of_grid.push(writing);
            }
        }
    }
    let [whole, floor] = [&of_detector, &of_grid].map(|it| Latencies::new(it.clone()));
    let rows = [("hierarchical, objects", of_detector), ("plain grid write", of_grid)];
    print_rows("against the floor", rows.into_iter());
    let [at_min, at_p50] = [0, 50].map(|percent| ms(&whole, percent) / ms(&floor, percent));
    println!("{:<24} {at_min:>10.2} {at_p50:>10.2}", "ratio");
}

fn timed(work: impl FnOnce()) -> Duration {
    let started = Instant::now();
    work();
    started.elapsed()
}
