//! Ratios over a length, with the band in which two values pass for alike.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::line_panel::middle_m;
use super::style::{
    Area, BAND_COLOR, Drawn, LEFT_MARGIN_PX, LEFT_ROOM_PX, MARKER_PX, QUIET_COLOR, RIGHT_ROOM_PX, TEXT_PX,
    axis_text, text,
};
use crate::numbers::curve_pair::{ALIKE_FACTOR, CurvePair};

/// The scale goes at least this far from 1, in doublings.
const LEAST_REACH: f64 = 1.2;
/// What is farther from 1 than this, in doublings, is drawn at the edge.
const GREATEST_REACH: f64 = 3.2;

/// Draws left over right for every bin that has a ratio.
pub(crate) fn draw_ratios(area: &Area<'_>, curves: &CurvePair, ends_m: [f64; 2]) -> Drawn {
    let ratios: Vec<(f64, f64)> = (0..curves.bins.len())
        .filter_map(|bin_idx| Some((middle_m(&curves.bins[bin_idx])?, curves.ratio(bin_idx)?.log2())))
        .collect();
    let farthest = ratios.iter().map(|(_, doublings)| doublings.abs()).fold(0.0, f64::max);
    let reach = (farthest + 0.2).clamp(LEAST_REACH, GREATEST_REACH);
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(46)
        .build_cartesian_2d(ends_m[0]..ends_m[1], -reach..reach)?;
    let band = ALIKE_FACTOR.log2();
    chart.draw_series([Rectangle::new([(ends_m[0], -band), (ends_m[1], band)], BAND_COLOR.filled())])?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(16)
        .x_label_formatter(&|value| axis_text(*value))
        .y_labels(7)
        .y_label_formatter(&|doublings| ratio_text(*doublings))
        .x_desc(format!("{} (m)", curves.bins_of.unwrap_or_default()))
        .y_desc("ratio, left / right")
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    chart.draw_series(LineSeries::new([(ends_m[0], 0.0), (ends_m[1], 0.0)], BLACK.stroke_width(1)))?;
    let edge = reach - 0.1;
    chart.draw_series(ratios.iter().map(|&(middle_m, doublings)| {
        let is_on_scale = doublings.abs() <= edge;
        let style = if is_on_scale { BLACK.filled() } else { BLACK.stroke_width(1) };
        Circle::new((middle_m, doublings.clamp(-edge, edge)), MARKER_PX - 1, style)
    }))?;
    if farthest > edge {
        let place = EmptyElement::at((f64::midpoint(ends_m[0], ends_m[1]), reach));
        let key = Text::new("hollow: off the scale", (0, 4), text(TEXT_PX, HPos::Center));
        chart.draw_series([place + key])?;
    }
    Ok(())
}

/// The ratio of a number of doublings, where that number is whole.
fn ratio_text(doublings: f64) -> String {
    if doublings.fract() == 0.0 { doublings.exp2().to_string() } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_doublings_are_labelled_by_their_ratio() {
        assert_eq!([-2.0, -0.5, 0.0, 1.0, 1.5].map(ratio_text), ["0.25", "", "1", "2", ""]);
    }
}
