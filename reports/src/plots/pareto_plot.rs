//! The plot of rates against times.

use std::collections::BTreeSet;

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::series::{Position, Series};
use super::sweep_panels::{curves_of, heading, marks_of};
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::task::Task;

/// The rates of `extent` against the time of a scan, with the Pareto front: the points that no other is both faster
/// and better than. A panel for each task. `None` if nothing was timed.
pub fn pareto_plot(sweep: &SweepScores, extent: &Extent) -> Option<String> {
    let curves = curves_of(sweep, extent);
    let tasks: BTreeSet<Task> = curves.iter().map(|it| it.first().task).collect();
    let (marks, mut panels) = (marks_of(sweep), Vec::new());
    for task in tasks {
        let of_task: Vec<_> = curves.iter().filter(|it| it.first().task == task).collect();
        let mut points: Vec<(f64, f64, &str, String)> = Vec::new();
        for curve in &of_task {
            let detector = curve.first().subject.detector.as_str();
            for point in &curve.points {
                let Some((time, rate)) = sweep.time_of(&point.reached.subject).zip(point.reached.rate())
                else {
                    continue;
                };
                points.push((time.typical_ms, 100.0 * rate, detector, curve.named(point.x_text)));
            }
        }
        if points.is_empty() {
            continue;
        }
        let front = pareto_front(&points.iter().map(|it| (it.0, it.1)).collect::<Vec<_>>());
        let mut detectors: Vec<&str> = points.iter().map(|it| it.2).collect();
        detectors.dedup();
        let series = detectors.into_iter().map(|name| Series {
            name: name.to_owned(),
            mark: marks.mark(name, 0),
            // Single positions between gaps: no line joins them.
            positions: points
                .iter()
                .filter(|it| it.2 == name)
                .flat_map(|it| [Some(Position { x: it.0, y: it.1, within: None }), None])
                .collect(),
        });
        let notes = front_notes(&points, &front);
        let x_title = "time of a scan (ms): median of the shortest of each";
        panels.push(CurvePanel {
            title: task.name().to_owned(),
            series: series.collect(),
            notes,
            thread: front.iter().map(|&it| (points[it].0, points[it].1)).collect(),
            ..CurvePanel::over(x_title, format!("{} (%)", of_task[0].first().rate_name()))
        });
    }
    let title = format!("{}. Ring and {}: Pareto front", heading(&curves), sweep.axis_title());
    (!panels.is_empty()).then(|| curve_figure(&panels, &title).svg(&title))
}

/// A ring around every point of the front, with its text unless that would run into an earlier one.
fn front_notes(points: &[(f64, f64, &str, String)], front: &[usize]) -> Vec<Note> {
    let reach = |of: fn(&(f64, f64, &str, String)) -> f64| {
        let ends = points
            .iter()
            .map(of)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
        (ends[1] - ends[0]).max(f64::MIN_POSITIVE)
    };
    let (width, height) = (reach(|it| it.0), reach(|it| it.1));
    let mut notes: Vec<Note> = Vec::new();
    for point in front.iter().map(|&it| &points[it]) {
        let runs_into = |it: &Note| {
            let Note::Front((x, y), text) = it else { return false };
            let characters = text.chars().count().max(point.3.chars().count()) as f64;
            let (aside, above) = ((x - point.0).abs() / width, (y - point.1).abs() / height);
            !text.is_empty() && aside < 0.012 * characters && above < 0.09
        };
        let text = if notes.iter().any(runs_into) { String::new() } else { point.3.clone() };
        notes.push(Note::Front((point.0, point.1), text));
    }
    notes
}

/// Indices of the points, the fastest first, to which no other point is at least equal in both and better in one.
pub(crate) fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 >= b.1 && a != b;
    let mut front: Vec<usize> =
        (0..points.len()).filter(|&it| !points.iter().any(|other| beats(other, &points[it]))).collect();
    front.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(a.cmp(&b)));
    front
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::sweep_score::tests::{cell_sizes, street};

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(3.0, 60.0), (1.0, 40.0), (2.0, 70.0), (2.0, 50.0), (5.0, 70.0), (9.0, 71.0)];
        assert_eq!(pareto_front(&points), [1, 2, 5]);
        assert_eq!(pareto_front(&[(1.0, 1.0), (1.0, 1.0)]), [0, 1]);
    }

    #[test]
    fn rates_stand_against_times() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3)]);
        let svg = pareto_plot(&sweep, &street()).unwrap();
        check_holds(
            &svg,
            &["time of a scan (ms): median of the shortest of each", "F-rate (%)", "Pareto front"],
        );
        let untimed = SweepScores { times: Vec::new(), ..sweep };
        assert_eq!(pareto_plot(&untimed, &street()), None);
    }
}
