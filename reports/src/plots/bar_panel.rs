//! Bars for the two values of kinds of something, with their ratio.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::style::{
    Area, Drawn, LEFT_COLOR, LEFT_MARGIN_PX, LEFT_ROOM_PX, QUIET_COLOR, RIGHT_COLOR, RIGHT_ROOM_PX, TEXT_PX,
    axis_text, outline, text,
};
use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::numbers::curve_pair::{CurvePair, Measured, Sides};

/// Where the bar of the left side begins and ends, as a share of the room of its bin.
const LEFT_BAR: [f64; 2] = [0.14, 0.48];
/// The same for the right side.
const RIGHT_BAR: [f64; 2] = [0.52, 0.86];

/// Draws two bars for every bin, from 0 up, each with its value, and the ratio beneath.
pub(crate) fn draw_bars(area: &Area<'_>, curves: &CurvePair) -> Drawn {
    let values = curves.bins.iter().flat_map(|bin| [bin.measured.left.value, bin.measured.right.value]);
    let greatest = values.flatten().fold(0.0, f64::max);
    let top = if greatest > 0.0 { 1.12 * greatest } else { 1.0 };
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(6)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(56)
        .build_cartesian_2d(0.0..curves.bins.len() as f64, 0.0..top)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .disable_x_axis()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .y_labels(8)
        .y_label_formatter(&|value| axis_text(*value))
        .y_desc(format!("{} ({})", curves.title, curves.unit))
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    let label = text(TEXT_PX, HPos::Center);
    let above = label.clone().pos(Pos::new(HPos::Center, VPos::Bottom));
    for (bin_idx, bin) in curves.bins.iter().enumerate() {
        let start = bin_idx as f64;
        let corners = |[from, to]: [f64; 2], measured: Measured| {
            [(start + from, 0.0), (start + to, measured.value.unwrap_or(0.0))]
        };
        let Sides { left, right } = bin.measured;
        chart.draw_series([Rectangle::new(corners(LEFT_BAR, left), LEFT_COLOR.filled())])?;
        chart.draw_series([outline(corners(RIGHT_BAR, right), RIGHT_COLOR)])?;
        for ([from, to], measured) in [(LEFT_BAR, left), (RIGHT_BAR, right)] {
            let place = EmptyElement::at((start + f64::midpoint(from, to), measured.value.unwrap_or(0.0)));
            chart.draw_series([place + Text::new(value_text(measured), (0, -4), above.clone())])?;
        }
        let ratio = curves.ratio(bin_idx);
        let ratio = ratio.map_or("no ratio".to_owned(), |it| format!("ratio {}", fixed_decimals(it, 2)));
        for (line, y_px) in [(bin.name.clone(), 8), (ratio, 30)] {
            let place = EmptyElement::at((start + 0.5, 0.0));
            chart.draw_series([place + Text::new(line, (0, y_px), label.clone())])?;
        }
    }
    Ok(())
}

fn value_text(measured: Measured) -> String {
    measured.value.map_or_else(|| "–".to_owned(), three_digits)
}
