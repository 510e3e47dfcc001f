//! Where the separation cut what merging had linked.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::DenseLevel;
use crate::stage_product::Shape;

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
