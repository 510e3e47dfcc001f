//! How both sides of a comparison are drawn: told apart by form and line as well as by colour.

use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::files::fixed_decimals::fixed_decimals;
use crate::plots::palette::{BLUE, Rgb, VERMILION};

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
pub(crate) const QUIET_COLOR: RGBColor = color(QUIET);
/// The colour of [`QUIET_COLOR`].
pub(crate) const QUIET: Rgb = [215, 215, 215];
/// What the library writes for black.
pub(crate) const BLACK_HEX: &str = "#000000";
/// What it writes for white, which it puts behind what stands alone.
pub(crate) const WHITE_HEX: &str = "#FFFFFF";
/// Behind the ratios that pass for alike.
pub(crate) const BAND_COLOR: RGBColor = RGBColor(225, 225, 225);
/// Width of the lines of the data, in pixels.
pub(crate) const LINE_WIDTH_PX: u32 = 2;
/// Half the size of a marker, in pixels.
pub(crate) const MARKER_PX: i32 = 4;
/// Room left of the vertical axes, the same in all panels so that these are flush, in pixels.
pub(crate) const LEFT_ROOM_PX: u32 = 80;
/// Room left of the description of the vertical axes, in pixels.
pub(crate) const LEFT_MARGIN_PX: u32 = 14;
/// Room right of the panels, in pixels.
pub(crate) const RIGHT_ROOM_PX: u32 = 20;
/// Height of the text on axes and beside data, in pixels.
pub(crate) const TEXT_PX: i32 = 15;

pub(crate) const fn color([red, green, blue]: Rgb) -> RGBColor {
    RGBColor(red, green, blue)
}

/// The colour as the library writes it.
pub(crate) fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// Text of `height_px`, placed by the middle of its upper side or by its left end at half height.
pub(crate) fn text(height_px: i32, horizontal: HPos) -> TextStyle<'static> {
    let vertical = if matches!(horizontal, HPos::Left) { VPos::Center } else { VPos::Top };
    let style: TextStyle<'static> = ("sans-serif", height_px).into_font().color(&BLACK);
    style.pos(Pos::new(horizontal, vertical))
}

/// A number on an axis: as short as it can be written.
pub(crate) fn axis_text(value: f64) -> String {
    let text = fixed_decimals(value, 5);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// An upright rectangle in pixels, drawn as an outline: rectangles of the library have hair lines only.
pub(crate) fn outline<C: Clone>([from, to]: [(C, C); 2], color: RGBColor) -> PathElement<(C, C)> {
    let corners = [
        (from.0.clone(), from.1.clone()),
        (to.0.clone(), from.1.clone()),
        (to.0.clone(), to.1.clone()),
        (from.0.clone(), to.1.clone()),
        (from.0, from.1),
    ];
    PathElement::new(corners, color.stroke_width(LINE_WIDTH_PX))
}

/// The marker of the left side at a place of any coordinate system.
pub(crate) fn left_marker<C>(place: C) -> Circle<C, i32> {
    Circle::new(place, MARKER_PX, LEFT_COLOR.filled())
}

/// The marker of the right side.
pub(crate) fn right_marker<C>(place: C) -> TriangleMarker<C, i32> {
    TriangleMarker::new(place, MARKER_PX + 1, RIGHT_COLOR.stroke_width(LINE_WIDTH_PX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_on_axes_are_short() {
        assert_eq!(
            [0.0, 5.0, -0.25, 0.1 + 0.2, 100.0, 120_000.0].map(axis_text),
            ["0", "5", "-0.25", "0.3", "100", "120000"]
        );
    }
}
