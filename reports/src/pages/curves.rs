//! Precision over recall, where detections have scores.

use maud::html;

use super::document::Section;
use super::markup::{Figure, FigureMarkup};
use crate::facts::run_facts::{DatasetCurves, RunFacts};
use crate::numbers::calibration::{CalibrationBin, calibration_error, calibration_of_scores};
use crate::plots::recall_plot::recall_plot;
use crate::plots::reliability_plot::{LEAST_IN_BIN, reliability_plot};
use crate::plots::series::key_of;
use crate::plots::themed_panel::ThemedPanel;
use crate::verdicts::task_ranking::origin_of_run;
use crate::vocabulary::origin::Origin;

/// The section of curves; `None` if no detection has a score, or false detections are unknown.
pub(super) fn curves(facts: &RunFacts, files: &mut Vec<Figure>) -> Option<Section> {
    if facts.curves.is_empty() {
        return None;
    }
    let has_curve = |name: &str| {
        let mut of_detectors = facts.curves.iter().flat_map(|it| &it.of_detectors);
        of_detectors.any(|(detector, positions)| detector == name && !positions.is_empty())
    };
    let key = key_of(&facts.detectors(), has_curve);
    let is_drawn = |it: &&DatasetCurves| it.of_detectors.iter().any(|(_, positions)| positions.len() > 1);
    let panels: Vec<ThemedPanel> = facts.curves.iter().filter(is_drawn).map(|it| panel(facts, it)).collect();
    let of_curves: Vec<(&DatasetCurves, Calibrations)> =
        facts.curves.iter().map(|it| (it, calibrations(it))).filter(|(_, bins)| is_enough(bins)).collect();
    let reliable: Vec<ThemedPanel> =
        of_curves.iter().map(|(curves, bins)| reliability_plot(&title(facts, curves), bins)).collect();
    let errors: Vec<String> = of_curves
        .iter()
        .map(|(curves, bins)| format!("{}: {}", title(facts, curves), errors_of(bins)))
        .collect();
    let content = html! {
        (FigureMarkup {
            file_stem: "precision_recall",
            title: "Precision over recall",
            panels: &panels,
            key: &key,
            caption: html! {
                "Precision over recall as the score threshold falls, from the most certain detection (left) to all (right end). "
                "Up and to the right is better."
            },
            class: "",
        }.render(files))
        @if !reliable.is_empty() {
            details {
                summary { "Are scores right?" }
        (FigureMarkup {
            file_stem: "reliability",
            title: "How many detections are right, over how many are expected to be",
            panels: &reliable,
            key: &key,
            caption: html! {
                "Detections in bins of the probability that their scores give them, by the share that is right; bins of fewer than "
                "ten are left out. On the diagonal scores are right, below it detectors are too sure. Scores that all lie within "
                "0 to 1 are probabilities, others logarithms of odds. "
                "The mean distance from the diagonal: " (errors.join("; ")) "."
            },
            class: "",
        }.render(files))
            }
        }
    };
    Some(Section::new("Curves", "Precision and recall over scores", content))
}

fn panel(facts: &RunFacts, curves: &DatasetCurves) -> ThemedPanel {
    recall_plot(&title(facts, curves), &curves.of_detectors)
}

/// Detectors, each with its bins.
type Calibrations = Vec<(String, Vec<CalibrationBin>)>;

/// The bins of every detector by the probabilities that its scores give.
fn calibrations(curves: &DatasetCurves) -> Calibrations {
    curves.operating.iter().map(|(name, points)| (name.clone(), calibration_of_scores(points))).collect()
}

/// Whether some detector has enough detections for a bin.
fn is_enough(of_detectors: &Calibrations) -> bool {
    of_detectors.iter().flat_map(|it| &it.1).any(|it| it.n >= LEAST_IN_BIN)
}

/// The calibration error of every detector in percent: its mean distance from the diagonal.
fn errors_of(of_detectors: &[(String, Vec<CalibrationBin>)]) -> String {
    let error = |(name, bins): &(String, Vec<CalibrationBin>)| {
        Some(format!("{name} {:.1} %", 100.0 * calibration_error(bins)?))
    };
    of_detectors.iter().filter_map(error).collect::<Vec<_>>().join(", ")
}

/// Title of a panel: what is detected, on which data set, and whether it is simulated, where others are not.
fn title(facts: &RunFacts, curves: &DatasetCurves) -> String {
    let is_mixed = origin_of_run(&facts.manifest) == Origin::PartlySimulated;
    let is_simulated =
        is_mixed && facts.manifest.datasets.iter().any(|it| it.id == curves.dataset && it.simulated);
    let simulated = if is_simulated { " (simulated)" } else { "" };
    format!("{}, {}{simulated}", curves.task, curves.dataset)
}
