//! The two-level grid that everything else reads.

pub mod cell_set;
pub mod hierarchical_grid;
pub mod dense_level;
