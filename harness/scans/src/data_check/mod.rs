//! Facts about a data set, and possible errors in it, before anything is run on it.

pub mod scan_facts;
pub mod empty_boxes;
pub mod seen_ground;

// Labels against points.
pub mod seen_vehicles;
pub mod label_correction;
pub mod paired_fits;
pub mod box_fit;
pub mod other_scan;
pub mod label_suspicion;
pub mod label_look;

pub mod same_position;
pub mod frame_suspicion;
pub mod check_report;
