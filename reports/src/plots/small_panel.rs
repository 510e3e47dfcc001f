//! Panels so small that three of them fit side by side on a page, and one on a telephone.

use super::figure::{Axis, Chart, Figure, Frame, Grid, Panel};
use super::marks::{Mark, QUIET, bold_style};
use super::series::{Points, Series, series_marks};
use super::themed_panel::ThemedPanel;

pub(crate) const WIDTH_PX: u32 = 360;
const HEIGHT_PX: u32 = 250;
/// Height of all text in pixels as the library counts it, 1.24 times what browsers call its size.
pub(crate) const SMALL_TEXT_PX: i32 = 16;
const FRAME: Frame = Frame {
    margins_px: [24, 12, 0, 2],
    room_px: [44, 50],
    text_px: [SMALL_TEXT_PX, SMALL_TEXT_PX],
    axis_color: QUIET,
    grid: Grid::Both,
};

/// A panel of percentages, called `title`; `about` describes the numbers of the detectors, whose `series` are in the order
/// of the run.
pub(crate) fn small_panel(
    [title, about]: [&str; 2],
    x: Axis,
    y_title: &str,
    series: &[Series],
    points: Points,
) -> ThemedPanel {
    small_panel_over(Vec::new(), [title, about], x, y_title, series, points)
}

/// As [`small_panel`], with the marks `behind` behind the series.
pub(crate) fn small_panel_over(
    behind: Vec<Mark>,
    [title, about]: [&str; 2],
    x: Axis,
    y_title: &str,
    series: &[Series],
    points: Points,
) -> ThemedPanel {
    let percent = [0.0, 100.0];
    let mut marks = behind;
    marks.extend(series_marks(series, points, percent));
    let chart = Chart { frame: FRAME, ..Chart::new(x, Axis::linear(y_title, percent, 6), marks) };
    let title = Mark::text((52.0, 10.0), [0, 0], title, bold_style(SMALL_TEXT_PX));
    let panel = Panel { marks: vec![title], chart: Some(chart) };
    let rows = vec![(HEIGHT_PX, vec![panel])];
    let detectors: Vec<&str> = series.iter().map(|it| it.name.as_str()).collect();
    Figure { width_px: WIDTH_PX, heading_px: 0, heading: Vec::new(), rows }
        .panel(format!("{about}, of {}", detectors.join(", ")))
}
