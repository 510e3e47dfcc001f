//! The numbers under protocols of others.

use maud::{Markup, html};

use super::markup::{sentences, table};
use super::run_facts::RunFacts;
use crate::tables::protocol_table::{ProtocolLines, ProtocolTable};
use crate::tables::sheet::Tabular as _;

/// Nothing where the run was evaluated under none.
pub(super) fn protocols(facts: &RunFacts) -> Markup {
    let Some(report) = &facts.protocols else { return html! {} };
    let tables = ProtocolTable::all(report, &facts.manifest, ProtocolLines::Every);
    html! {
        section #protocols aria-labelledby="protocols-title" {
            h2 #protocols-title { "Protocols of others" }
            p.about { "The numbers that the makers' own programs give, with intervals." }
            @for it in &tables {
                @let sheet = it.sheet();
                h3 { "Protocol " (it.protocol) }
                @for part in &sheet.parts {
                    (table(&part.grid, &sheet.notes, &format!("Protocol {}", it.protocol)))
                }
                (sentences(&sheet.notes))
            }
        }
    }
}
