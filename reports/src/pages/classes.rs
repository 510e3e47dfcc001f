//! Classes that detectors give.

use maud::html;

use super::document::Section;
use super::markup::{sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::tables::sheet::Tabular as _;

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
