//! What a file with a scan holds.

use std::path::Path;

use crate::dataset::positioned_points::PositionedPoints;

/// The endings of names of scans.
pub const SCAN_EXTENSIONS: [&str; 6] = ["bin", "pcd", "ply", "npy", "las", "laz"];

/// The points of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanPoints {
    /// In metres from `origin_m`.
    pub points: PositionedPoints,
    /// The point in the coordinates of the file that has become the origin: theirs, unless the points are far from it.
    pub origin_m: [f64; 3],
}

/// The ending of `path` if it is that of a scan.
pub fn scan_extension(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?;
    SCAN_EXTENSIONS.into_iter().find(|it| extension.eq_ignore_ascii_case(it))
}
