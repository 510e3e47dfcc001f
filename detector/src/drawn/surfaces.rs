//! Classes of cells and points, to look at.

use crate::grid::hierarchical_grid::{HierarchicalGrid, NO_CELL};
use crate::stage_product::{ProductCell, Shape};
use crate::surface_class::SurfaceClass;

/// The occupied cells of `grid`, each with its class by `class_of`.
pub fn surface_cells(grid: &HierarchicalGrid, class_of: impl Fn(u32) -> SurfaceClass) -> Shape {
    let cells = grid.occupied().iter().map(|&cell_idx| {
        let cell = &grid.cells()[cell_idx as usize];
        ProductCell {
            center_m: grid.center_m(cell_idx),
            z_range_m: [cell.z_min_m, cell.z_max_m],
            class: class_of(cell_idx),
        }
    });
    Shape::Cells { cell_size_m: grid.params().cell_size_m, cells: cells.collect() }
}

/// For every point that `grid` was filled with, the class of its cell by `class_of`; points outside of the grid are unseen.
pub fn class_by_cell(grid: &HierarchicalGrid, class_of: impl Fn(u32) -> SurfaceClass) -> Vec<SurfaceClass> {
    let class = |&cell_idx: &u32| if cell_idx == NO_CELL { SurfaceClass::Unseen } else { class_of(cell_idx) };
    grid.cell_of_point().iter().map(class).collect()
}
