//! What the plots of a sweep have in common.

use super::curve_panels::{CurvePanel, Note};
use super::series::Series;
use crate::numbers::sweep_curve::SweepCurve;
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;

/// The curves of `extent`.
pub(crate) fn curves_of<'a>(sweep: &'a SweepScores, extent: &Extent) -> Vec<SweepCurve<'a>> {
    sweep.curves().into_iter().filter(|it| it.first().subject.extent == *extent).collect()
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

/// What bars are, with what is to be said of them.
pub(crate) fn about_bars(curves: &[SweepCurve<'_>]) -> String {
    let caveat = curves.first().and_then(|it| it.first().blocks.caveat_of_conclusions());
    caveat.map_or_else(|| "Bars: 95 % intervals".to_owned(), |it| format!("Bars: 95 % intervals {it}"))
}

/// What stands on the axis where these values are no numbers.
pub(crate) fn words<'a>(values: impl Iterator<Item = &'a str> + Clone) -> Option<Vec<String>> {
    let is_numeric = values.clone().all(|it| it.parse::<f64>().is_ok());
    (!is_numeric).then(|| values.map(str::to_owned).collect())
}

/// Adds `series` to the one of `panels` that has the title of `panel`, or to `panel`, with a ring around its best position.
pub(crate) fn add_series(
    panels: &mut Vec<CurvePanel>,
    panel: CurvePanel,
    series: Series,
    best: Option<(usize, &str)>,
) {
    let panel_idx = panels.iter().position(|it| it.title == panel.title).unwrap_or_else(|| {
        panels.push(panel);
        panels.len() - 1
    });
    let panel = &mut panels[panel_idx];
    if let Some((best, text)) = best {
        panel.notes.extend(series.positions[best].map(|at| Note::Ring((at.x, at.y), text.to_owned())));
    }
    panel.series.push(series);
}
