//! Two curves over a length, on a logarithmic scale: the same ratio is the same distance everywhere.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::style::{
    Area, Drawn, LEFT_COLOR, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, QUIET_COLOR, RIGHT_COLOR,
    RIGHT_ROOM_PX, TEXT_PX, axis_text, left_marker, right_marker, text,
};
use crate::numbers::curve_pair::{CurveBin, CurvePair, Measured};

/// Room above the uppermost and below the lowest value, as a factor.
const HEADROOM: f64 = 1.4;

/// Draws both curves; values of 0, which have no place on the scale, are gaps.
pub(crate) fn draw_lines(area: &Area<'_>, curves: &CurvePair, ends_m: [f64; 2]) -> Drawn {
    let (low, high) = value_range(curves);
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(6)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(8)
        .build_cartesian_2d(ends_m[0]..ends_m[1], (low..high).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(16)
        .x_label_formatter(&|_| String::new())
        .y_label_formatter(&|value| axis_text(*value))
        .y_desc(format!("{} ({})", curves.title, curves.unit))
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    for stretch in stretches(curves, |bin| bin.measured.left) {
        let line = LineSeries::new(stretch.iter().copied(), LEFT_COLOR.stroke_width(LINE_WIDTH_PX));
        chart.draw_series(line)?;
        chart.draw_series(stretch.iter().map(|&place| left_marker(place)))?;
    }
    for stretch in stretches(curves, |bin| bin.measured.right) {
        let style = RIGHT_COLOR.stroke_width(LINE_WIDTH_PX);
        chart.draw_series(DashedLineSeries::new(stretch.iter().copied(), 6, 4, style))?;
        chart.draw_series(stretch.iter().map(|&place| right_marker(place)))?;
    }
    Ok(())
}

/// The middle of a bin with ends.
pub(crate) fn middle_m(bin: &CurveBin) -> Option<f64> {
    bin.ends_m.map(|[from_m, to_m]| f64::midpoint(from_m, to_m))
}

/// Neighbouring bins that have a place on the scale.
fn stretches(curves: &CurvePair, side: impl Fn(&CurveBin) -> Measured) -> Vec<Vec<(f64, f64)>> {
    let place = |bin: &CurveBin| Some((middle_m(bin)?, side(bin).value.filter(|&value| value > 0.0)?));
    let places: Vec<Option<(f64, f64)>> = curves.bins.iter().map(place).collect();
    let stretches = places.split(Option::is_none).filter(|it| !it.is_empty());
    stretches.map(|it| it.iter().copied().flatten().collect()).collect()
}

/// From below the least value above 0 to above the greatest.
fn value_range(curves: &CurvePair) -> (f64, f64) {
    let values = curves.bins.iter().flat_map(|bin| [bin.measured.left.value, bin.measured.right.value]);
    let shown = values.flatten().filter(|&value| value > 0.0);
    let (low, high) = shown.fold((f64::INFINITY, 0.0_f64), |(low, high), it| (low.min(it), high.max(it)));
    if high > 0.0 { (low / HEADROOM, high * HEADROOM) } else { (0.1, 10.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::curve_pair::tests::pair;

    #[test]
    fn zeros_part_a_curve() {
        let curves = pair(&[(1.0, 1.0), (2.0, 0.0), (0.0, 1.0), (4.0, 1.0)]);
        let expected = [vec![(1.5, 1.0), (2.5, 2.0)], vec![(4.5, 4.0)]];
        assert_eq!(stretches(&curves, |bin| bin.measured.left), expected);
    }

    #[test]
    fn the_scale_holds_all_values_above_zero() {
        assert_eq!(value_range(&pair(&[(1.4, 14.0), (0.0, 2.8)])), (1.0, 14.0 * HEADROOM));
        assert_eq!(value_range(&pair(&[(0.0, 0.0)])), (0.1, 10.0));
    }
}
