//! The plot of the fitness of cells over their size.

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::series::{Position, Series};
use super::sweep_panels::{about_bars, curves_of, heading, marks_of, words};
use crate::numbers::sweep_curve::{SweepCurve, highest};
use crate::numbers::sweep_score::{FitnessValue, SweepScores};
use crate::vocabulary::extent::Extent;

/// The readings of the fitness of the cells of `extent` over their size: a panel for each reading. `None` if cell sizes are
/// not swept.
///
/// Paper: HG Fig. 6 a.
pub fn fitness_plot(sweep: &SweepScores, extent: &Extent) -> Option<String> {
    let curves: Vec<_> = curves_of(sweep, extent).into_iter().filter(SweepCurve::sweeps_cells).collect();
    let first = curves.first()?;
    let n_readings = first.first().cells.as_ref().map_or(0, |it| it.readings.len());
    let marks = marks_of(sweep);
    let panels = (0..n_readings).map(|reading_idx| {
        let (mut series, mut of_detectors): (Vec<Series>, Vec<String>) = Default::default();
        for curve in &curves {
            let positions: Vec<_> =
                readings(curve, reading_idx).map(|(x, it)| fitness_position(x, it)).collect();
            // Curves that differ in task, or in parameters outside the grid, have the same cells.
            if series.iter().all(|it| it.positions != positions) {
                let detector = &curve.first().subject.detector;
                let turn = of_detectors.iter().filter(|it| *it == detector).count();
                of_detectors.push(detector.clone());
                series.push(Series {
                    name: curve.named(detector),
                    mark: marks.mark(detector, turn),
                    positions,
                });
            }
        }
        let mut notes = Vec::new();
        let of_first: Vec<(f64, &FitnessValue)> = readings(first, reading_idx).collect();
        if let Some(fittest) = highest(of_first.iter().map(|(_, it)| it.in_range()))
            && let Some(at) = fitness_position(of_first[fittest].0, of_first[fittest].1)
        {
            let text = first.points[fittest].x_text.to_owned();
            let top = at.within.map_or(at.y, |it| it[1]);
            notes.push(Note::Ring { at: (at.x, at.y), top, text });
        }
        if let Some(best) = first.best() {
            let text = format!("best {} {}", best.reached.rate_name(), best.x_text);
            notes.push(Note::Upright(best.x, text));
        }
        let (name, range) = (of_first[0].1.name, of_first[0].1.range);
        let off = of_first.iter().filter(|(_, it)| range.is_some() && it.in_range().is_none());
        let y_range = range.and_then(|range| with_range(&of_first, range));
        for (x, value) in off {
            let edge = y_range
                .map_or(0.0, |[low, high]| if value.value.is_some_and(|it| it > 0.0) { high } else { low });
            if value.value.is_none_or(|it| y_range.is_some_and(|[low, high]| it < low || it > high)) {
                notes.push(Note::Cross((*x, edge)));
            }
        }
        CurvePanel {
            title: panel_title(name, &of_first),
            x_words: words(first.points.iter().map(|it| it.x_text)),
            series,
            notes,
            y_range,
            ..CurvePanel::over(sweep.axis_title(), reading_unit(name))
        }
    });
    let title = format!("Cell fitness, {}. Ring: best fitness. {}", heading(&curves), about_bars(&curves));
    Some(curve_figure(&panels.collect::<Vec<_>>(), &title).svg(&title))
}

fn readings<'a>(
    curve: &'a SweepCurve<'_>,
    reading_idx: usize,
) -> impl Iterator<Item = (f64, &'a FitnessValue)> {
    curve.points.iter().filter_map(move |it| Some((it.x, &it.reached.cells.as_ref()?.readings[reading_idx])))
}

fn fitness_position(x: f64, value: &FitnessValue) -> Option<Position> {
    Some(Position { x, y: value.value?, within: value.within })
}

/// Ends of the y axis of a reading with a range: around its values near the range, so that a pole does not flatten all
/// others. `None` if all values are in range.
fn with_range(values: &[(f64, &FitnessValue)], [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    let near =
        values.iter().filter_map(|(_, it)| it.value).filter(|it| (low - 1.0..=high + 1.0).contains(it));
    let is_outside = values.iter().any(|(_, it)| it.value.is_none_or(|it| it < low || it > high));
    let [least, most] =
        near.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], it| [least.min(it), most.max(it)]);
    let room = 0.1 * (most - least).max(0.05);
    is_outside.then_some([least.min(low) - room, most.max(low) + room]).filter(|it| it[0].is_finite())
}

fn panel_title(name: &str, values: &[(f64, &FitnessValue)]) -> String {
    let n_off = values.iter().filter(|(_, it)| it.in_range().is_none()).count();
    match n_off {
        0 => name.to_owned(),
        _ => format!(
            "{name}: {n_off} of {} undefined or out of range 0 to 1; crosses: off the panel",
            values.len()
        ),
    }
}

/// Unit of a reading.
fn reading_unit(name: &str) -> &'static str {
    match name {
        "knuth" => "log posterior (nats/point)",
        "cross-validation" => "−risk (1/m²)",
        _ => "fitness",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::sweep_score::tests::{cell_sizes, street};

    #[test]
    fn fitness_says_what_is_undefined_and_where_the_best_rate_is() {
        let sweep = cell_sizes(&[
            (4, Some(6), Some(-0.5), 0.1),
            (8, Some(2), None, 0.3),
            (7, Some(2), Some(40.0), 0.2),
        ]);
        let svg = fitness_plot(&sweep, &street()).unwrap();
        check_holds(
            &svg,
            &["printed: 3 of 3 undefined or out of range", "dense-share", "best F-rate 0.4", "fitness"],
        );
        let mut other = sweep.clone();
        other.scores.iter_mut().for_each(|it| it.cells = None);
        assert_eq!(fitness_plot(&other, &street()), None);
    }
}
