//! Which detection found which annotation.

pub mod outcome;
mod first_of_ties;
pub mod hungarian;
pub mod point_overlap;
pub mod rectangle_overlap;
pub mod box_overlap;
pub mod criterion;
pub mod class_rule;
pub mod criterion_preset;
pub mod class_criteria;
mod height_above_ground;
mod labeled_positions;
pub mod eligibility;
mod ignored_detections;
pub mod detection_order;
mod judged_slice;
pub mod pairing;
pub mod assign;
pub mod lost_points;
pub mod mistake;

#[cfg(test)]
pub(crate) mod drawn_labels;
