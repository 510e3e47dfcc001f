//! Why detectors are wrong.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{Figure, FigureMarkup, sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::plots::loss_plot::{Losses, loss_plot};
use crate::plots::themed_panel::ThemedPanel;
use crate::rows::error_row::ErrorRow;
use crate::tables::error_table::ErrorTable;
use crate::tables::sheet::Tabular as _;
use crate::vocabulary::task::Task;

/// A table for each task and origin; `None` for runs without a mistake.
pub(super) fn errors(facts: &RunFacts, files: &mut Vec<Figure>) -> Option<Section> {
    let tasks: Vec<Task> =
        Task::ALL.into_iter().filter(|task| facts.errors.iter().any(|it| it.task == *task)).collect();
    let content = html! {
        @for task in &tasks {
            @for pool in &facts.pools {
                @let is_here = |it: &&ErrorRow| it.task == *task && it.dataset == pool.pool.extent.name();
                @let rows: Vec<&ErrorRow> = facts.errors.iter().filter(is_here).collect();
                @if !rows.is_empty() {
                    @let [file_end, on] = facts.of_pool(&pool.pool);
                    @let table = ErrorTable { detectors: facts.detectors(), rows };
                    (of_task(&format!("Task {task}{on}"), &table, &losses(facts, &table, &format!("{task}{file_end}"), files)))
                }
            }
        }
    };
    (!tasks.is_empty()).then(|| Section::new("Errors", "Errors by reason", content))
}

/// Beginning of the names of figures of losses.
const LOSSES: &str = "losses_";

/// Figure of the losses of objects, stage by stage; empty without losses.
fn losses(facts: &RunFacts, errors: &ErrorTable<'_>, stem_end: &str, files: &mut Vec<Figure>) -> Markup {
    let is_first = !files.iter().any(|it| it.file_stem.starts_with(LOSSES));
    let losses = Losses::of(errors, |it| facts.detector_idx(it));
    let panels: Vec<ThemedPanel> = losses.iter().map(loss_plot).collect();
    if panels.is_empty() {
        return html! {};
    }
    FigureMarkup {
        file_stem: &format!("{LOSSES}{stem_end}"),
        title: &format!("Where objects are lost, from annotated to found: {}", stem_end.replace('_', " ")),
        panels: &panels,
        key: &[],
        caption: html! {
            "Where objects are lost: each bar begins where those before it leave off. "
            @if is_first {
                "A miss counts for the stage that dropped most of its points, if more than half of them are in no detection. Only \
                 detectors that record their stages have such bars."
            }
        },
        class: "",
    }
    .render(files)
}

fn of_task(title: &str, errors: &ErrorTable<'_>, losses: &Markup) -> Markup {
    let sheet = errors.sheet();
    html! {
        h3 { (title) }
        (losses)
        details {
            summary { "Missed and false, by reason" }
            @for sentence in errors.largest_gains() { p.about { (sentence) } }
            @for part in sheet.parts.iter().filter(|it| !it.grid.lines.is_empty()) {
                @if let Some(label) = &part.title { p { (label) } }
                @let label = part.title.as_deref().unwrap_or("Errors");
                (table(&part.grid, &sheet.notes, &format!("{title}: {label}")))
            }
            (sentences(&sheet.notes))
        }
    }
}
