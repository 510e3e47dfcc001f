//! The plot of the rates of a sweep over its first parameter.

use std::collections::BTreeMap;

use super::curve_panels::{CurvePanel, Note, NoteShape, curve_figure};
use super::series::{Place, Series};
use super::sweep_panels::{about_bars, curves_of, heading, words};
use crate::numbers::sweep_curve::{CurvePoint, SweepCurve};
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::task::Task;

/// The rates of `extent` over the first parameter, in percent with 95 % intervals: a panel for each task and each
/// combination of the others, a series for each detector.
///
/// Paper: HG Fig. 6 b.
pub fn rate_plot(sweep: &SweepScores, extent: &Extent) -> String {
    let curves = curves_of(sweep, extent);
    let mut panels: BTreeMap<(usize, usize), CurvePanel> = BTreeMap::new();
    let places = PanelPlaces::of(&curves);
    for curve in &curves {
        let first = curve.points[0].score;
        let panel = panels.entry(places.of_curve(curve)).or_insert_with(|| CurvePanel {
            title: [vec![first.task.name().to_owned()], curve.others.clone()].concat().join(", "),
            x_title: sweep.axis_title(),
            y_title: format!("{} (%)", first.rate_name()),
            x_words: words(curve),
            ..CurvePanel::default()
        });
        let place = |it: &CurvePoint<'_>| {
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
    let title = format!("{}. Ring: best. {}", heading(&curves), about_bars(&curves));
    curve_figure(&panels.into_values().collect::<Vec<_>>(), &title).panel(title).document()
}

/// Tasks from above, and for each the combinations of other parameters.
struct PanelPlaces {
    tasks: Vec<Task>,
    others: Vec<Vec<String>>,
}

impl PanelPlaces {
    fn of(curves: &[SweepCurve<'_>]) -> Self {
        let mut places = Self { tasks: Vec::new(), others: Vec::new() };
        for curve in curves {
            let task = curve.points[0].score.task;
            if !places.tasks.contains(&task) {
                places.tasks.push(task);
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
    use crate::numbers::sweep_score::tests::{cell_sizes, check_holds, street};

    #[test]
    fn rates_have_units_and_the_best_is_named() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (7, Some(2), None, 0.2)]);
        let svg = rate_plot(&sweep, &street());
        check_holds(&svg, &["street (simulated)", "cell size (m)", "F-rate (%)", "objects", ">0.4<"]);
        let recall = cell_sizes(&[(4, None, None, 0.1), (8, None, None, 0.3)]);
        check_holds(&rate_plot(&recall, &street()), &["recall (%)"]);
    }
}
