//! The grid that everything else reads, and how the density of its points falls with the range.

pub mod cell_set;
pub mod hierarchical_grid;

// Density over range: measured, fitted, and undone.
pub mod ring_density;
pub mod nonnegative_least_squares;
pub mod density_curve;
pub mod density_weighting;

// For a study of the cell size; no detector uses it.
pub mod cell_fitness;
