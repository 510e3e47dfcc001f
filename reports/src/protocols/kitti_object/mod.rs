//! KITTI's object benchmark: right and false detections, and average precision.

pub mod rules;
pub mod scan;
#[cfg(test)]
mod drawn_scan;
pub mod roles;
pub mod class_scan;
pub mod components;
pub mod score_events;
pub mod official_matching;
pub mod sound_matching;
pub mod recall_curve;
pub mod official_curve;
pub mod averages;
pub mod sound_curve;
pub mod measures;
pub mod numbers;
