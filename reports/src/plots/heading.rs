//! What a plot shows, and which mark is which side.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::style::{
    Area, Drawn, LEFT_COLOR, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, RIGHT_COLOR, TEXT_PX, left_marker,
    outline, right_marker, text,
};
use crate::numbers::curve_pair::Sides;

/// Height of the heading in pixels.
pub(crate) const HEADING_PX: u32 = 88;

/// How the sides are drawn below the heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum KeyForm {
    /// Lines with markers.
    Lines,
    /// Bars.
    Bars,
}

/// Draws the title and, on a line each, the key and the name of both sides.
pub(crate) fn draw_heading(area: &Area<'_>, title: &str, names: Sides<&str>, form: KeyForm) -> Drawn {
    let left_px = (LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32;
    area.draw_text(title, &text(20, HPos::Left), (left_px, 20))?;
    let style = text(TEXT_PX, HPos::Left);
    let ([left_y_px, right_y_px], end_px) = ([48, 70], left_px + 44);
    area.draw_text(&format!("left: {}", names.left), &style, (end_px + 12, left_y_px))?;
    area.draw_text(&format!("right: {}", names.right), &style, (end_px + 12, right_y_px))?;
    match form {
        KeyForm::Lines => {
            let middle_px = i32::midpoint(left_px, end_px);
            let left_line = LEFT_COLOR.stroke_width(LINE_WIDTH_PX);
            let ends = |y_px: i32| vec![(left_px, y_px), (end_px, y_px)];
            area.draw(&PathElement::new(ends(left_y_px), left_line))?;
            area.draw(&left_marker((middle_px, left_y_px)))?;
            let right_line = RIGHT_COLOR.stroke_width(LINE_WIDTH_PX);
            for dash_px in (left_px..end_px).step_by(10) {
                let dash = vec![(dash_px, right_y_px), (dash_px + 6, right_y_px)];
                area.draw(&PathElement::new(dash, right_line))?;
            }
            area.draw(&right_marker((middle_px, right_y_px)))
        }
        KeyForm::Bars => {
            let corners = |y_px: i32| [(left_px, y_px - 7), (end_px, y_px + 7)];
            area.draw(&Rectangle::new(corners(left_y_px), LEFT_COLOR.filled()))?;
            area.draw(&outline(corners(right_y_px), RIGHT_COLOR))
        }
    }
}
