//! The plot of precision over recall as the score threshold falls.

use super::figure::Axis;
use super::marks::SeriesMark;
use super::series::{Points, Position, Series};
use super::small_panel::small_panel;
use super::themed_panel::ThemedPanel;

/// A panel with a curve for every detector; recalls and precisions are 0 to 1.
pub fn recall_plot(title: &str, curves: &[(String, Vec<(f64, f64)>)]) -> ThemedPanel {
    let series: Vec<Series> = curves
        .iter()
        .zip((0..).map(SeriesMark))
        .map(|((name, positions), mark)| {
            let percent = thinned(positions).into_iter().map(|(x, y)| (100.0 * x, 100.0 * y));
            let positions = percent.map(|(x, y)| Some(Position { x, y, within: None })).collect();
            Series { name: name.clone(), mark, positions }
        })
        .collect();
    let about = format!("precision over recall on {title}, both in percent");
    let x = Axis::linear("recall (%)", [0.0, 100.0], 6);
    small_panel([title, &about], x, "precision (%)", &series, Points::Line)
}

/// The positions that can be distinguished on a panel: a pixel can hold hundreds of detections.
fn thinned(positions: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let pixel = |(x, y): (f64, f64)| [(x * 400.0).round() as i64, (y * 400.0).round() as i64];
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for &position in positions {
        if kept.last().is_none_or(|last| pixel(*last) != pixel(position)) {
            kept.push(position);
        }
    }
    kept
}
