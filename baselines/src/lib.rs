//! Baselines that the detectors of the papers must beat, behind the same trait.
//!
//! ```
//! use baselines::kd_tree_detector::kd_tree;
//! use baselines::params::BaselineParams;
//! use baselines::pca_detector::pca;
//! use detector::params::HierarchicalParams;
//! use detector::pipeline::object_stages::ObjectModels;
//! use detector::{Detector, DetectorOutput, PointCloud};
//!
//! // The sides of two cars, one ahead and one behind, and no road: a cell needs a point low and one high to stand out.
//! let steps = |from_m: f32, to_m: f32| (0..=40).map(move |it| from_m + it as f32 / 40.0 * (to_m - from_m));
//! let side = |from_m: f32| steps(from_m, from_m + 4.0).flat_map(|x| steps(-1.7, -0.3).map(move |z| [x, 3.0, z]));
//! let cloud: PointCloud = side(5.0).chain(side(-9.0)).collect();
//!
//! let (params, shared) = (BaselineParams::shipped(), HierarchicalParams::shipped());
//! let by_size = ObjectModels::default();
//! let mut output = DetectorOutput::default();
//! for mut rival in [pca(&params.pca, &shared, None, 1.73), kd_tree(&params.kd_tree, &shared, by_size, 1.73)] {
//!     rival.detect(&cloud, &mut output);
//!     assert_eq!(output.detections.len(), 2, "{}", rival.name());
//! }
//! ```
//!
//! Modules are declared in the order data reaches them; a module uses only modules that are declared above it.

/// The name of the stage that finds connected components of points or of occupied cells; other names are in
/// [`detector::stage`].
pub const COMPONENTS: &str = "components";

// Euclidean components over a kd-tree.
pub mod kd_tree_components;
pub mod nested_components;
pub mod kd_tree_linkage;
pub mod kd_tree_models;

// Principal axes of components of an occupancy grid.
pub mod occupancy_grid_components;
pub mod symmetric_eigenvalues;
pub mod neighborhood_shapes;
pub mod pca_features;
pub mod pca_vehicle_model;

// Their parameters, and how their stages follow each other.
pub mod params;
pub mod cluster_boxes;
pub mod simple_grid_detector;
pub mod kd_tree_detector;
pub mod kd_tree_groups;
pub mod pca_detector;
