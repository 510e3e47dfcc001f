//! The content of a file with a scan.

use crate::dataset::positioned_points::PositionedPoints;

/// The points of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanPoints {
    /// The points, in metres from `origin_m`.
    pub points: PositionedPoints,
    /// The origin of the points in the coordinates of the file: zero, unless the points are far from it.
    pub origin_m: [f64; 3],
}
