//! Detectors as lists of stages: what a stage is, the stages that several detectors have, and the lists.

pub mod frame;
pub mod stage_list;
pub mod foreground_stages;
pub mod object_stages;
pub mod grouping_stages;
pub mod blob_stages;
pub mod paper_detector;
pub mod tree_detector;
