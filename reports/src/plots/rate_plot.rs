//! The plot of the rates of a sweep over its first parameter.

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::sweep_panels::{about_bars, add_curve, curves_of, heading, marks_of};
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::extent::Extent;

/// The rates of `extent` over the first parameter, in percent with 95 % intervals: a panel for each task and each
/// combination of the others, a series for each detector.
///
/// Paper: HG Fig. 6 b.
pub fn rate_plot(sweep: &SweepScores, extent: &Extent) -> String {
    let mut curves = curves_of(sweep, extent);
    curves.sort_by_key(|it| it.first().task);
    let (marks, mut panels) = (marks_of(sweep), Vec::new());
    for curve in &curves {
        let first = curve.first();
        let panel = CurvePanel {
            title: curve.named(first.task.name()),
            ..CurvePanel::over(sweep.axis_title(), format!("{} (%)", first.rate_name()))
        };
        add_curve(&mut panels, panel, curve, marks.mark(&first.subject.detector, 0), 100.0);
    }
    let configured = sweep.configured.as_ref().and_then(|it| it.parse::<f64>().ok());
    if let Some(x) = configured {
        let of_numbers = panels.iter_mut().filter(|it| it.x_words.is_none());
        of_numbers.for_each(|it| it.notes.push(Note::Upright(x, "configured".to_owned())));
    }
    let title = format!("{}. Ring: best. {}", heading(&curves), about_bars(&curves));
    curve_figure(&panels, &title).svg(&title)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::sweep_score::tests::{cell_sizes, street};

    #[test]
    fn rates_have_units_and_the_best_is_named() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (7, Some(2), None, 0.2)]);
        let svg = rate_plot(&sweep, &street());
        check_holds(&svg, &["street (simulated)", "cell size (m)", "F-rate (%)", "objects", ">0.4<"]);
        check_holds(&svg, &[">configured<"]);
        let elsewhere = SweepScores { configured: None, ..sweep };
        assert!(!rate_plot(&elsewhere, &street()).contains(">configured<"));
        let recall = cell_sizes(&[(4, None, None, 0.1), (8, None, None, 0.3)]);
        check_holds(&rate_plot(&recall, &street()), &["recall (%)"]);
    }
}
