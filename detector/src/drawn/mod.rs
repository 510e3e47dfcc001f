//! What stages leave behind, as shapes to look at. Nothing here is on the way to a detection.

pub mod surfaces;
pub mod walls;
pub mod merge_graph;
pub mod cut_borders;
pub mod object_cells;
pub mod point_clusters;
pub mod fitted_boxes;
pub mod groups;
pub mod vehicle_shapes;
