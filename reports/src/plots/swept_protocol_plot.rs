//! The plot of the principal numbers of a protocol over the first parameter of a sweep.

use super::curve_panels::{CurvePanel, Note, NoteShape, curve_figure};
use super::series::{Place, Series};
use crate::numbers::sweep_curve::axis_title;
use crate::protocols::swept_number_curves::{NumberCurve, NumberPoint};
use crate::protocols::swept_numbers::SweptNumbers;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::protocol::Protocol;

/// The principal numbers under `protocol` on `extent`, with 95 % intervals: a panel for each number and each combination of the other
/// parameters, a series for each detector. `None` if there are none.
pub fn swept_protocol_plot(swept: &SweptNumbers, protocol: Protocol, extent: &Extent) -> Option<String> {
    let is_asked = |it: &NumberCurve<'_>| {
        let first = it.first();
        first.number.protocol == protocol && first.subject.extent == *extent
    };
    let curves: Vec<NumberCurve<'_>> = swept.principal_curves().into_iter().filter(is_asked).collect();
    let title = title(curves.first()?);
    let mut panels: Vec<CurvePanel> = Vec::new();
    for curve in &curves {
        let place = panels.iter().position(|it| it.title == panel_title(curve)).unwrap_or_else(|| {
            panels.push(panel(curve, &swept.parameters));
            panels.len() - 1
        });
        add(&mut panels[place], curve);
    }
    Some(curve_figure(&panels, &title).panel(title).document())
}

fn title(first: &NumberCurve<'_>) -> String {
    let first = first.first();
    let origin = match first.subject.origin {
        Origin::Recorded => String::new(),
        origin => format!(" ({})", origin.name()),
    };
    let caveat = first.number.interval.and_then(|it| it.blocks.caveat_of_conclusions());
    let caveat = caveat.map_or_else(String::new, |it| format!(", interval {it}"));
    let (protocol, dataset) = (first.number.protocol, &first.number.dataset);
    format!("{dataset}{origin}, protocol {protocol}. Ring: best. Bars: 95 % intervals{caveat}")
}

fn panel_title(curve: &NumberCurve<'_>) -> String {
    let metric = &curve.first().number.metric;
    [vec![format!("{} {}", metric.class, metric.id)], curve.others.clone()].concat().join(", ")
}

fn panel(curve: &NumberCurve<'_>, parameters: &[String]) -> CurvePanel {
    let is_numeric = curve.points.iter().all(|it| it.x_text.parse::<f64>().is_ok());
    let words = || curve.points.iter().map(|it| it.x_text.to_owned()).collect();
    let metric = &curve.first().number.metric;
    CurvePanel {
        title: panel_title(curve),
        x_title: axis_title(parameters),
        y_title: format!("{} ({})", metric.id, metric.unit),
        x_words: (!is_numeric).then(words),
        ..CurvePanel::default()
    }
}

fn add(panel: &mut CurvePanel, curve: &NumberCurve<'_>) {
    let place = |it: &NumberPoint<'_>| {
        let number = &it.swept.number;
        Some(Place { x: it.x, y: number.value?, within: number.interval.map(|it| it.ends) })
    };
    let places: Vec<Option<Place>> = curve.points.iter().map(place).collect();
    if let Some(best) = curve.best()
        && let Some(at) = places[best]
    {
        let text = curve.points[best].x_text.to_owned();
        panel.notes.push(Note { place: (at.x, at.y), text, shape: NoteShape::Ring });
    }
    panel.series.push(Series { name: curve.first().number.detector.clone(), places });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::{check_holds, street};
    use crate::protocols::swept_numbers::tests::swept;

    #[test]
    fn a_panel_names_the_number_and_its_best_value() {
        let numbers = swept(&[Some(0.25), Some(0.5), Some(0.375)]);
        let svg = swept_protocol_plot(&numbers, Protocol::Nuscenes, &street()).unwrap();
        let parts = [
            "street (simulated), protocol nuscenes",
            "present ap",
            "ap (ratio)",
            "ranked probability",
            ">0.2<",
        ];
        check_holds(&svg, &parts);
        assert!(!svg.contains("ase"));
        assert_eq!(swept_protocol_plot(&numbers, Protocol::Argoverse2, &street()), None);
        assert_eq!(swept_protocol_plot(&numbers, Protocol::Nuscenes, &Extent::Overall), None);
    }
}
