//! How far detectors agree where nothing is labelled.

use maud::html;

use super::document::Section;
use super::markup::titled_tables;
use crate::facts::run_facts::RunFacts;
use crate::tables::agreement_table::AgreementOfDetectors;
use crate::tables::sheet::Tabular as _;

/// The section of agreement; `None` if everything is labelled.
pub(super) fn agreement(facts: &RunFacts) -> Option<Section> {
    if facts.agreement.is_empty() {
        return None;
    }
    let sheet = AgreementOfDetectors { rows: &facts.agreement }.sheet();
    let content = html! {
        p.about { "The scans have no labels, so there are no scores." }
        (titled_tables(&sheet, "Agreement"))
        @if !facts.recording_folders.is_empty() {
            p { "What only one detector sees shows in the recording, where all stand side by side: " code { "rerun " (facts.recording_folders.join(" ")) } }
        }
    };
    Some(Section::new("Agreement", "Where detectors agree", content))
}
