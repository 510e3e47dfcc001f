//! Bars for the two values of each bin, with their ratio.

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::{
    Axis, Chart, Frame, Grid, LEFT_MARGIN_PX, LEFT_PX, LEFT_ROOM_PX, Labels, TEXT_PX, USUAL_FRAME,
};
use super::marks::{Mark, SeriesMark, text_style};
use super::series::{KEY_LINE_PX, key_name};
use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::numbers::curve_pair::{CurvePair, Sides};

/// Ends of the bars of the left and of the right side, as shares of the width of their bin.
const BARS: [[f64; 2]; 2] = [[0.14, 0.48], [0.52, 0.86]];

/// Two bars for every bin, from 0 up, each with its value; the ratio is beneath.
pub(crate) fn bar_chart(curves: &CurvePair) -> Chart {
    let values = curves.bins.iter().flat_map(|bin| [bin.measured.left.value, bin.measured.right.value]);
    let greatest = values.flatten().fold(0.0, f64::max);
    let top = if greatest > 0.0 { 1.12 * greatest } else { 1.0 };
    let x = Axis::linear("", [0.0, curves.bins.len() as f64], 11).labelled(Labels::NoAxis);
    let y = Axis::linear(format!("{} ({})", curves.title, curves.unit), [0.0, top], 8);
    let (margins_px, room_px) = ([6, 20, 0, LEFT_MARGIN_PX], [56, LEFT_ROOM_PX]);
    let frame = Frame { margins_px, room_px, grid: Grid::Level, ..USUAL_FRAME };
    let marks = (0..curves.bins.len()).flat_map(|it| bin_marks(curves, it)).collect();
    Chart { frame, ..Chart::new(x, y, marks) }
}

fn bin_marks(curves: &CurvePair, bin_idx: usize) -> Vec<Mark> {
    let (bin, start) = (&curves.bins[bin_idx], bin_idx as f64);
    let Sides { left, right } = bin.measured;
    let values = [left.value, right.value];
    let corners = [0, 1].map(|side| {
        let [from, to] = BARS[side];
        [(start + from, 0.0), (start + to, values[side].unwrap_or(0.0))]
    });
    let mut marks = bars(corners).to_vec();
    for ([from, to], value) in BARS.into_iter().zip(values) {
        let position = (start + f64::midpoint(from, to), value.unwrap_or(0.0));
        let text = value.map_or_else(|| "–".to_owned(), three_digits);
        marks.push(Mark::text(position, [0, -4], text, text_style(TEXT_PX, HPos::Center, VPos::Bottom)));
    }
    let ratio = curves.ratio(bin_idx);
    let ratio = ratio.map_or("no ratio".to_owned(), |it| format!("ratio {}", fixed_decimals(it, 2)));
    for (line, y_px) in [(bin.name.clone(), 8), (ratio, 30)] {
        let style = text_style(TEXT_PX, HPos::Center, VPos::Top);
        marks.push(Mark::text((start + 0.5, 0.0), [0, y_px], line, style));
    }
    marks
}

/// The key to the bars of both sides, called `names`, in pixels from `top_px` on.
pub(crate) fn bar_key(names: &[String; 2], top_px: f64) -> Vec<Mark> {
    const SAMPLE_PX: f64 = 44.0;
    let y_px = [top_px, top_px + f64::from(KEY_LINE_PX)];
    let texts = names.iter().zip(y_px).map(|(it, y_px)| key_name(it, LEFT_PX + SAMPLE_PX + 12.0, y_px));
    let corners = y_px.map(|it| [(LEFT_PX, it - 7.0), (LEFT_PX + SAMPLE_PX, it + 7.0)]);
    texts.chain(bars(corners)).collect()
}

/// A filled bar for the left side, a hollow one for the right.
fn bars([left, right]: [[(f64, f64); 2]; 2]) -> [Mark; 2] {
    [Mark::rectangle(left, SeriesMark(0).color()), Mark::outline(right, SeriesMark(1).color())]
}
