//! The plot of one statistic of two collections of scans.

use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, VPos};

use super::bar_chart::{bar_chart, bar_key};
use super::figure::{
    Axis, Chart, Figure, Frame, LEFT_MARGIN_PX, LEFT_PX, LEFT_ROOM_PX, Labels, Scale, TEXT_PX, USUAL_FRAME,
};
use super::marks::{BLACK, Mark, SeriesMark, color, text_style};
use super::palette::BAND;
use super::series::{Points, Position, Series, key_lines, series_marks};
use crate::numbers::curve_pair::{ALIKE_FACTOR, CurveBin, CurvePair, Measured, Sides};

const HEADING_PX: u32 = 88;
const PANELS_PX: u32 = 532;
/// Height of the panel of the curves; the ratios have the rest.
const CURVES_PX: u32 = 320;
/// Room above the uppermost and below the lowest value, as a factor.
const HEADROOM: f64 = 1.4;
/// The scale of ratios reaches at least this far from 1, in doublings.
const LEAST_REACH: f64 = 1.2;
/// The scale of ratios reaches at most this far from 1, in doublings; ratios beyond it are drawn at the edge.
const GREATEST_REACH: f64 = 3.2;

/// The plot as an SVG document: curves over a length with their ratios beneath, or bars if the bins are kinds of
/// something. `names` are those of both sides, and say whether they are simulated.
pub fn curve_plot(curves: &CurvePair, names: Sides<&str>) -> String {
    let ends_m = curves.bins.first().zip(curves.bins.last()).and_then(|(first, last)| {
        let ([from_m, _], [_, to_m]) = first.ends_m.zip(last.ends_m)?;
        Some([from_m, to_m])
    });
    let by = curves.bins_of.map_or_else(String::new, |it| format!(" by {it}"));
    let title = format!("{}{by}", curves.title);
    let mut heading = vec![Mark::title(&title, (LEFT_PX, 20.0))];
    let names = [format!("left: {}", names.left), format!("right: {}", names.right)];
    let rows = if let Some(ends_m) = ends_m {
        heading.extend(key_lines((0..).map(SeriesMark).zip(names.iter().map(String::as_str)), 48.0));
        vec![
            (CURVES_PX, vec![line_chart(curves, ends_m).into()]),
            (PANELS_PX - CURVES_PX, vec![ratio_chart(curves, ends_m).into()]),
        ]
    } else {
        heading.extend(bar_key(&names, 48.0));
        vec![(PANELS_PX, vec![bar_chart(curves).into()])]
    };
    Figure { width_px: 900, heading_px: HEADING_PX, heading, rows }.svg(&title)
}

/// Both curves, on a logarithmic scale. Values of 0, which have no position on it, are gaps.
fn line_chart(curves: &CurvePair, ends_m: [f64; 2]) -> Chart {
    let ends = value_range(curves);
    let sides: [fn(&CurveBin) -> Measured; 2] = [|bin| bin.measured.left, |bin| bin.measured.right];
    let series = [0, 1].map(|idx| Series {
        name: String::new(),
        mark: SeriesMark(idx),
        positions: positions(curves, sides[idx]),
    });
    let x = Axis::linear("", ends_m, 16).labelled(Labels::Blank);
    let y = Axis::linear(format!("{} ({})", curves.title, curves.unit), ends, 11);
    let y = Axis { scale: Scale::Logarithmic(ends), ..y };
    let frame = Frame { margins_px: [6, 20, 0, LEFT_MARGIN_PX], room_px: [8, LEFT_ROOM_PX], ..USUAL_FRAME };
    Chart { frame, ..Chart::new(x, y, series_marks(&series, Points::Marked { apart: 0.0 }, ends)) }
}

/// Left over right for every bin that has a ratio, with the band in which two values count as alike.
fn ratio_chart(curves: &CurvePair, ends_m: [f64; 2]) -> Chart {
    let ratios: Vec<(f64, f64)> = (0..curves.bins.len())
        .filter_map(|bin_idx| Some((middle_m(&curves.bins[bin_idx])?, curves.ratio(bin_idx)?.log2())))
        .collect();
    let farthest = ratios.iter().map(|(_, doublings)| doublings.abs()).fold(0.0, f64::max);
    let reach = (farthest + 0.2).clamp(LEAST_REACH, GREATEST_REACH);
    let band = ALIKE_FACTOR.log2();
    let edge = reach - 0.1;
    let mut marks = vec![Mark::line(ends_m.map(|it| (it, 0.0)), BLACK, 1)];
    marks.extend(ratios.iter().map(|&(middle_m, doublings)| {
        let is_on_scale = doublings.abs() <= edge;
        let style = if is_on_scale { BLACK.filled() } else { BLACK.stroke_width(1) };
        Mark::circle((middle_m, doublings.clamp(-edge, edge)), 3, style)
    }));
    if farthest > edge {
        let position = (f64::midpoint(ends_m[0], ends_m[1]), reach);
        let style = text_style(TEXT_PX, HPos::Center, VPos::Top);
        marks.push(Mark::text(position, [0, 4], "hollow: off the scale", style));
    }
    let x = Axis::linear(format!("{} (m)", curves.bins_of.unwrap_or_default()), ends_m, 16);
    let y = Axis::linear("ratio, left / right", [-reach, reach], 7).labelled(Labels::Ratios);
    let frame = Frame { margins_px: [0, 20, 0, LEFT_MARGIN_PX], ..USUAL_FRAME };
    let band = Mark::rectangle([(ends_m[0], -band), (ends_m[1], band)], color(BAND));
    Chart { frame, band: Some(band), ..Chart::new(x, y, marks) }
}

/// The middle of a bin in metres; `None` if it has no ends.
fn middle_m(bin: &CurveBin) -> Option<f64> {
    bin.ends_m.map(|[from_m, to_m]| f64::midpoint(from_m, to_m))
}

/// The position of every bin; `None` if its value has none on the scale.
fn positions(curves: &CurvePair, side: impl Fn(&CurveBin) -> Measured) -> Vec<Option<Position>> {
    let position = |bin: &CurveBin| {
        let y = side(bin).value.filter(|&value| value > 0.0)?;
        Some(Position { x: middle_m(bin)?, y, within: None })
    };
    curves.bins.iter().map(position).collect()
}

/// Ends of the scale: below the least value above 0, and above the greatest value.
fn value_range(curves: &CurvePair) -> [f64; 2] {
    let values = curves.bins.iter().flat_map(|bin| [bin.measured.left.value, bin.measured.right.value]);
    let shown = values.flatten().filter(|&value| value > 0.0);
    let (low, high) = shown.fold((f64::INFINITY, 0.0_f64), |(low, high), it| (low.min(it), high.max(it)));
    if high > 0.0 { [low / HEADROOM, high * HEADROOM] } else { [0.1, 10.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::curve_pair::tests::pair;

    const NAMES: Sides<&str> = Sides { left: "street (simulated)", right: "kitti" };

    #[test]
    fn curves_over_a_length_have_units_on_both_axes_and_both_names() {
        let svg = curve_plot(&pair(&[(1.0, 2.0), (30.0, 4.0), (0.0, 5.0)]), NAMES);
        check_holds(&svg, &["<svg ", "</svg>", "street (simulated)", "kitti", "range (m)", "(points/m²)"]);
    }

    #[test]
    fn kinds_have_names_values_and_ratios() {
        let mut curves = pair(&[(1.0, 2.0), (30.0, 0.0)]);
        for (bin, name) in curves.bins.iter_mut().zip(["short", "tall"]) {
            (bin.name, bin.ends_m) = (name.to_owned(), None);
        }
        let svg = curve_plot(&curves, NAMES);
        check_holds(&svg, &["short", "tall", "ratio 0.50", "no ratio", "30.0", "street (simulated)"]);
    }

    #[test]
    fn nothing_measured_can_be_drawn() {
        let mut curves = pair(&[(0.0, 0.0)]);
        check_holds(&curve_plot(&curves, NAMES), &["</svg>"]);
        curves.bins.clear();
        check_holds(&curve_plot(&curves, NAMES), &["</svg>"]);
    }

    #[test]
    fn the_same_curves_give_the_same_bytes() {
        let curves = pair(&[(1.0, 2.0), (30.0, 4.0)]);
        assert_eq!(curve_plot(&curves, NAMES), curve_plot(&curves, NAMES));
    }

    #[test]
    fn zeros_have_no_position() {
        let curves = pair(&[(1.0, 1.0), (0.0, 1.0), (4.0, 1.0)]);
        let positions = positions(&curves, |bin| bin.measured.left);
        assert_eq!(
            positions.iter().map(|it| it.map(|it| (it.x, it.y))).collect::<Vec<_>>(),
            [Some((1.5, 1.0)), None, Some((3.5, 4.0))]
        );
    }

    #[test]
    fn the_scale_holds_all_values_above_zero() {
        assert_eq!(value_range(&pair(&[(1.4, 14.0), (0.0, 2.8)])), [1.0, 14.0 * HEADROOM]);
        assert_eq!(value_range(&pair(&[(0.0, 0.0)])), [0.1, 10.0]);
    }
}
