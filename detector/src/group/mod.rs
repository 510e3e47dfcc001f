//! Separate objects found among cells, by a tree of groupings.

pub mod candidates;
pub mod dense_cells;
pub mod linkage;
mod reached;
pub mod dense_gaps;
pub mod grouping_tree;
#[cfg(test)]
pub mod drawn_trees;
pub mod leaf_cuts;
pub mod node_shapes;
pub mod node_values;
pub mod node_context;
pub mod best_cut;
pub mod low_iou_groups;
pub mod node_points;
