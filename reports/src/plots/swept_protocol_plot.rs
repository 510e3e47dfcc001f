//! The plot of the principal numbers of a protocol over the first parameter of a sweep.

use super::curve_panels::{CurvePanel, curve_figure};
use super::series::DetectorMarks;
use super::sweep_panels::add_curve;
use crate::numbers::sweep_curve::axis_title;
use crate::protocols::swept_numbers::{NumberCurve, SweptNumbers};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::protocol::Protocol;

/// The principal numbers under `protocol` on `extent`, with 95 % intervals: a panel for each number and each combination of
/// the other parameters, a series for each detector. `None` if there are none.
pub fn swept_protocol_plot(swept: &SweptNumbers, protocol: Protocol, extent: &Extent) -> Option<String> {
    let is_asked = |it: &NumberCurve<'_>| {
        let first = it.first();
        first.number.protocol == protocol && first.subject.extent == *extent
    };
    let curves: Vec<NumberCurve<'_>> = swept.principal_curves().into_iter().filter(is_asked).collect();
    let title = title(curves.first()?);
    let marks = DetectorMarks::of(swept.numbers.iter().map(|it| it.subject.detector.as_str()));
    let mut panels = Vec::new();
    for curve in &curves {
        let mark = marks.mark(&curve.first().subject.detector, 0);
        add_curve(&mut panels, panel(curve, &swept.parameters), curve, mark, 1.0);
    }
    Some(curve_figure(&panels, &title).svg(&title))
}

fn title(first: &NumberCurve<'_>) -> String {
    let first = first.first();
    let origin = first.subject.origin.in_brackets();
    let caveat = first.number.interval.and_then(|it| it.blocks.caveat());
    let caveat = caveat.map_or_else(String::new, |it| format!(", interval {it}"));
    let (protocol, dataset) = (first.number.protocol, &first.number.dataset);
    format!("{dataset}{origin}, protocol {protocol}. Ring: best. Bars: 95 % intervals{caveat}")
}

fn panel(curve: &NumberCurve<'_>, parameters: &[String]) -> CurvePanel {
    let metric = &curve.first().number.metric;
    CurvePanel {
        title: curve.named(&format!("{} {}", metric.class, metric.id)),
        ..CurvePanel::over(axis_title(parameters), format!("{} ({})", metric.id, metric.unit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::sweep_score::tests::street;
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
