//! The cells of the grid (HG section 3).

use std::collections::BTreeMap;

use detector::PointCloud;
use detector::grid::hierarchical_grid::GridParams;

/// A coarse or a dense cell by its steps along x and y, ordered row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    pub row: i32,
    pub column: i32,
}

impl Cell {
    pub fn moved(self, columns: i32, rows: i32) -> Self {
        Self { row: self.row + rows, column: self.column + columns }
    }

    /// Steps to `other`, sideways or diagonal.
    pub fn steps_to(self, other: Self) -> u32 {
        self.row.abs_diff(other.row).max(self.column.abs_diff(other.column))
    }

    /// The cell and its eight neighbours, row by row.
    pub fn neighborhood(self) -> impl Iterator<Item = Self> {
        (-1..=1).flat_map(move |rows| (-1..=1).map(move |columns| self.moved(columns, rows)))
    }
}

/// The points above a coarse cell.
#[derive(Debug, Default)]
pub struct CellPoints {
    pub point_indices: Vec<u32>,
    /// In scan order.
    z_m: Vec<f32>,
}

impl CellPoints {
    pub fn z_min_m(&self) -> f32 {
        self.z_m.iter().copied().fold(f32::INFINITY, f32::min)
    }

    pub fn z_max_m(&self) -> f32 {
        self.z_m.iter().copied().fold(f32::NEG_INFINITY, f32::max)
    }

    pub fn z_extent_m(&self) -> f32 {
        self.z_max_m() - self.z_min_m()
    }

    pub fn z_mean_m(&self) -> f32 {
        self.z_m.iter().fold(0.0, |sum_m, z_m| sum_m + z_m) / self.z_m.len() as f32
    }
}

/// Occupied coarse cells. Points that are not finite or outside the square are in none.
pub fn coarse_cells(cloud: &PointCloud, params: &GridParams) -> BTreeMap<Cell, CellPoints> {
    let mut cells: BTreeMap<Cell, CellPoints> = BTreeMap::new();
    for (point_idx, [x_m, y_m, z_m]) in (0..).zip(cloud.positions_m()) {
        if x_m.abs() < params.extent_m && y_m.abs() < params.extent_m && z_m.is_finite() {
            let cell = cells.entry(coarse_cell([x_m, y_m], params)).or_default();
            cell.point_indices.push(point_idx);
            cell.z_m.push(z_m);
        }
    }
    cells
}

fn coarse_cell(position_m: [f32; 2], params: &GridParams) -> Cell {
    // Cells are numbered from 1: the frame of empty cells around them counts in the blocks of the terrain.
    let [column, row] =
        position_m.map(|it_m| ((it_m + params.extent_m) * (1.0 / params.cell_size_m)) as i32 + 1);
    Cell { row, column }
}

/// Centre of a coarse cell in metres.
pub fn center_m(cell: Cell, params: &GridParams) -> [f32; 2] {
    corner_m(cell, params).map(|corner_m| corner_m + 0.5 * params.cell_size_m)
}

fn corner_m(cell: Cell, params: &GridParams) -> [f32; 2] {
    [cell.column, cell.row].map(|step| (step as f32 - 1.0) * params.cell_size_m - params.extent_m)
}

/// The dense cell of a point of coarse cell `cell`, counted over the whole grid.
pub fn dense_cell(cell: Cell, position_m: [f32; 3], params: &GridParams) -> Cell {
    let xi = params.xi as i32;
    let corner_m = corner_m(cell, params);
    let [column, row] = [0, 1].map(|axis| {
        let steps = (position_m[axis] - corner_m[axis]) * (params.xi as f32 / params.cell_size_m);
        // Rounding may put a point on the border a hair outside.
        (steps as i32).clamp(0, xi - 1)
    });
    Cell { row: cell.row * xi + row, column: cell.column * xi + column }
}
