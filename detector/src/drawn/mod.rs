//! Products of stages as shapes to look at. No detection depends on them.

pub mod surfaces;
pub mod walls;
pub mod blobs;
pub mod point_clusters;
pub mod fitted_boxes;
pub mod groups;
pub mod vehicle_shapes;
