//! What the detectors of the papers must beat, behind the same trait.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

/// The name of the stage that finds connected components of points, or of cells that stand; others are in
/// [`detector::stage`].
pub const COMPONENTS: &str = "components";

// Euclidean components over a kd-tree.
pub mod kd_tree_components;

// Principal axes of what stands in an occupancy grid.
pub mod occupancy_grid_components;
pub mod principal_axes_box;
pub mod symmetric_eigenvalues;
pub mod neighborhood_shapes;
pub mod pca_features;
pub mod pca_vehicle_model;

// Their parameters, and how their stages follow each other.
pub mod params;
pub mod simple_grid_detector;
pub mod kd_tree_detector;
pub mod pca_detector;
