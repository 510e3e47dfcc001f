//! A scan in a file of its own, in whichever format its name ends in.

use std::path::Path;

use detector::PointCloud;

use super::npy::parse_npy;
use super::pcd::parse_pcd;
use super::ply::parse_ply;
use crate::dataset::DatasetError;
use crate::dataset::velodyne_bin::read_velodyne_bin;

/// The endings of names of scans.
pub const SCAN_EXTENSIONS: [&str; 4] = ["bin", "pcd", "ply", "npy"];

/// The ending of `path` if it is that of a scan.
pub fn scan_extension(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?;
    SCAN_EXTENSIONS.into_iter().find(|it| extension.eq_ignore_ascii_case(it))
}

/// Reads the scan at `path`.
///
/// # Errors
///
/// [`DatasetError`] if it cannot be read, is damaged or holds no points.
pub fn read_scan_file(path: &Path) -> Result<PointCloud, DatasetError> {
    let parse = match scan_extension(path) {
        Some("pcd") => parse_pcd,
        Some("ply") => parse_ply,
        Some("npy") => parse_npy,
        _ => return read_velodyne_bin(path),
    };
    let bytes =
        std::fs::read(path).map_err(|source| DatasetError::Io { path: path.to_path_buf(), source })?;
    let cloud =
        parse(&bytes).map_err(|problem| DatasetError::Damaged { path: path.to_path_buf(), problem })?;
    if cloud.is_empty() { Err(DatasetError::NoPoints { path: path.to_path_buf() }) } else { Ok(cloud) }
}
