//! Which neighbouring coarse cells belong together, where separation cut them, and the cells of every object, to look at.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::{DenseLevel, NO_BLOCK};
use crate::segment::object_points::ObjectPoints;
use crate::stage_product::{LinkFate, ObjectCell, ProductLink, Shape};

/// All pairs of neighbouring blocks, from top to top: unlinked unless in `links`, cut if in `cut_links`, and otherwise kept.
///
/// `links` and `cut_links` are ascending, as merging and separation leave them.
///
/// Paper: HG section 3.2, merging indicator ψ and Fig. 4.
pub fn merge_graph(
    grid: &HierarchicalGrid,
    dense: &DenseLevel,
    links: &[[u32; 2]],
    cut_links: &[[u32; 2]],
) -> Shape {
    let n = grid.n_columns();
    let top_m = |block_idx: u32| {
        let [x_m, y_m] = grid.center_m(dense.cell_of_block()[block_idx as usize]);
        [x_m, y_m, dense.z_max_m(block_idx)]
    };
    let fate = |pair: &[u32; 2]| match (links.binary_search(pair), cut_links.binary_search(pair)) {
        (Err(_), _) => LinkFate::Unlinked,
        (Ok(_), Ok(_)) => LinkFate::Cut,
        (Ok(_), Err(_)) => LinkFate::Kept,
    };
    let mut graph = Vec::new();
    for (&cell_idx, block_idx) in dense.cell_of_block().iter().zip(0..) {
        for neighbor_cell_idx in [cell_idx + 1, cell_idx + n - 1, cell_idx + n, cell_idx + n + 1] {
            let neighbor_idx = dense.block_of_cell(neighbor_cell_idx);
            if neighbor_idx != NO_BLOCK {
                let pair = [block_idx, neighbor_idx];
                graph.push(ProductLink { ends_m: pair.map(top_m), fate: fate(&pair) });
            }
        }
    }
    Shape::Links(graph)
}

/// The borders between neighbouring blocks whose link is one of `cut_links`, each at the height of the lower one's top.
///
/// Paper: HG section 3.2, Fig. 4.
pub fn cut_borders(grid: &HierarchicalGrid, dense: &DenseLevel, cut_links: &[[u32; 2]]) -> Shape {
    Shape::Segments(cut_links.iter().map(|&blocks| border_m(grid, dense, blocks)).collect())
}

fn border_m(grid: &HierarchicalGrid, dense: &DenseLevel, blocks: [u32; 2]) -> [[f32; 3]; 2] {
    let [a, b] = blocks.map(|block_idx| grid.center_m(dense.cell_of_block()[block_idx as usize]));
    let [top_a_m, top_b_m] = blocks.map(|block_idx| dense.z_max_m(block_idx));
    let top_m = top_a_m.min(top_b_m);
    let middle_m = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    // A quarter turn from the line between the centres, half as long to either side.
    let half_m = [0.5 * (a[1] - b[1]), 0.5 * (b[0] - a[0])];
    [1.0, -1.0].map(|side| [middle_m[0] + side * half_m[0], middle_m[1] + side * half_m[1], top_m])
}

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
