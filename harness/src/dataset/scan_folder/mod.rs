//! Folders of scans that are a file each, with boxes beside them or without.

pub mod pcd;
pub mod ply;
pub mod npy;
pub mod scan_file;
pub mod box_list;
pub mod folder;
