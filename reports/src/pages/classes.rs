//! Classes that detectors give, and slices of the user.

use maud::html;

use super::document::Section;
use super::markup::{sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::tables::sheet::Tabular;

/// The rates of each class, and which classes are taken for which; `None` if no detector gives classes.
pub(super) fn classes(facts: &RunFacts) -> Option<Section> {
    let content = html! {
        @for classes in &facts.classes {
            @let sheet = classes.sheet();
            @for sentence in classes.sentences() { p.about { (sentence) } }
            @for part in &sheet.parts {
                @let title = part.title.as_deref().unwrap_or("Classes");
                h3 { (title) }
                (table(&part.grid, &sheet.notes, title))
            }
            (sentences(&sheet.notes))
        }
    };
    (!facts.classes.is_empty()).then(|| Section::new("Classes", "Each class by itself", content))
}

/// The slices of the user; `None` if there are none.
pub(super) fn slices(facts: &RunFacts) -> Option<Section> {
    let content = html! {
        @for sheet in facts.slices.iter().map(Tabular::sheet) {
            @for part in &sheet.parts {
                @let title = part.title.as_deref().unwrap_or("Slices");
                h3 { (title) }
                (table(&part.grid, &sheet.notes, title))
            }
            (sentences(&sheet.notes))
        }
    };
    (!facts.slices.is_empty()).then(|| Section::new("Slices", "Slices of your own", content))
}
