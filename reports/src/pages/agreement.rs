//! How far detectors agree where nothing is labelled.

use maud::{Markup, html};

use super::markup::{sentences, table};
use super::run_facts::RunFacts;
use crate::tables::agreement_table::AgreementOfDetectors;
use crate::tables::sheet::Tabular as _;

/// Nothing where everything is labelled.
pub(super) fn agreement(facts: &RunFacts) -> Markup {
    if facts.agreement.is_empty() {
        return html! {};
    }
    let sheet = AgreementOfDetectors { rows: &facts.agreement }.sheet();
    html! {
        section #agreement aria-labelledby="agreement-title" {
            h2 #agreement-title { "Where detectors agree" }
            p.about { "The scans have no labels, so there are no scores." }
            @for part in &sheet.parts {
                @let title = part.title.as_deref().unwrap_or("Agreement");
                h3 { (title) }
                (table(&part.grid, &sheet.notes, title))
            }
            (sentences(&sheet.notes))
            @if facts.has_recording {
                p { "What only one detector sees shows in the recording, where all stand side by side: " code { "rerun run.rrd" } }
            }
        }
    }
}
