//! The numbers under protocols of others.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::tables::protocol_table::{ProtocolLines, ProtocolTable};
use crate::tables::sheet::Tabular as _;

/// The section of protocols; `None` if the run was evaluated under none.
pub(super) fn protocols(facts: &RunFacts) -> Option<Section> {
    let report = facts.protocols.as_ref()?;
    let [short, every] = [ProtocolLines::Short, ProtocolLines::Every]
        .map(|it| ProtocolTable::all(report, &facts.manifest, it));
    let content = html! {
        p.about { "The numbers that the makers' own programs give." }
        @for (short, every) in short.iter().zip(&every) {
            h3 { "Protocol " (short.protocol) }
            @for pool in &facts.pools {
                @let label = format!("Protocol {}{}", short.protocol, facts.of_pool(&pool.pool)[1]);
                @let sheet = short.sheet();
                (table(&short.values_of(&pool.pool), &sheet.notes, &label))
            }
            @if let Some(published) = short.protocol.published() { p.about { (published) } }
            details { summary { "Each data set, with intervals" } (grids(short)) }
            @if short.is_short() {
                details { summary { "All numbers" } (grids(every)) }
            }
        }
    };
    Some(Section::new("Protocols", "Protocols of others", content))
}

fn grids(table_of_protocol: &ProtocolTable<'_>) -> Markup {
    let sheet = table_of_protocol.sheet();
    html! {
        @for part in &sheet.parts {
            (table(&part.grid, &sheet.notes, &format!("Protocol {}", table_of_protocol.protocol)))
        }
        (sentences(&sheet.notes))
    }
}
