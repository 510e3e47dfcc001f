//! The plot of the share of detections that are right over the share that is expected to be.

use super::figure::Axis;
use super::marks::{Mark, QUIET, SeriesMark};
use super::series::{Points, Position, Series};
use super::small_panel::small_panel_over;
use super::themed_panel::ThemedPanel;
use crate::numbers::calibration::CalibrationBin;

/// A bin with fewer detections is left out: one of them is more than 10 %.
pub const LEAST_IN_BIN: usize = 10;

/// A panel with the bins of every detector, and the diagonal, on which expected and observed shares are equal.
pub fn reliability_plot(title: &str, of_detectors: &[(String, Vec<CalibrationBin>)]) -> ThemedPanel {
    let series: Vec<Series> = of_detectors
        .iter()
        .zip((0..).map(SeriesMark))
        .map(|((name, bins), mark)| {
            let shown = bins.iter().filter(|it| it.n >= LEAST_IN_BIN);
            let position = |it: &CalibrationBin| Position {
                x: 100.0 * it.expected,
                y: 100.0 * it.observed,
                within: None,
            };
            Series { name: name.clone(), mark, positions: shown.map(position).map(Some).collect() }
        })
        .collect();
    let about =
        format!("vehicles that are right over vehicles that are expected to be on {title}, both in percent");
    let x = Axis::linear("expected (%)", [0.0, 100.0], 6);
    let diagonal = Mark::line([(0.0, 0.0), (100.0, 100.0)], QUIET, 1);
    small_panel_over(vec![diagonal], [title, &about], x, "right (%)", &series, Points::Marked { apart: 0.0 })
}
