//! Tuning of the search for walls.

use serde::Deserialize;

use crate::segment::hough_lines::HoughParams;

/// Tuning of the search for walls.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallRefinementParams {
    /// Whether walls are looked for at all.
    pub enabled: bool,
    /// Whether walls are found as the paper prints it. `min_height_m`, `ceiling_margin_deg`, `min_standing` and
    /// `max_ground_behind` are not used then.
    pub as_printed: bool,
    /// Whether the cells beside a segment become tall, too, where walls are found as printed.
    pub beside: bool,
    /// Least height above the terrain of a cell that may support a wall, in metres: above the roofs of cars.
    pub min_height_m: f32,
    /// How far below the top of the field of view, in degrees, a cell still counts as cut off by it.
    pub ceiling_margin_deg: f32,
    /// Least share of a segment's length along which cells support a wall.
    pub min_support: f32,
    /// Least share of a segment's length along which cells support a wall and do not hang over the street. Hanging cells are
    /// known only where cells are looked into, for the tree of groupings.
    pub min_standing: f32,
    /// Greatest share of a segment's length behind which ground is seen: a wall hides it, rain and rows of trunks do not.
    pub max_ground_behind: f32,
    /// How the segments are found.
    pub hough: HoughParams,
}
