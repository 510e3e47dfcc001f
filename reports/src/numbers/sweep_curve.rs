//! The points of a sweep as curves over its first parameter.

use crate::numbers::blocks::Interval;
use crate::numbers::sweep_score::{SweepScore, SweepScores, SweepSubject, SweepTime};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::Direction;

/// A number at a point of a sweep.
pub trait Reached {
    /// Point, extent, sensor and detector of the number.
    fn subject(&self) -> &SweepSubject;

    /// Names of the number beside its subject, such as task and rate.
    fn about(&self) -> Vec<&str>;

    /// The number; `None` if it is undefined.
    fn value(&self) -> Option<f64>;

    /// Its interval; `None` if there is none.
    fn interval(&self) -> Option<Interval>;

    /// Whether higher or lower is better.
    fn direction(&self) -> Direction;
}

impl Reached for SweepScore {
    fn subject(&self) -> &SweepSubject {
        &self.subject
    }

    fn about(&self) -> Vec<&str> {
        vec![self.task.name(), self.rate_name()]
    }

    fn value(&self) -> Option<f64> {
        self.rate()
    }

    fn interval(&self) -> Option<Interval> {
        self.rate_within().map(|ends| Interval { ends, blocks: self.blocks })
    }

    fn direction(&self) -> Direction {
        Direction::HigherIsBetter
    }
}

/// Numbers over the values of the first parameter, all other parameters being the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve<'a, T> {
    /// The other swept parameters, as `name = value`.
    pub others: Vec<String>,
    /// Points, one for each value of the first parameter, at least one.
    pub points: Vec<CurvePoint<'a, T>>,
}

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint<'a, T> {
    /// The value of the first parameter as a number; its index if not all values are numbers.
    pub x: f64,
    /// The value as it is written.
    pub x_text: &'a str,
    /// The number at this point.
    pub reached: &'a T,
}

/// Rates of one detector in one task.
pub type SweepCurve<'a> = Curve<'a, SweepScore>;

impl<'a, T: Reached> Curve<'a, T> {
    /// The number at the first point.
    pub fn first(&self) -> &'a T {
        self.points[0].reached
    }

    /// The point with the best value, the first of several; `None` without a value, or if neither direction is better.
    pub fn best(&self) -> Option<&CurvePoint<'a, T>> {
        self.extreme(1.0)
    }

    /// The point with the worst value.
    pub(crate) fn worst(&self) -> Option<&CurvePoint<'a, T>> {
        self.extreme(-1.0)
    }

    fn extreme(&self, sign: f64) -> Option<&CurvePoint<'a, T>> {
        let sign = match self.first().direction() {
            Direction::HigherIsBetter => sign,
            Direction::LowerIsBetter => -sign,
            Direction::Neither => return None,
        };
        highest(self.points.iter().map(|it| Some(sign * it.reached.value()?))).map(|it| &self.points[it])
    }

    /// `name` with the other swept parameters behind it.
    pub(crate) fn named(&self, name: &str) -> String {
        [&[name.to_owned()], &self.others[..]].concat().join(", ")
    }
}

/// Curves of the numbers `reached` at points of a sweep, in the order of their first points: one for each extent, detector
/// and [`Reached::about`], and each combination of the other swept parameters among the first `n_swept` of `parameters`.
pub(crate) fn curves<'a, T: Reached>(
    parameters: &[String],
    n_swept: usize,
    reached: impl Iterator<Item = &'a T> + Clone,
) -> Vec<Curve<'a, T>> {
    let is_numeric = reached.clone().all(|it| number(&it.subject().values[0]).is_some());
    let mut curves: Vec<Curve<'a, T>> = Vec::new();
    for reached in reached {
        let SweepSubject { extent, detector, values, .. } = reached.subject();
        let swept = parameters.iter().zip(values).take(n_swept).skip(1);
        let others: Vec<String> = swept.map(|(name, value)| format!("{} = {value}", short(name))).collect();
        let is_same = |it: &Curve<'_, T>| {
            let first = it.first().subject();
            (&first.detector, &first.extent, &it.others) == (detector, extent, &others)
                && it.first().about() == reached.about()
        };
        let index = curves.iter().position(is_same).unwrap_or_else(|| {
            curves.push(Curve { others, points: Vec::new() });
            curves.len() - 1
        });
        let (x_text, points) = (values[0].as_str(), &mut curves[index].points);
        let x = number(x_text).filter(|_| is_numeric).unwrap_or(points.len() as f64);
        points.push(CurvePoint { x, x_text, reached });
    }
    curves
}

impl SweepScores {
    /// The curves of all extents, detectors and tasks, in this order.
    pub fn curves(&self) -> Vec<SweepCurve<'_>> {
        curves(&self.parameters, self.n_swept, self.scores.iter())
    }

    /// Times at `subject`; `None` if it was not timed.
    pub fn time_of(&self, subject: &SweepSubject) -> Option<&SweepTime> {
        self.times.iter().find(|it| it.subject == *subject)
    }

    /// The extents, in the order of the rows.
    pub fn extents(&self) -> Vec<&Extent> {
        let mut extents: Vec<&Extent> = self.scores.iter().map(|it| &it.subject.extent).collect();
        extents.dedup();
        extents
    }

    /// The last part of the name of the first parameter, with its unit.
    pub fn axis_title(&self) -> String {
        axis_title(&self.parameters)
    }
}

/// The last part of the name of the first of the swept `parameters`, with its unit.
pub(crate) fn axis_title(parameters: &[String]) -> String {
    let name = short(&parameters[0]);
    let units = [("_m", "m"), ("_deg", "degrees")];
    let with_unit = units.iter().find_map(|(ending, unit)| {
        let bare = name.strip_suffix(ending)?;
        Some(format!("{} ({unit})", bare.replace('_', " ")))
    });
    with_unit.unwrap_or_else(|| name.replace('_', " "))
}

/// A value as a finite number; `None` if it is none.
fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|it: &f64| it.is_finite())
}

/// The last part of a full name.
fn short(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

impl SweepCurve<'_> {
    /// Whether every point has cells, and these are not all of one size.
    pub fn sweeps_cells(&self) -> bool {
        let sizes: Option<Vec<f64>> =
            self.points.iter().map(|it| it.reached.cells.as_ref().map(|it| it.cell_size_m)).collect();
        sizes.is_some_and(|sizes| sizes.iter().any(|it| *it != sizes[0]))
    }
}

/// Index of the highest value, the first of several; `None` without any value.
pub(crate) fn highest(values: impl Iterator<Item = Option<f64>>) -> Option<usize> {
    let defined = values.enumerate().filter_map(|(index, value)| Some((index, value?)));
    let higher = |best: (usize, f64), it: (usize, f64)| if it.1 > best.1 { it } else { best };
    defined.reduce(higher).map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::cell_sizes;

    #[test]
    fn a_sweep_of_one_parameter_is_one_curve_for_each_detector_and_task() {
        let mut sweep =
            cell_sizes(&[(5, Some(5), None, 0.1), (8, Some(1), None, 0.2), (8, Some(1), None, 0.3)]);
        let mut vehicles: Vec<SweepScore> = sweep.scores.clone();
        for it in &mut vehicles {
            it.task = crate::vocabulary::task::Task::Vehicles;
        }
        sweep.scores.extend(vehicles);
        let curves = sweep.curves();
        assert_eq!(curves.len(), 2);
        let xs: Vec<f64> = curves[0].points.iter().map(|it| it.x).collect();
        assert_eq!(xs, [0.2, 0.4, 0.6]);
        assert!(curves[0].points.iter().all(|it| sweep.time_of(&it.reached.subject).is_some()));
        // The first of two equally good points.
        assert_eq!(curves[0].best().map(|it| it.x_text), Some("0.4"));
        assert!(curves[0].sweeps_cells());
        assert_eq!(sweep.axis_title(), "cell size (m)");
    }

    #[test]
    fn other_parameters_make_other_curves_and_words_have_indices() {
        let mut sweep = cell_sizes(&[(5, Some(5), None, 0.1), (8, Some(1), None, 0.2)]);
        sweep.parameters = vec!["kd_tree.foreground".to_owned(), "hierarchical.grid.xi".to_owned()];
        sweep.n_swept = 2;
        let mut scores = Vec::new();
        for (foreground, xi) in [("short", "2"), ("short", "3"), ("all", "2"), ("all", "3")] {
            let mut score = sweep.scores[0].clone();
            score.subject.values = vec![foreground.to_owned(), xi.to_owned()];
            scores.push(score);
        }
        sweep.scores = scores;
        let curves = sweep.curves();
        assert_eq!(curves.iter().map(|it| it.others.join(", ")).collect::<Vec<_>>(), ["xi = 2", "xi = 3"]);
        assert_eq!(
            curves[1].points.iter().map(|it| (it.x, it.x_text)).collect::<Vec<_>>(),
            [(0.0, "short"), (1.0, "all")]
        );
        assert!(!curves[0].sweeps_cells());
        assert_eq!(sweep.axis_title(), "foreground");
    }
}
