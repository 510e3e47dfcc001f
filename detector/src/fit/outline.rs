//! The dense cells along the edge of each object.

use crate::grid::dense_level::{DenseLevel, NO_BLOCK};
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_separation::NO_OBJECT;

/// Writes for every dense cell whether it is on the outline of its object: it holds points, and not all of its eight
/// neighbours belong to the same object. The corners of an object's convex hull lie in such cells.
///
/// `object_of_dense` has one entry for every dense cell of `dense`.
///
/// Paper: VM section 4, boundary cells.
pub fn mark_outline(
    grid: &HierarchicalGrid,
    dense: &DenseLevel,
    object_of_dense: &[u32],
    is_outline: &mut Vec<bool>,
) {
    is_outline.clear();
    is_outline.resize(object_of_dense.len(), false);
    let xi = grid.params().xi as i32;
    let n_dense = dense.n_dense_per_block();
    for (block_idx, &cell_idx) in dense.cell_of_block().iter().enumerate() {
        let blocks = grid.neighborhood(cell_idx).map(|neighbor_idx| dense.block_of_cell(neighbor_idx));
        let object_at = |column: i32, row: i32| {
            let across = (column + xi) / xi;
            let along = (row + xi) / xi;
            let block_idx = blocks[(along * 3 + across) as usize];
            let within = row.rem_euclid(xi) * xi + column.rem_euclid(xi);
            if block_idx == NO_BLOCK {
                NO_OBJECT
            } else {
                object_of_dense[block_idx as usize * n_dense + within as usize]
            }
        };
        for within in 0..xi * xi {
            let (column, row) = (within % xi, within / xi);
            let object = object_at(column, row);
            if object != NO_OBJECT {
                let neighbors = (-1..=1).flat_map(|along| (-1..=1).map(move |across| (across, along)));
                let is_edge = neighbors.map(|(x, y)| object_at(column + x, row + y)).any(|it| it != object);
                is_outline[block_idx * n_dense + within as usize] = is_edge;
            }
        }
    }
}
