//! What the plots of a sweep have in common.

use crate::numbers::sweep_curve::SweepCurve;
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;

/// The curves of `extent`.
pub(crate) fn curves_of<'a>(sweep: &'a SweepScores, extent: &Extent) -> Vec<SweepCurve<'a>> {
    sweep.curves().into_iter().filter(|it| it.points[0].score.subject.extent == *extent).collect()
}

/// Data set, and whether it is simulated.
pub(crate) fn heading(curves: &[SweepCurve<'_>]) -> String {
    let Some(first) = curves.first() else { return "nothing".to_owned() };
    let subject = &first.points[0].score.subject;
    let name = match &subject.extent {
        Extent::Dataset(id) => id,
        Extent::Overall => "all data sets",
        Extent::OverallOf(Origin::Recorded) => "all recorded data sets",
        Extent::OverallOf(_) => "all simulated data sets",
    };
    match subject.origin {
        _ if matches!(subject.extent, Extent::OverallOf(_)) => name.to_owned(),
        Origin::Recorded => name.to_owned(),
        origin => format!("{name} ({})", origin.name()),
    }
}

/// What bars are, with what is to be said of them.
pub(crate) fn about_bars(curves: &[SweepCurve<'_>]) -> String {
    let caveat = curves.first().and_then(|it| it.points[0].score.blocks.caveat_of_conclusions());
    caveat.map_or_else(|| "Bars: 95 % intervals".to_owned(), |it| format!("Bars: 95 % intervals {it}"))
}

/// What stands on the axis where the values are no numbers.
pub(crate) fn words(curve: &SweepCurve<'_>) -> Option<Vec<String>> {
    let is_numeric = curve.points.iter().all(|it| it.x_text.parse::<f64>().is_ok());
    (!is_numeric).then(|| curve.points.iter().map(|it| it.x_text.to_owned()).collect())
}
