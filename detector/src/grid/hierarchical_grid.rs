//! A coarse grid over the ground whose cells are divided once more.

use serde::Deserialize;

use crate::point_cloud::PointCloud;

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

/// What is known of the points above one coarse cell.
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
    // Ascending.
    occupied: Vec<u32>,
    cell_of_point: Vec<u32>,
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
            occupied: Vec::new(),
            cell_of_point: Vec::new(),
        }
    }

    /// Replaces the content by the points of `cloud`. Points that are not finite, or outside the square, belong to [`NO_CELL`].
    pub fn fill(&mut self, cloud: &PointCloud) {
        for &cell_idx in &self.occupied {
            self.cells[cell_idx as usize] = CoarseCell::EMPTY;
        }
        self.occupied.clear();
        self.cell_of_point.clear();
        self.cell_of_point.reserve(cloud.len());
        let (extent_m, cells_per_m) = (self.params.extent_m, 1.0 / self.params.cell_size_m);
        for ((&x_m, &y_m), &z_m) in cloud.x_m().iter().zip(cloud.y_m()).zip(cloud.z_m()) {
            // NaN fails every comparison.
            let inside = x_m.abs() < extent_m && y_m.abs() < extent_m && z_m.is_finite();
            if !inside {
                self.cell_of_point.push(NO_CELL);
                continue;
            }
            let column = ((x_m + extent_m) * cells_per_m) as u32 + 1;
            let row = ((y_m + extent_m) * cells_per_m) as u32 + 1;
            let cell_idx = row * self.n_columns + column;
            self.cell_of_point.push(cell_idx);
            let cell = &mut self.cells[cell_idx as usize];
            if cell.n_points == 0 {
                self.occupied.push(cell_idx);
            }
            cell.n_points += 1;
            cell.z_min_m = cell.z_min_m.min(z_m);
            cell.z_max_m = cell.z_max_m.max(z_m);
            cell.z_sum_m += z_m;
        }
        self.occupied.sort_unstable();
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
        &self.occupied
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

    /// Corner of the cell with the smallest x and y, in metres.
    pub fn corner_m(&self, cell_idx: u32) -> [f32; 2] {
        self.column_and_row(cell_idx)
            .map(|step| (step as f32 - 1.0) * self.params.cell_size_m - self.params.extent_m)
    }

    /// Centre of the cell in metres.
    pub fn center_m(&self, cell_idx: u32) -> [f32; 2] {
        self.corner_m(cell_idx).map(|corner_m| corner_m + 0.5 * self.params.cell_size_m)
    }

    /// Number of the dense cell within its coarse cell, `0..ξ²`, row by row, for a point of coarse cell `cell_idx`.
    pub fn dense_cell_within(&self, cell_idx: u32, x_m: f32, y_m: f32) -> u32 {
        let [corner_x_m, corner_y_m] = self.corner_m(cell_idx);
        let xi = self.params.xi;
        let dense_per_m = xi as f32 / self.params.cell_size_m;
        // Rounding may put a point on the border a hair outside: the cast stops at 0, `min` at the far side.
        let column = (((x_m - corner_x_m) * dense_per_m) as u32).min(xi - 1);
        let row = (((y_m - corner_y_m) * dense_per_m) as u32).min(xi - 1);
        row * xi + column
    }
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
        fn every_point_lies_in_its_coarse_and_its_dense_cell(
            positions_m in prop::collection::vec([-29.9_f32..29.9, -29.9_f32..29.9, -3.0_f32..3.0], 0..200)
        ) {
            let grid = filled(&positions_m);
            for (position_m, &cell_idx) in positions_m.iter().zip(grid.cell_of_point()) {
                let dense = grid.dense_cell_within(cell_idx, position_m[0], position_m[1]);
                prop_assert!(dense < 9);
                let corner_m = grid.corner_m(cell_idx);
                for (axis, step) in [(0, dense % 3), (1, dense / 3)] {
                    let into_cell_m = position_m[axis] - corner_m[axis] - step as f32 * 0.2;
                    prop_assert!((-1e-4..=0.2001).contains(&into_cell_m), "{into_cell_m}");
                }
            }
            let n_in_cells: u32 = grid.cells().iter().map(|cell| cell.n_points).sum();
            prop_assert_eq!(n_in_cells as usize, positions_m.len());
        }
    }
}
