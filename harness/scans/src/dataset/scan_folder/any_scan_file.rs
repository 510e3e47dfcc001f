//! A scan in a file of its own, in the format of its ending.

use std::path::Path;

use super::las::parse_las;
use super::pcd::parse_pcd;
use super::ply::parse_ply;
use super::scan_file::ScanPoints;
use crate::dataset::DatasetError;
use crate::dataset::on_disk::bytes_of;
use crate::dataset::positioned_points::PositionedPoints;
use crate::dataset::scan_columns::ScanColumns;

/// The endings of names of scans.
pub const SCAN_EXTENSIONS: [&str; 6] = ["bin", "pcd", "ply", "npy", "las", "laz"];

/// The ending of `path`; `None` if it is not that of a scan.
pub fn scan_extension(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?;
    SCAN_EXTENSIONS.into_iter().find(|it| extension.eq_ignore_ascii_case(it))
}

/// Reads the scan at `path`, whose columns are `columns` if the file does not name them.
pub fn read_scan_file(path: &Path, columns: &ScanColumns) -> Result<ScanPoints, DatasetError> {
    let bytes = bytes_of(path)?;
    let points = match scan_extension(path) {
        Some("pcd") => parse_pcd(&bytes),
        Some("ply") => parse_ply(&bytes),
        Some("las" | "laz") => {
            let ScanPoints { points, origin_m } = parse_las(&bytes).map_err(damaged(path))?;
            return Ok(ScanPoints { points: points.none_or_some(path)?, origin_m });
        }
        _ => return Ok(at_origin(columns.parse(path, &bytes)?)),
    };
    Ok(at_origin(points.map_err(damaged(path))?.none_or_some(path)?))
}

/// [`ScanPoints::origin_m`] of the scan at `path`, for callers that need no points, though these are read for it.
pub fn scan_origin_m(path: &Path) -> Result<[f64; 3], DatasetError> {
    if !matches!(scan_extension(path), Some("las" | "laz")) {
        return Ok([0.0; 3]);
    }
    Ok(parse_las(&bytes_of(path)?).map_err(damaged(path))?.origin_m)
}

fn at_origin(points: PositionedPoints) -> ScanPoints {
    ScanPoints { points, origin_m: [0.0; 3] }
}

fn damaged(path: &Path) -> impl Fn(String) -> DatasetError + '_ {
    move |problem| DatasetError::damaged(path, problem)
}
