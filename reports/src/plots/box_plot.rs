//! The plot of the errors of fitted boxes against annotated ones.

use super::figure::{Axis, Chart, Figure, Frame, Grid, LEFT_PX, Labels, Panel, TEXT_PX, USUAL_FRAME};
use super::marks::{LINE_WIDTH_PX, Mark, SeriesMark};
use super::series::{KEY_LINE_PX, key_name};
use crate::numbers::box_errors::{BoxError, BoxErrorLine};

const ROW_PX: u32 = 240;
/// Properties that the panels side by side are sliced by.
const DRAWN: [&str; 2] = ["occlusion", "range"];
/// Distance between the fits of a slice; slices are 1 apart.
const ASIDE: f64 = 0.13;

/// The plot of `lines`, all of the same data, as an SVG document: a row of panels for each of [`BoxError::OF_SLICES`], by
/// occlusion and by range, with the 95 % interval of every number. `title` says what the data are.
pub fn box_plot(lines: &[BoxErrorLine], title: &str) -> String {
    let mut heading = vec![Mark::title(title, (LEFT_PX, 20.0))];
    for (series, (fit, _)) in lines.first().map_or(&[][..], |it| &it.fits).iter().enumerate() {
        let y_px = 48.0 + f64::from(KEY_LINE_PX) * series as f64;
        heading.push(SeriesMark(series).marker((LEFT_PX + 8.0, y_px)));
        heading.push(key_name(fit, LEFT_PX + 24.0, y_px));
    }
    let rows = BoxError::OF_SLICES.map(|error| (ROW_PX, row(lines, error)));
    Figure { width_px: 1000, heading_px: 166, heading, rows: rows.into() }.svg(title)
}

/// The panels of one error, to the same scale.
fn row(lines: &[BoxErrorLine], error: BoxError) -> Vec<Panel> {
    let is_drawn = |it: &&BoxErrorLine| it.error == error && DRAWN.contains(&it.by.as_str());
    let of_error = || lines.iter().filter(is_drawn);
    let numbers = of_error().flat_map(|it| it.fits.iter().filter_map(|(_, it)| *it));
    let greatest = numbers.map(|it| it.within.map_or(it.value, |it| it.ends[1])).fold(0.0_f64, f64::max);
    let panel_by = |by: &str| {
        let of_panel: Vec<&BoxErrorLine> = of_error().filter(|it| it.by == by).collect();
        panel(&of_panel, error, by, 1.05 * greatest.max(1e-3))
    };
    DRAWN.map(panel_by).into()
}

fn panel(lines: &[&BoxErrorLine], error: BoxError, by: &str, top: f64) -> Panel {
    let Some(first) = lines.first() else { return Panel::default() };
    let mut marks = Vec::new();
    for series in 0..first.fits.len() {
        let mark = SeriesMark(series);
        let aside = ASIDE * (series as f64 - (first.fits.len() as f64 - 1.0) / 2.0);
        let medians = (0_u32..).zip(lines).filter_map(|(index, line)| {
            let it = line.fits.get(series)?.1?;
            Some((f64::from(index) + aside, it))
        });
        let medians: Vec<_> = medians.collect();
        let bars = medians.iter().filter_map(|&(x, it)| {
            Some(Mark::line(it.within?.ends.map(|end| (x, end)), mark.color(), LINE_WIDTH_PX))
        });
        marks.extend(bars);
        marks.extend(medians.iter().map(|&(x, it)| mark.marker((x, it.value))));
    }
    let x_title = if by == "range" { "range" } else { "hidden by others" };
    // A label at the middle of each slice, and none between.
    let x = Axis::linear(x_title, [-0.5, lines.len() as f64 - 0.5], 2 * lines.len() + 1);
    let x = x.labelled(Labels::Words(lines.iter().map(|it| slice_name(it)).collect()));
    let y = Axis::linear(axis_title(error), [0.0, top], 5);
    let frame = Frame { text_px: [TEXT_PX - 2, TEXT_PX], grid: Grid::Level, ..USUAL_FRAME };
    Chart { frame, ..Chart::new(x, y, marks) }.into()
}

fn slice_name(line: &BoxErrorLine) -> String {
    let blocks: Vec<_> = line.fits.iter().filter_map(|(_, it)| Some((*it)?.within?.blocks)).collect();
    // As in tables: the interval allows no conclusion.
    let sign = if blocks.iter().any(|it| it.may_be_neighbours()) {
        " ¶"
    } else if blocks.iter().any(|it| it.are_too_few()) {
        " §"
    } else {
        ""
    };
    format!("{} (n {}{sign})", line.slice, line.n_pairs)
}

fn axis_title(error: BoxError) -> String {
    let what = if error.is_share() { "" } else { " error" };
    format!("{}{what} ({})", error.name(), error.unit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::box_errors::tests::lines;

    #[test]
    fn axes_have_units_and_slices_their_numbers() {
        let lines = [
            lines("street", "occlusion", "none", 80),
            lines("street", "occlusion", "partly", 0),
            lines("street", "range", "0–15 m", 8),
        ]
        .concat();
        let svg = box_plot(&lines, "Streets (simulated)");
        check_holds(
            &svg,
            &[
                "Streets (simulated)",
                "centre error (m)",
                "yaw error (deg)",
                "none (n 80)",
                "0–15 m (n 8 §)",
                "PCA box",
            ],
        );
        assert!(box_plot(&[], "Nothing").contains("</svg>"));
    }
}
