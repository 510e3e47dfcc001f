//! A coarse grid over the ground whose cells are divided once more.

use serde::Deserialize;

use crate::grid::cell_set::CellSet;
use crate::point_cloud::PointCloud;
use crate::vector_instructions::{HotLoop, vectorised};

/// Geometry of the grid.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridParams {
    /// Side of a coarse cell in metres, W in the paper.
    pub cell_size_m: f32,
    /// Dense cells along the side of a coarse cell, ξ in the paper; 1 to 8.
    pub xi: u32,
    /// Half the side of the gridded square in metres; the sensor is at its centre.
    pub extent_m: f32,
}

/// Statistics of the points above one coarse cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseCell {
    /// Number of points.
    pub n_points: u32,
    /// Lowest point in metres; infinite for an empty cell.
    pub z_min_m: f32,
    /// Highest point in metres; minus infinite for an empty cell.
    pub z_max_m: f32,
    /// Sum of the elevations in metres.
    pub z_sum_m: f32,
}

impl CoarseCell {
    const EMPTY: Self =
        Self { n_points: 0, z_min_m: f32::INFINITY, z_max_m: f32::NEG_INFINITY, z_sum_m: 0.0 };

    /// Adds a point at this elevation, which is finite.
    fn add(&mut self, z_m: f32) {
        self.n_points += 1;
        self.z_min_m = if z_m < self.z_min_m { z_m } else { self.z_min_m };
        self.z_max_m = if z_m > self.z_max_m { z_m } else { self.z_max_m };
        self.z_sum_m += z_m;
    }

    /// Mean elevation in metres; NaN for an empty cell.
    pub fn z_mean_m(&self) -> f32 {
        self.z_sum_m / self.n_points as f32
    }

    /// Highest minus lowest point in metres; minus infinite for an empty cell.
    pub fn z_extent_m(&self) -> f32 {
        self.z_max_m - self.z_min_m
    }
}

/// The grid of one scan. Cells are numbered row by row, a row along x.
///
/// A frame of empty cells surrounds the gridded square, so that every occupied cell has eight neighbours.
///
/// Paper: HG section 3.
#[derive(Debug, Clone)]
pub struct HierarchicalGrid {
    params: GridParams,
    // Cells along a side, with the frame.
    n_columns: u32,
    cells: Vec<CoarseCell>,
    occupied: CellSet,
    cell_of_point: Vec<u32>,
    dense_within_of_point: Vec<u8>,
}

/// The cell of points that are NaN, infinite or outside the gridded square.
pub const NO_CELL: u32 = u32::MAX;

impl HierarchicalGrid {
    /// An empty grid.
    pub fn new(params: GridParams) -> Self {
        // One more than fits, so that a point a rounding error short of the far side has a cell too; two for the frame.
        let n_columns = (2.0 * params.extent_m / params.cell_size_m) as u32 + 1 + 2;
        let n_cells = n_columns as usize * n_columns as usize;
        Self {
            params,
            n_columns,
            cells: vec![CoarseCell::EMPTY; n_cells],
            occupied: CellSet::new(n_cells),
            cell_of_point: Vec::new(),
            dense_within_of_point: Vec::new(),
        }
    }

    /// Replaces the content by the points of `cloud`. Points that are not finite, or outside the square, belong to
    /// [`NO_CELL`].
    pub fn fill(&mut self, cloud: &PointCloud) {
        for &cell_idx in self.occupied.ascending() {
            self.cells[cell_idx as usize] = CoarseCell::EMPTY;
        }
        self.occupied.clear();
        vectorised(CellsOfPoints { grid: self, cloud });
        // A sensor sweeps, so that points which follow each other lie in the same cell more often than not (seven in a row
        // on average in a scan of an HDL-64E): the cell is kept at hand while they do.
        let mut current_idx = NO_CELL;
        let mut cell = CoarseCell::EMPTY;
        for (&cell_idx, &z_m) in self.cell_of_point.iter().zip(cloud.z_m()) {
            if cell_idx != current_idx {
                if let Some(current) = self.cells.get_mut(current_idx as usize) {
                    *current = cell;
                    self.occupied.insert(current_idx);
                }
                current_idx = cell_idx;
                cell = self.cells.get(cell_idx as usize).copied().unwrap_or(CoarseCell::EMPTY);
            }
            cell.add(z_m);
        }
        if let Some(current) = self.cells.get_mut(current_idx as usize) {
            *current = cell;
            self.occupied.insert(current_idx);
        }
        self.occupied.sort();
    }

    /// Writes the cells of every point. A pass of its own without a branch, for several points at a time.
    #[inline(always)]
    fn find_cells(&mut self, cloud: &PointCloud) {
        let GridParams { cell_size_m, xi, extent_m } = self.params;
        let (cells_per_m, dense_per_m) = (1.0 / cell_size_m, xi as f32 / cell_size_m);
        let (n_columns, last_dense) = (self.n_columns, (xi - 1) as f32);
        self.cell_of_point.resize(cloud.len(), NO_CELL);
        self.dense_within_of_point.resize(cloud.len(), 0);
        let positions_m = cloud.x_m().iter().zip(cloud.y_m()).zip(cloud.z_m());
        let written = self.cell_of_point.iter_mut().zip(&mut self.dense_within_of_point);
        for (((&x_m, &y_m), &z_m), (cell_idx, dense_within)) in positions_m.zip(written) {
            // NaN fails every comparison.
            let inside = (x_m.abs() < extent_m) & (y_m.abs() < extent_m) & (z_m.abs() < f32::INFINITY);
            let [column, row] = [x_m, y_m].map(|it_m| whole_part((it_m + extent_m) * cells_per_m));
            let in_frame = number(row + 1.0).wrapping_mul(n_columns).wrapping_add(number(column + 1.0));
            // A mask rather than a branch; it leaves NO_CELL, all ones, of points that are not inside.
            *cell_idx = in_frame | u32::from(inside).wrapping_sub(1);
            let within = |it_m: f32, step: f32| {
                let corner_m = step * cell_size_m - extent_m;
                let into_cell = (it_m - corner_m) * dense_per_m;
                // Rounding may put a point on the border a hair outside.
                let into_cell = if into_cell > 0.0 { into_cell } else { 0.0 };
                whole_part(if into_cell < last_dense { into_cell } else { last_dense })
            };
            *dense_within = number(within(y_m, row) * (last_dense + 1.0) + within(x_m, column)) as u8;
        }
    }

    /// The geometry.
    pub fn params(&self) -> &GridParams {
        &self.params
    }

    /// Cells along a side, the empty frame included: adding it to a cell's number steps one row.
    pub fn n_columns(&self) -> u32 {
        self.n_columns
    }

    /// All cells, occupied or not.
    pub fn cells(&self) -> &[CoarseCell] {
        &self.cells
    }

    /// Numbers of the cells that hold a point, ascending.
    pub fn occupied(&self) -> &[u32] {
        self.occupied.ascending()
    }

    /// The dense cell of each point within its coarse cell, `0..ξ²`, row by row, in scan order; meaningless for points
    /// outside.
    pub fn dense_within_of_point(&self) -> &[u8] {
        &self.dense_within_of_point
    }

    /// The cell of each point, in scan order; [`NO_CELL`] for points outside.
    pub fn cell_of_point(&self) -> &[u32] {
        &self.cell_of_point
    }

    /// Numbers of the cell and its eight neighbours. `cell_idx` must be an occupied cell.
    pub fn neighborhood(&self, cell_idx: u32) -> [u32; 9] {
        let n = self.n_columns;
        let (below, above) = (cell_idx - n, cell_idx + n);
        [below - 1, below, below + 1, cell_idx - 1, cell_idx, cell_idx + 1, above - 1, above, above + 1]
    }

    /// Column and row of a cell.
    pub fn column_and_row(&self, cell_idx: u32) -> [u32; 2] {
        [cell_idx % self.n_columns, cell_idx / self.n_columns]
    }

    /// Steps along x and y from the first cell to the one at `position_m`, or to the nearest to it.
    pub fn nearest_column_and_row(&self, position_m: [f32; 2]) -> [u32; 2] {
        let GridParams { cell_size_m, extent_m, .. } = self.params;
        // Casts saturate; the outermost cells are a border that holds no points.
        position_m.map(|it| (((it + extent_m) / cell_size_m + 1.0) as u32).min(self.n_columns - 1))
    }

    /// Corner of the cell with the smallest x and y, in metres.
    pub fn corner_m(&self, cell_idx: u32) -> [f32; 2] {
        self.column_and_row(cell_idx)
            .map(|step| (step as f32 - 1.0) * self.params.cell_size_m - self.params.extent_m)
    }

    /// Centre of the cell in metres.
    pub fn center_m(&self, cell_idx: u32) -> [f32; 2] {
        self.corner_m(cell_idx).map(|corner_m| corner_m + 0.5 * self.params.cell_size_m)
    }
}

/// The task of finding the cells of all points of a scan.
struct CellsOfPoints<'a> {
    grid: &'a mut HierarchicalGrid,
    cloud: &'a PointCloud,
}

impl HotLoop for CellsOfPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.grid.find_cells(self.cloud);
    }
}

/// From here to its double neighbouring f32 are 1 apart.
const WHOLE_FROM: f32 = 8_388_608.0;

/// `value` without its fraction, if it is at least 0 and below 2²²; anything otherwise.
///
/// Equal to casts to and fro. Compilers turn this into vector instructions on every machine, but not casts, which saturate.
#[inline(always)]
fn whole_part(value: f32) -> f32 {
    let rounded = (value + WHOLE_FROM) - WHOLE_FROM;
    rounded - f32::from(rounded > value)
}

/// A whole `value` as a number, if it is at least 0 and below 2²³; anything otherwise.
#[inline(always)]
fn number(value: f32) -> u32 {
    (value + WHOLE_FROM).to_bits() & 0x007f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn filled(positions_m: &[[f32; 3]]) -> HierarchicalGrid {
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m: 0.6, xi: 3, extent_m: 30.0 });
        grid.fill(&positions_m.iter().copied().collect());
        grid
    }

    #[test]
    fn a_cell_knows_count_lowest_highest_and_mean() {
        let grid = filled(&[[1.3, 0.1, -1.0], [1.4, 0.2, 0.5], [1.5, 0.3, 2.0]]);
        assert_eq!(grid.occupied().len(), 1);
        let cell = grid.cells()[grid.occupied()[0] as usize];
        assert_eq!(cell, CoarseCell { n_points: 3, z_min_m: -1.0, z_max_m: 2.0, z_sum_m: 1.5 });
        assert!((cell.z_mean_m() - 0.5).abs() < 1e-6);
    }

    #[test]
    fn points_that_are_not_finite_or_outside_have_no_cell() {
        let grid = filled(&[
            [f32::NAN, 0.0, 0.0],
            [0.0, f32::INFINITY, 0.0],
            [0.0, 0.0, f32::NEG_INFINITY],
            [30.0, 0.0, 0.0],
            [0.0, -30.1, 0.0],
        ]);
        assert!(grid.cell_of_point().iter().all(|&cell_idx| cell_idx == NO_CELL));
        assert!(grid.occupied().is_empty());
    }

    #[test]
    fn filling_again_forgets_the_scan_before() {
        let mut grid = filled(&[[1.0, 1.0, 1.0], [-20.0, 3.0, 0.0]]);
        grid.fill(&[[5.0, 5.0, 0.0]].into_iter().collect());
        assert_eq!(grid.occupied().len(), 1);
        assert_eq!(grid.cells().iter().map(|cell| cell.n_points).sum::<u32>(), 1);
    }

    proptest! {
        #[test]
        fn the_whole_part_is_what_a_cast_gives(
            value in prop_oneof![0.0_f32..4_194_304.0, 0.0_f32..300.0], whole in 0_u16..1000,
        ) {
            let exact = f32::from(whole);
            for value in [value, exact, exact.next_up(), exact.next_down().max(0.0)] {
                prop_assert_eq!(whole_part(value), value.trunc());
                prop_assert_eq!(number(whole_part(value)), value as u32);
            }
        }

        #[test]
        fn every_point_lies_in_its_coarse_and_its_dense_cell(
            positions_m in prop::collection::vec([-29.9_f32..29.9, -29.9_f32..29.9, -3.0_f32..3.0], 0..200)
        ) {
            let grid = filled(&positions_m);
            let cells = grid.cell_of_point().iter().zip(grid.dense_within_of_point());
            for (position_m, (&cell_idx, &dense)) in positions_m.iter().zip(cells) {
                prop_assert!(dense < 9);
                let corner_m = grid.corner_m(cell_idx);
                for (axis, step) in [(0, dense % 3), (1, dense / 3)] {
                    let into_cell_m = position_m[axis] - corner_m[axis] - f32::from(step) * 0.2;
                    prop_assert!((-1e-4..=0.2001).contains(&into_cell_m), "{into_cell_m}");
                }
            }
            let n_in_cells: u32 = grid.cells().iter().map(|cell| cell.n_points).sum();
            prop_assert_eq!(n_in_cells as usize, positions_m.len());
        }
    }
}
