//! The dense cells of every object, to look at.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::DenseLevel;
use crate::segment::object_points::ObjectPoints;
use crate::stage_product::{ObjectCell, Shape};

/// The occupied dense cells of `dense`, each with the object of `objects` that has its points.
///
/// Paper: HG section 3.2, Fig. 4.
pub fn object_cells(grid: &HierarchicalGrid, dense: &DenseLevel, objects: &ObjectPoints) -> Shape {
    let xi = grid.params().xi;
    let cell_size_m = grid.params().cell_size_m / xi as f32;
    let n_per_block = dense.n_dense_per_block() as u32;
    let mut cells: Vec<Option<ObjectCell>> = vec![None; dense.n_points().len()];
    for object in 0..objects.n_objects() {
        for point in objects.points(object) {
            let [_, _, z_m] = point.position_m;
            let (block_idx, within) = (point.dense_idx / n_per_block, point.dense_idx % n_per_block);
            let cell = cells[point.dense_idx as usize].get_or_insert_with(|| {
                let corner_m = grid.corner_m(dense.cell_of_block()[block_idx as usize]);
                let steps = [within % xi, within / xi];
                let center_m = [0, 1].map(|axis| corner_m[axis] + (steps[axis] as f32 + 0.5) * cell_size_m);
                ObjectCell { center_m, z_range_m: [z_m, z_m], object: object as u32 }
            });
            let [low_m, high_m] = cell.z_range_m;
            cell.z_range_m = [low_m.min(z_m), high_m.max(z_m)];
        }
    }
    Shape::ObjectCells { cell_size_m, cells: cells.into_iter().flatten().collect() }
}
