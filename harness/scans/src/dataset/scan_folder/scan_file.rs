//! What a file with a scan holds.

use crate::dataset::positioned_points::PositionedPoints;

/// The points of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanPoints {
    /// In metres from `origin_m`.
    pub points: PositionedPoints,
    /// The point in the coordinates of the file that has become the origin: theirs, unless the points are far from it.
    pub origin_m: [f64; 3],
}
