//! Why detectors are wrong.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{sentences, table};
use super::run_facts::RunFacts;
use crate::rows::error_row::ErrorRow;
use crate::tables::error_table::ErrorTable;
use crate::tables::sheet::Tabular as _;
use crate::vocabulary::task::Task;

/// A table for each task and origin; nothing of runs without a mistake.
pub(super) fn errors(facts: &RunFacts) -> Option<Section> {
    let tasks: Vec<Task> =
        Task::ALL.into_iter().filter(|task| facts.errors.iter().any(|it| it.task == *task)).collect();
    let content = html! {
        @for task in &tasks {
            @for pool in &facts.pools {
                @let is_here = |it: &&ErrorRow| it.task == *task && it.dataset == pool.pool.extent.name();
                @let rows: Vec<&ErrorRow> = facts.errors.iter().filter(is_here).collect();
                @if !rows.is_empty() {
                    (of_task(&format!("Task {task}{}", facts.of_pool(&pool.pool)[1]), &ErrorTable { detectors: facts.detectors(), rows }))
                }
            }
        }
    };
    (!tasks.is_empty()).then(|| Section::new("Errors", "Errors by reason", content))
}

fn of_task(title: &str, errors: &ErrorTable<'_>) -> Markup {
    let sheet = errors.sheet();
    html! {
        h3 { (title) }
        @for sentence in errors.largest_gains() { p.about { (sentence) } }
        @for (idx, part) in sheet.parts.iter().enumerate() {
            @let label = part.title.as_deref().unwrap_or("Errors");
            @if idx == 0 {
                (table(&part.grid, &sheet.notes, &format!("{title}: {label}")))
            } @else if !part.grid.lines.is_empty() {
                details {
                    summary { (label) }
                    (table(&part.grid, &sheet.notes, &format!("{title}: {label}")))
                }
            }
        }
        (sentences(&sheet.notes))
    }
}
