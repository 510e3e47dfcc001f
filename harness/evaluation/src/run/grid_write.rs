//! Reference for the times of detectors: writes points into one coarse grid in the plainest way, the least work of any grid
//! method. It is none of the rivals, and no parameter changes it, so that ratios of times change only with the detectors.

use std::hint::black_box;
use std::time::{Duration, Instant};

use detector::PointCloud;

/// Side of a cell, as in the paper.
const CELL_SIZE_M: f32 = 0.6;
/// Points farther from the sensor than this, along either axis, are not written, in metres.
const EXTENT_M: f32 = 80.0;
const N_COLUMNS: usize = (2.0 * EXTENT_M / CELL_SIZE_M) as usize + 1;
/// Number of writes, of which the shortest counts: before the first one the points may not be in the cache.
const N_WRITES: usize = 5;

/// Number of the points above a cell, and lowest, highest and sum of their heights.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PlainCell {
    n_points: u32,
    z_min_m: f32,
    z_max_m: f32,
    z_sum_m: f32,
}

const EMPTY: PlainCell =
    PlainCell { n_points: 0, z_min_m: f32::INFINITY, z_max_m: f32::NEG_INFINITY, z_sum_m: 0.0 };

/// A grid to write into.
#[derive(Debug)]
pub struct GridWrite {
    cells: Vec<PlainCell>,
}

impl Default for GridWrite {
    fn default() -> Self {
        Self { cells: vec![EMPTY; N_COLUMNS * N_COLUMNS] }
    }
}

impl GridWrite {
    /// The time of writing `cloud`: the shortest of several writes one after the other.
    pub fn time(&mut self, cloud: &PointCloud) -> Duration {
        let times = (0..N_WRITES).map(|_| self.time_once(cloud));
        times.min().unwrap_or_default()
    }

    /// The time of writing `cloud` once. Emptying the grid before does not count.
    pub fn time_once(&mut self, cloud: &PointCloud) -> Duration {
        self.cells.fill(EMPTY);
        let started = Instant::now();
        self.write(cloud);
        let time = started.elapsed();
        black_box(&self.cells);
        time
    }

    fn write(&mut self, cloud: &PointCloud) {
        let cells_per_m = 1.0 / CELL_SIZE_M;
        for ((&x_m, &y_m), &z_m) in cloud.x_m().iter().zip(cloud.y_m()).zip(cloud.z_m()) {
            if x_m.abs() < EXTENT_M && y_m.abs() < EXTENT_M && z_m.is_finite() {
                let column = ((x_m + EXTENT_M) * cells_per_m) as i32 as usize;
                let row = ((y_m + EXTENT_M) * cells_per_m) as i32 as usize;
                let cell = &mut self.cells[row * N_COLUMNS + column];
                cell.n_points += 1;
                cell.z_min_m = cell.z_min_m.min(z_m);
                cell.z_max_m = cell.z_max_m.max(z_m);
                cell.z_sum_m += z_m;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_holds_the_points_of_the_last_cloud_alone() {
        let mut grid = GridWrite::default();
        let points =
            [[0.1, 0.1, 1.0], [0.2, 0.2, -1.0], [-79.9, 79.9, 2.0], [80.1, 0.0, 0.0], [0.0, 0.0, f32::NAN]];
        for _ in 0..2 {
            grid.time(&points.into_iter().collect());
        }
        let filled: Vec<&PlainCell> = grid.cells.iter().filter(|it| it.n_points > 0).collect();
        let low = PlainCell { n_points: 2, z_min_m: -1.0, z_max_m: 1.0, z_sum_m: 0.0 };
        let high = PlainCell { n_points: 1, z_min_m: 2.0, z_max_m: 2.0, z_sum_m: 2.0 };
        assert_eq!(filled, [&low, &high]);
        // The outermost cells are there.
        let corners = [[-79.999, -79.999, 0.0], [79.999, 79.999, 0.0]];
        assert!(grid.time_once(&corners.into_iter().collect()) < Duration::from_secs(1));
    }
}
