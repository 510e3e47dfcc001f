//! Numbers made of outcomes and times.

pub mod counts;
pub mod box_errors;
pub mod segmentation_quality;
pub mod pair_separation;
pub mod agreement;
