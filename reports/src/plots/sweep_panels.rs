//! Shared parts of the plots of a sweep.

use super::curve_panels::{CurvePanel, Note};
use super::marks::SeriesMark;
use super::series::{DetectorMarks, Position, Series};
use crate::numbers::sweep_curve::{Curve, CurvePoint, Reached, SweepCurve};
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;

/// The curves of `extent`.
pub(crate) fn curves_of<'a>(sweep: &'a SweepScores, extent: &Extent) -> Vec<SweepCurve<'a>> {
    sweep.curves().into_iter().filter(|it| it.first().subject.extent == *extent).collect()
}

/// The marks of the detectors of a sweep.
pub(crate) fn marks_of(sweep: &SweepScores) -> DetectorMarks<'_> {
    DetectorMarks::of(sweep.scores.iter().map(|it| it.subject.detector.as_str()))
}

/// Data set, and whether it is simulated.
pub(crate) fn heading(curves: &[SweepCurve<'_>]) -> String {
    let Some(first) = curves.first() else { return "nothing".to_owned() };
    let subject = &first.first().subject;
    let name = match &subject.extent {
        Extent::Dataset(id) => id,
        Extent::Overall => "all data sets",
        Extent::OverallOf(Origin::Recorded) => "all recorded data sets",
        Extent::OverallOf(_) => "all simulated data sets",
    };
    match subject.extent {
        Extent::OverallOf(_) => name.to_owned(),
        _ => format!("{name}{}", subject.origin.in_brackets()),
    }
}

/// The meaning of bars, with the caveat of their intervals.
pub(crate) fn about_bars(curves: &[SweepCurve<'_>]) -> String {
    let caveat = curves.first().and_then(|it| it.first().blocks.caveat());
    caveat.map_or_else(|| "Bars: 95 % intervals".to_owned(), |it| format!("Bars: 95 % intervals {it}"))
}

/// Labels of an axis with these values; `None` if all are numbers.
pub(crate) fn words<'a>(values: impl Iterator<Item = &'a str> + Clone) -> Option<Vec<String>> {
    let is_numeric = values.clone().all(|it| it.parse::<f64>().is_ok());
    (!is_numeric).then(|| values.map(str::to_owned).collect())
}

/// Adds `curve` to the one of `panels` with the title of `panel`, or else adds `panel`. The curve is drawn as `mark`, with
/// values `scale` times as large, and a ring around its best position.
pub(crate) fn add_curve<T: Reached>(
    panels: &mut Vec<CurvePanel>,
    panel: CurvePanel,
    curve: &Curve<'_, T>,
    mark: SeriesMark,
    scale: f64,
) {
    let position = |it: &CurvePoint<'_, T>| {
        let within = it.reached.interval().map(|it| it.ends.map(|end| scale * end));
        Some(Position { x: it.x, y: scale * it.reached.value()?, within })
    };
    let panel_idx = panels.iter().position(|it| it.title == panel.title).unwrap_or_else(|| {
        panels.push(CurvePanel { x_words: words(curve.points.iter().map(|it| it.x_text)), ..panel });
        panels.len() - 1
    });
    let panel = &mut panels[panel_idx];
    let best = curve.best().and_then(|it| Some((position(it)?, it.x_text.to_owned())));
    panel.notes.extend(best.map(|(at, text)| {
        // The text stands above the interval.
        Note::Ring { at: (at.x, at.y), top: at.within.map_or(at.y, |it| it[1]), text }
    }));
    let name = curve.first().subject().detector.clone();
    panel.series.push(Series { name, mark, positions: curve.points.iter().map(position).collect() });
}
