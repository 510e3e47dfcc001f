//! The two-level grid that everything else reads.

pub mod cell_set;
pub mod hierarchical_grid;
pub mod dense_level;
pub mod cell_fitness;

// How the density of points falls with the range: measured, fitted, and undone.
pub mod ring_density;
pub mod nonnegative_least_squares;
pub mod density_curve;
pub mod density_weighting;
