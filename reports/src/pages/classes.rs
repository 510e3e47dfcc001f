//! Classes that detectors give, and slices of the user.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::tables::class_table::ClassTable;
use crate::tables::sheet::Tabular;

/// The rates, and what is said less often in a fold.
fn of_data_sets(classes: &ClassTable) -> Markup {
    let sheet = classes.sheet();
    html! {
        @for sentence in classes.sentences() { p.about { (sentence) } }
        @if let Some((rates, rest)) = sheet.parts.split_first() {
            (table(&rates.grid, &sheet.notes, rates.title.as_deref().unwrap_or("Classes")))
            details {
                summary { "By range, and which class is taken for which" }
                @for part in rest {
                    @let title = part.title.as_deref().unwrap_or("Classes");
                    h3 { (title) }
                    (table(&part.grid, &sheet.notes, title))
                }
            }
        }
        (sentences(&sheet.notes))
    }
}

/// The rates of each class, and which classes are taken for which; `None` if no detector gives classes.
pub(super) fn classes(facts: &RunFacts) -> Option<Section> {
    let is_of_pool = |it: &ClassTable| facts.pools.iter().any(|pool| pool.pool.extent.name() == it.dataset);
    let content = html! {
        @for pool in &facts.pools {
            @for classes in facts.classes.iter().filter(|it| it.dataset == pool.pool.extent.name()) {
                @let [_, on] = facts.of_pool(&pool.pool);
                @if !on.is_empty() { h3 { (on.trim_start_matches(", ")) } }
                (of_data_sets(classes))
            }
        }
        @if facts.classes.iter().any(|it| !is_of_pool(it)) {
            details {
                summary { "Each data set" }
                @for classes in facts.classes.iter().filter(|it| !is_of_pool(it)) {
                    h3 { (classes.dataset) }
                    (of_data_sets(classes))
                }
            }
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
