//! From outcomes and times to numbers.

pub mod counts;
pub mod box_errors;
pub mod segmentation_quality;
pub mod pair_separation;
pub mod agreement;
