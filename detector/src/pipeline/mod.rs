//! The order of the stages. No other file knows it.

pub mod foreground_stages;
pub mod grouping_stages;
pub mod vehicle_stages;
pub mod object_stages;
pub mod paper_detector;
pub mod tree_detector;
