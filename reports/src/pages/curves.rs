//! Precision over recall, where detections have scores.

use maud::html;

use super::document::Section;
use super::markup::{Figure, FigureMarkup};
use super::run_facts::{DatasetCurves, RunFacts};
use crate::plots::recall_plot::recall_plot;
use crate::plots::series::key_of;
use crate::plots::themed_panel::ThemedPanel;

/// Nothing if no detection has a score, or false ones are unknown.
pub(super) fn curves(facts: &RunFacts, files: &mut Vec<Figure>) -> Option<Section> {
    if facts.curves.is_empty() {
        return None;
    }
    let has_curve = |name: &str| {
        let mut of_detectors = facts.curves.iter().flat_map(|it| &it.of_detectors);
        of_detectors.any(|(detector, positions)| detector == name && !positions.is_empty())
    };
    let key = key_of(&facts.detectors(), has_curve);
    let panels: Vec<ThemedPanel> = facts.curves.iter().map(|it| panel(facts, it)).collect();
    let content = html! {
        (FigureMarkup {
            file_stem: "precision_recall",
            title: "Precision over recall of vehicles",
            panels: &panels,
            key: &key,
            caption: html! {
                "Precision over recall as the score threshold falls, from the most certain vehicle (left) to all (right end). "
                "Up and to the right is better."
            },
            class: "",
        }.render(files))
    };
    Some(Section::new("Curves", "Precision and recall of vehicles", content))
}

fn panel(facts: &RunFacts, curves: &DatasetCurves) -> ThemedPanel {
    let is_simulated = facts.manifest.datasets.iter().any(|it| it.id == curves.dataset && it.simulated);
    let title = if is_simulated { format!("{} (simulated)", curves.dataset) } else { curves.dataset.clone() };
    recall_plot(&title, &curves.of_detectors)
}
