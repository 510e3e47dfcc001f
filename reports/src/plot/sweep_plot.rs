//! The plots of a sweep: rates and fitness over the first parameter, and rates against times.

use std::collections::BTreeMap;

use super::curve_panel::{Note, NoteShape, Panel, Place, Series, panels_svg};
use crate::table::sweep_curve::{SweepCurve, highest};
use crate::table::sweep_score::{FitnessValue, SweepScores};
use crate::table::task_table::{Extent, Origin};

/// The rates of `extent` over the first parameter, in percent with 95 % intervals: a panel for each task and each
/// combination of the others, a series for each detector.
///
/// Paper: HG Fig. 6 b.
pub fn rate_plot(sweep: &SweepScores, extent: &Extent) -> String {
    let curves = curves_of(sweep, extent);
    let mut panels: BTreeMap<(usize, usize), Panel> = BTreeMap::new();
    let places = PanelPlaces::of(&curves);
    for curve in &curves {
        let first = curve.points[0].score;
        let panel = panels.entry(places.of_curve(curve)).or_insert_with(|| Panel {
            title: [vec![first.task.clone()], curve.others.clone()].concat().join(", "),
            x_title: sweep.axis_title(),
            y_title: format!("{} (%)", first.rate_name()),
            x_words: words(curve),
            series: Vec::new(),
            notes: Vec::new(),
            thread: Vec::new(),
            y_range: None,
        });
        let place = |it: &crate::table::sweep_curve::CurvePoint<'_>| {
            let percent = |it: f64| 100.0 * it;
            Some(Place {
                x: it.x,
                y: percent(it.score.rate()?),
                within: it.score.rate_within().map(|it| it.map(percent)),
            })
        };
        let series =
            Series { name: first.subject.detector.clone(), places: curve.points.iter().map(place).collect() };
        if let Some(best) = curve.best()
            && let Some(at) = series.places[best]
        {
            let text = curve.points[best].x_text.to_owned();
            panel.notes.push(Note { place: (at.x, at.y), text, shape: NoteShape::Ring });
        }
        panel.series.push(series);
    }
    let title = format!("{}. Ring: best. Bars: 95 % intervals", heading(&curves));
    panels_svg(&panels.into_values().collect::<Vec<_>>(), &title)
}

/// The readings of the fitness of the cells of `extent` over their size: a panel for each reading. `None` if cell sizes are not
/// what is swept.
///
/// Paper: HG Fig. 6 a.
pub fn fitness_plot(sweep: &SweepScores, extent: &Extent) -> Option<String> {
    let curves: Vec<_> = curves_of(sweep, extent).into_iter().filter(SweepCurve::sweeps_cells).collect();
    let first = curves.first()?;
    let best = first.best().map(|best| (&first.points[best], first.points[best].score));
    let n_readings = first.points[0].score.cells.as_ref().map_or(0, |it| it.readings.len());
    let panels = (0..n_readings).map(|reading_idx| {
        let mut series: Vec<Series> = Vec::new();
        for curve in &curves {
            let places: Vec<_> = readings(curve, reading_idx).map(|(x, it)| fitness_place(x, it)).collect();
            // Tasks, and parameters that are none of the grid's, have the same cells.
            if series.iter().all(|it| it.places != places) {
                let subject = &curve.points[0].score.subject;
                let name = [vec![subject.detector.clone()], curve.others.clone()].concat().join(", ");
                series.push(Series { name, places });
            }
        }
        let mut notes = Vec::new();
        let of_first: Vec<(f64, &FitnessValue)> = readings(first, reading_idx).collect();
        if let Some(fittest) = highest(of_first.iter().map(|(_, it)| it.in_range()))
            && let Some(at) = fitness_place(of_first[fittest].0, of_first[fittest].1)
        {
            let text = first.points[fittest].x_text.to_owned();
            notes.push(Note { place: (at.x, at.y), text, shape: NoteShape::Ring });
        }
        if let Some((point, score)) = best {
            let text = format!("best {} {}", score.rate_name(), point.x_text);
            notes.push(Note { place: (point.x, 0.0), text, shape: NoteShape::Upright });
        }
        let (name, range) = (of_first[0].1.name, of_first[0].1.range);
        let off = of_first.iter().filter(|(_, it)| range.is_some() && it.in_range().is_none());
        let y_range = range.and_then(|range| with_range(&of_first, range));
        for (x, value) in off {
            let edge = y_range
                .map_or(0.0, |[low, high]| if value.value.is_some_and(|it| it > 0.0) { high } else { low });
            if value.value.is_none_or(|it| y_range.is_some_and(|[low, high]| it < low || it > high)) {
                notes.push(Note { place: (*x, edge), text: String::new(), shape: NoteShape::Cross });
            }
        }
        Panel {
            title: panel_title(name, &of_first),
            x_title: sweep.axis_title(),
            y_title: reading_unit(name).to_owned(),
            x_words: words(first),
            series,
            notes,
            thread: Vec::new(),
            y_range,
        }
    });
    let title = format!("Cell fitness, {}. Ring: fittest. Bars: 95 % intervals", heading(&curves));
    Some(panels_svg(&panels.collect::<Vec<_>>(), &title))
}

/// The rates of `extent` against the median time of a scan, with the Pareto front: the points that no other is both faster
/// and better than. A panel for each task. `None` if nothing was timed.
pub fn pareto_plot(sweep: &SweepScores, extent: &Extent) -> Option<String> {
    let curves = curves_of(sweep, extent);
    let mut tasks: Vec<&str> = curves.iter().map(|it| it.points[0].score.task.as_str()).collect();
    tasks.dedup();
    tasks.sort_unstable();
    tasks.dedup();
    let mut panels = Vec::new();
    for task in tasks {
        let of_task: Vec<_> = curves.iter().filter(|it| it.points[0].score.task == task).collect();
        let mut detectors: Vec<&str> = Vec::new();
        let mut points: Vec<(f64, f64, usize, String)> = Vec::new();
        for curve in &of_task {
            let detector = curve.points[0].score.subject.detector.as_str();
            let detector_idx = detectors.iter().position(|it| *it == detector).unwrap_or_else(|| {
                detectors.push(detector);
                detectors.len() - 1
            });
            for point in &curve.points {
                let Some((time, rate)) = point.time.zip(point.score.rate()) else { continue };
                let text = [vec![point.x_text.to_owned()], curve.others.clone()].concat().join(", ");
                points.push((time.p50_ms, 100.0 * rate, detector_idx, text));
            }
        }
        if points.is_empty() {
            continue;
        }
        let front = pareto_front(&points.iter().map(|it| (it.0, it.1)).collect::<Vec<_>>());
        let series = detectors.iter().enumerate().map(|(detector_idx, name)| Series {
            name: (*name).to_owned(),
            // Single places between gaps: nothing leads from one to the next.
            places: points
                .iter()
                .filter(|it| it.2 == detector_idx)
                .flat_map(|it| [Some(Place { x: it.0, y: it.1, within: None }), None])
                .collect(),
        });
        let notes = front_notes(&points, &front);
        panels.push(Panel {
            title: task.to_owned(),
            x_title: "median time of a scan (ms)".to_owned(),
            y_title: format!("{} (%)", of_task[0].points[0].score.rate_name()),
            x_words: None,
            series: series.collect(),
            notes,
            thread: front.iter().map(|&it| (points[it].0, points[it].1)).collect(),
            y_range: None,
        });
    }
    let title = format!("{}. Ring and {}: Pareto front", heading(&curves), sweep.axis_title());
    (!panels.is_empty()).then(|| panels_svg(&panels, &title))
}

/// A ring around every point of the front, and its values unless they would run into those of the one before.
fn front_notes(points: &[(f64, f64, usize, String)], front: &[usize]) -> Vec<Note> {
    let reach = |of: fn(&(f64, f64, usize, String)) -> f64| {
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
            let characters = it.text.chars().count().max(point.3.chars().count()) as f64;
            let (aside, above) =
                ((it.place.0 - point.0).abs() / width, (it.place.1 - point.1).abs() / height);
            !it.text.is_empty() && aside < 0.012 * characters && above < 0.09
        };
        let text = if notes.iter().any(runs_into) { String::new() } else { point.3.clone() };
        notes.push(Note { place: (point.0, point.1), text, shape: NoteShape::Ring });
    }
    notes
}

/// Places of the points that no other is at least as fast and as good as, and better in one of both; the fastest first.
pub(crate) fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 >= b.1 && a != b;
    let mut front: Vec<usize> =
        (0..points.len()).filter(|&it| !points.iter().any(|other| beats(other, &points[it]))).collect();
    front.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(a.cmp(&b)));
    front
}

fn curves_of<'a>(sweep: &'a SweepScores, extent: &Extent) -> Vec<SweepCurve<'a>> {
    sweep.curves().into_iter().filter(|it| it.points[0].score.subject.extent == *extent).collect()
}

/// Data set, and whether it is simulated.
fn heading(curves: &[SweepCurve<'_>]) -> String {
    let Some(first) = curves.first() else { return "nothing".to_owned() };
    let subject = &first.points[0].score.subject;
    let name = match &subject.extent {
        Extent::Dataset(id) => id,
        Extent::Overall => "all data sets",
    };
    match subject.origin {
        Origin::Recorded => name.to_owned(),
        origin => format!("{name} ({})", origin.name()),
    }
}

fn words(curve: &SweepCurve<'_>) -> Option<Vec<String>> {
    let is_numeric = curve.points.iter().all(|it| it.x_text.parse::<f64>().is_ok());
    (!is_numeric).then(|| curve.points.iter().map(|it| it.x_text.to_owned()).collect())
}

fn readings<'a>(
    curve: &'a SweepCurve<'_>,
    reading_idx: usize,
) -> impl Iterator<Item = (f64, &'a FitnessValue)> {
    curve.points.iter().filter_map(move |it| Some((it.x, &it.score.cells.as_ref()?.readings[reading_idx])))
}

fn fitness_place(x: f64, value: &FitnessValue) -> Option<Place> {
    Some(Place { x, y: value.value?, within: value.within })
}

/// The y axis of a reading that has a range: that of its values, as far as they are near the range, so that a pole does not
/// flatten all others.
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

/// What a reading is measured in.
fn reading_unit(name: &str) -> &'static str {
    match name {
        "knuth" => "log posterior (nats/point)",
        "cross-validation" => "−risk (1/m²)",
        _ => "fitness",
    }
}

/// Tasks from above, and for each the combinations of other parameters.
struct PanelPlaces {
    tasks: Vec<String>,
    others: Vec<Vec<String>>,
}

impl PanelPlaces {
    fn of(curves: &[SweepCurve<'_>]) -> Self {
        let mut places = Self { tasks: Vec::new(), others: Vec::new() };
        for curve in curves {
            let task = &curve.points[0].score.task;
            if !places.tasks.contains(task) {
                places.tasks.push(task.clone());
            }
            if !places.others.contains(&curve.others) {
                places.others.push(curve.others.clone());
            }
        }
        places
    }

    fn of_curve(&self, curve: &SweepCurve<'_>) -> (usize, usize) {
        let task = self.tasks.iter().position(|it| *it == curve.points[0].score.task);
        let others = self.others.iter().position(|it| *it == curve.others);
        (task.unwrap_or(0), others.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::sweep_score::tests::cell_sizes;

    #[track_caller]
    fn check_holds(svg: &str, parts: &[&str]) {
        for part in parts {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
    }

    fn street() -> Extent {
        Extent::Dataset("street".to_owned())
    }

    #[test]
    fn rates_have_units_and_the_best_is_named() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (7, Some(2), None, 0.2)]);
        let svg = rate_plot(&sweep, &street());
        check_holds(&svg, &["street (simulated)", "cell size (m)", "F-rate (%)", "objects", "\n0.4\n"]);
        let recall = cell_sizes(&[(4, None, None, 0.1), (8, None, None, 0.3)]);
        check_holds(&rate_plot(&recall, &street()), &["recall (%)"]);
    }

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
        check_holds(&svg, &["median time of a scan (ms)", "F-rate (%)", "Pareto front"]);
        let untimed = SweepScores { times: Vec::new(), ..sweep };
        assert_eq!(pareto_plot(&untimed, &street()), None);
    }
}
