//! What a data set is like, and what may be wrong with it, before anything is run on it.

pub mod scan_facts;
pub mod empty_boxes;
pub mod seen_ground;
pub mod frame_doubt;
pub mod check_report;
