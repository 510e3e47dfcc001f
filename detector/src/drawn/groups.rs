//! Candidates and the smallest groups, to look at.

use crate::drawn::surfaces::class_by_cell;
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::{Candidates, Evidence};
use crate::group::dense_cells::DenseCells;
use crate::group::grouping_tree::GroupingTree;
use crate::stage_product::Shape;
use crate::surface_class::SurfaceClass;

/// The class of every point: candidates are short; the other points of a cell have the class of the cell, or are ground.
pub fn candidate_classes(
    grid: &HierarchicalGrid,
    classes: &[SurfaceClass],
    candidates: &Candidates,
) -> Vec<SurfaceClass> {
    let mut of_points = class_by_cell(grid, |cell_idx| match classes[cell_idx as usize] {
        SurfaceClass::Short if candidates.evidence_against(cell_idx).has(Evidence::Covered) => {
            SurfaceClass::Tall
        }
        SurfaceClass::Short => SurfaceClass::Ground,
        class => class,
    });
    for &point_idx in candidates.point_indices() {
        of_points[point_idx as usize] = SurfaceClass::Short;
    }
    of_points
}

/// The smallest group of every point of a scan of `n_points`.
pub fn smallest_groups(
    n_points: usize,
    candidates: &Candidates,
    dense: &DenseCells,
    tree: &GroupingTree,
) -> Shape {
    let mut leaf_of_dense = vec![None; dense.statistics().len()];
    for (node, node_idx) in tree.nodes().iter().zip(0..) {
        if node.first_child.is_none() {
            for &cell in tree.cells(node) {
                leaf_of_dense[cell as usize] = Some(node_idx);
            }
        }
    }
    let mut leaf_of_point = vec![None; n_points];
    for (&point_idx, &dense_idx) in candidates.point_indices().iter().zip(dense.dense_of_point()) {
        leaf_of_point[point_idx as usize] = leaf_of_dense[dense_idx as usize];
    }
    Shape::Clusters(leaf_of_point)
}
