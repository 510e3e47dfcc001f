//! Coarse cells that belong together.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::{DenseLevel, NO_BLOCK};

/// Tuning of [`connected_components`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConnectedComponentsParams {
    /// Neighbours whose highest points differ by less belong together, in metres; ψ in the paper.
    pub max_height_difference_m: f32,
}

/// Writes to `links` the pairs of neighbouring blocks that belong to the same blob, each once, in ascending order.
///
/// Neighbours share a side or a corner. The pairs and not the blobs are the result, because the next stage decides
/// about each pair again.
///
/// Paper: HG section 3.2, merging indicator ψ.
pub fn connected_components(
    grid: &HierarchicalGrid,
    dense: &DenseLevel,
    params: &ConnectedComponentsParams,
    links: &mut Vec<[u32; 2]>,
) {
    links.clear();
    let n = grid.n_columns();
    for (&cell_idx, block_idx) in dense.cell_of_block().iter().zip(0..) {
        // The other four neighbours see this pair from their side.
        for neighbor_cell_idx in [cell_idx + 1, cell_idx + n - 1, cell_idx + n, cell_idx + n + 1] {
            let neighbor_idx = dense.block_of_cell(neighbor_cell_idx);
            if neighbor_idx == NO_BLOCK {
                continue;
            }
            let difference_m = (dense.z_max_m(block_idx) - dense.z_max_m(neighbor_idx)).abs();
            if difference_m < params.max_height_difference_m {
                links.push([block_idx, neighbor_idx]);
            }
        }
    }
}
