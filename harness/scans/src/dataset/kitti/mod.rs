//! The KITTI benchmarks: scans all round, boxes where the left colour camera sees.

pub mod calibration;
pub mod label;
pub mod box_in_velodyne;
pub mod image_box;
pub mod camera_field_of_view;
pub mod region_file;
pub mod ground_truth;
pub mod split_folder;
pub mod scan_list;
pub mod raw_mapping;
pub mod benchmarks;
