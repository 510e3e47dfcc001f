//! What stages leave behind, as shapes to look at. Nothing here is on the way to a detection.

pub mod surfaces;
pub mod walls;
pub mod blobs;
pub mod point_clusters;
pub mod fitted_boxes;
pub mod groups;
pub mod vehicle_shapes;
