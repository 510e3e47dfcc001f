//! Plots of the classification of partly seen objects.

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::figure::Figure;
use super::marks::SeriesMark;
use super::series::{Position, Series};
use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::vocabulary::partial_class::PartialClass;

/// The mean errors of each class to every class over the steps, a panel for each class of the objects. The upright line is
/// at the first step at which all of them could be judged.
///
/// Paper: BG Figs. 4 to 7.
pub fn partial_error_plot(curve: &PartialCurve, title: &str) -> Figure {
    let there = |class: &PartialClass| curve.steps.iter().any(|it| it.classes.contains_key(class));
    let panels = PartialClass::LEARNT.into_iter().filter(there).map(|of| {
        let series = (0..).map(SeriesMark).zip(PartialClass::LEARNT).map(|(mark, to)| Series {
            name: format!("to {}", to.name()),
            mark,
            positions: positions(curve, |step| Some((step.classes.get(&of)?.mean_error(to)?, None))),
        });
        let note = |step: u32| Note::Upright(f64::from(step), "all judged".to_owned());
        let notes = curve.first_step_all_judged(of).map(note).into_iter().collect();
        CurvePanel {
            title: format!("objects that are: {}", of.name()),
            series: series.collect(),
            notes,
            ..CurvePanel::over("step", "mean L1 error")
        }
    });
    curve_figure(&panels.collect::<Vec<_>>(), title)
}

/// The mean of recalls over the steps with its interval over objects: a series for each curve, at most four of one data set
/// and direction to a panel.
pub fn partial_accuracy_plot(curves: &[PartialCurve], title: &str) -> Figure {
    let of_same = |a: &PartialCurve, b: &PartialCurve| (&a.data, &a.direction) == (&b.data, &b.direction);
    let panels = curves.chunk_by(of_same).flat_map(|same| same.chunks(4)).map(|few| {
        let series = (0..).map(SeriesMark).zip(few).map(|(mark, curve)| Series {
            name: format!("{} ({})", curve.method, curve.trained_on),
            mark,
            positions: positions(curve, |step| {
                Some((100.0 * step.mean_recall?, step.within.map(|it| it.ends.map(|end| 100.0 * end))))
            }),
        });
        let series: Vec<Series> = series.collect();
        let names: Vec<&str> = series.iter().map(|it| it.name.as_str()).collect();
        let title = format!("{} from {}: {}", few[0].data, few[0].direction, names.join(", "));
        CurvePanel {
            title,
            series,
            y_range: Some([0.0, 100.0]),
            ..CurvePanel::over("step", "mean of recalls (%)")
        }
    });
    curve_figure(&panels.collect::<Vec<_>>(), title)
}

/// Share of predicted classes that were right over their chance; on the thin line both are equal.
pub fn partial_calibration_plot(curves: &[PartialCurve], title: &str) -> Figure {
    let panels = curves.iter().filter(|it| !it.calibration.is_empty()).map(|curve| {
        let position = |&(chance, right, _): &(f64, f64, u64)| {
            Some(Position { x: 100.0 * chance, y: 100.0 * right, within: None })
        };
        let series = Series {
            name: curve.method.clone(),
            mark: SeriesMark(0),
            positions: curve.calibration.iter().map(position).collect(),
        };
        CurvePanel {
            title: format!(
                "{} from {}, {} ({})",
                curve.data, curve.direction, curve.method, curve.trained_on
            ),
            series: vec![series],
            thread: vec![(0.0, 0.0), (100.0, 100.0)],
            y_range: Some([0.0, 100.0]),
            ..CurvePanel::over("chance of the predicted class (%)", "share that was right (%)")
        }
    });
    curve_figure(&panels.collect::<Vec<_>>(), title)
}

fn positions(
    curve: &PartialCurve,
    value: impl Fn(&PartialStep) -> Option<(f64, Option<[f64; 2]>)>,
) -> Vec<Option<Position>> {
    let position = |step: &PartialStep| {
        let (y, within) = value(step)?;
        Some(Position { x: f64::from(step.step), y, within })
    };
    curve.steps.iter().map(position).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::partial_study::partial_curves::tests::rows;

    #[test]
    fn every_class_has_a_panel_and_every_axis_a_unit() {
        let curves = PartialCurve::all(&rows());
        let errors = partial_error_plot(&curves[0], "Errors (simulated)").svg("Errors");
        check_holds(
            &errors,
            &[
                "objects that are: tree",
                "objects that are: pole",
                "to pedestrian",
                "mean L1 error",
                "all judged",
                "Errors (simulated)",
            ],
        );
        check_holds(
            &partial_accuracy_plot(&curves, "Accuracy").svg("Accuracy"),
            &["mean of recalls (%)", "street from below"],
        );
        check_holds(
            &partial_calibration_plot(&curves, "Calibration").svg("Calibration"),
            &["chance of the predicted class (%)"],
        );
    }

    #[test]
    fn nothing_can_be_drawn() {
        for svg in [partial_accuracy_plot(&[], "Nothing"), partial_calibration_plot(&[], "Nothing")] {
            assert!(svg.svg("Nothing").contains("</svg>"));
        }
    }
}
