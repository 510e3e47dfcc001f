//! How both sides of a comparison are drawn: told apart by form and line as well as by colour.

use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::palette::{BLUE, Rgb, VERMILION};

/// A part of the picture, in pixels from its upper left corner.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing into memory returns; it fails only where a panel has no room at all.
pub(crate) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Width and height of a plot in pixels.
pub(crate) const SIZE_PX: (u32, u32) = (900, 620);
/// The left side: full lines, filled circles, filled bars.
pub(crate) const LEFT_COLOR: RGBColor = color(BLUE);
/// The right side: dashed lines, hollow triangles, hollow bars.
pub(crate) const RIGHT_COLOR: RGBColor = color(VERMILION);
/// What is not data: grid lines, frames.
pub(crate) const QUIET_COLOR: RGBColor = RGBColor(215, 215, 215);
/// Behind the ratios that pass for alike.
pub(crate) const BAND_COLOR: RGBColor = RGBColor(225, 225, 225);
/// Width of the lines of the data, in pixels.
pub(crate) const LINE_WIDTH_PX: u32 = 2;
/// Half the size of a marker, in pixels.
pub(crate) const MARKER_PX: i32 = 4;
/// Room left of the vertical axes, the same in all panels so that these are flush, in pixels.
pub(crate) const LEFT_ROOM_PX: u32 = 80;
/// Room right of the panels, in pixels.
pub(crate) const RIGHT_ROOM_PX: u32 = 20;
/// Height of the text on axes and beside data, in pixels.
pub(crate) const TEXT_PX: i32 = 15;

const fn color([red, green, blue]: Rgb) -> RGBColor {
    RGBColor(red, green, blue)
}

/// Text of `height_px`, placed by the middle of its upper side or by its left end at half height.
pub(crate) fn text(height_px: i32, horizontal: HPos) -> TextStyle<'static> {
    let vertical = if matches!(horizontal, HPos::Left) { VPos::Center } else { VPos::Top };
    let style: TextStyle<'static> = ("sans-serif", height_px).into_font().color(&BLACK);
    style.pos(Pos::new(horizontal, vertical))
}

/// The marker of the left side at a place of any coordinate system.
pub(crate) fn left_marker<C>(place: C) -> Circle<C, i32> {
    Circle::new(place, MARKER_PX, LEFT_COLOR.filled())
}

/// The marker of the right side.
pub(crate) fn right_marker<C>(place: C) -> TriangleMarker<C, i32> {
    TriangleMarker::new(place, MARKER_PX + 1, RIGHT_COLOR.stroke_width(LINE_WIDTH_PX))
}
