//! Which neighbouring coarse cells belong together, as a graph to look at.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::{DenseLevel, NO_BLOCK};
use crate::stage_product::{LinkFate, ProductLink, Shape};

/// All pairs of neighbouring blocks, from top to top: of `links` some were cut, and the others are not among them.
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
