//! The two-level grid that everything else reads.

pub mod hierarchical_grid;
pub mod dense_level;
