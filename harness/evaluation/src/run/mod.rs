//! Detectors side by side over the scans of a data set, or one on a single scan.

pub mod kept_names;
pub mod foreign_detector;
pub mod config;
pub mod foreign_files;
pub mod detector_list;
pub mod counter;
pub mod scan_in_drive;
pub mod running_detector;
pub mod given_classes;
pub mod found_objects;
#[cfg(target_os = "linux")]
mod drive_memory;
#[cfg(target_os = "linux")]
pub mod process_detector;
pub mod results_detector;
pub mod compared_detector;
pub mod single_scan;
pub mod grid_write;
pub mod side_by_side;
pub mod rows;
pub mod sink;
pub mod scan_recorder;
pub mod gap_experiment;
pub mod gap_picture;
pub mod robustness;
pub mod box_study;
pub mod ablation;
