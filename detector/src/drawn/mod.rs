//! What stages leave behind, as shapes that can be drawn.

pub mod merge_graph;
pub mod object_cells;
