//! Boxes as annotators draw them: along the sides that are seen, and around whole vehicles.

pub mod seen_frame;
pub mod box_values;
pub mod box_model;
pub mod whole_box;
pub mod reported_boxes;
