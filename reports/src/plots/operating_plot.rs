//! The plot of the rates of a classifier as its threshold falls.

use super::figure::{Axis, Chart, Figure, LEFT_PX, Panel};
use super::marks::{Mark, SeriesMark};
use crate::numbers::operating_curve::OperatingRow;

/// The plot as an SVG document: the receiver operating characteristic on the left, precision over recall on the right.
/// `title` names the judged data.
pub fn operating_plot(rows: &[OperatingRow], title: &str) -> String {
    // A classifier that classifies nothing as a vehicle has recall 0 and makes no mistake.
    let roc = std::iter::once((0.0, 0.0)).chain(rows.iter().filter_map(OperatingRow::roc_position));
    let precision_recall = rows.iter().filter_map(OperatingRow::precision_recall_position);
    let panels =
        vec![panel(roc, ["false-positive rate", "recall"]), panel(precision_recall, ["recall", "precision"])];
    let heading = vec![Mark::title(title, (LEFT_PX, 20.0))];
    Figure { width_px: 900, heading_px: 40, heading, rows: vec![(440, panels)] }.svg(title)
}

fn panel(positions: impl Iterator<Item = (f64, f64)>, names: [&str; 2]) -> Panel {
    let [x, y] = names.map(|it| Axis::linear(it, [-0.01, 1.01], 6));
    Chart::new(x, y, vec![SeriesMark(0).line(positions)]).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    #[test]
    fn both_panels_have_axes_and_the_title_says_what_was_judged() {
        let rows = [([1, 0], 0.5), ([1, 2], -0.5)]
            .map(|(predicted, threshold)| OperatingRow::new(threshold, predicted, [1, 2]));
        let svg = operating_plot(&rows, "Held out (simulated)");
        check_holds(&svg, &["false-positive rate", "recall", "precision", "Held out (simulated)"]);
        assert_ne!(svg, operating_plot(&[], "Held out (simulated)"));
    }
}
