//! Folders of scans with a file for each, with boxes beside them or without.

pub mod scan_file;
pub mod pcd;
pub mod ply;
pub mod las;
pub mod any_scan_file;
pub mod listed_box;
pub mod label_cloud;
pub mod sustech_points;
pub mod label_file;
pub mod folder;
