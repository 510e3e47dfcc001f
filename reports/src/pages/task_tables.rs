//! The papers' tables, with the papers' figures beside ours, and the counts that they are made of.

use maud::html;

use super::document::Section;
use super::markup::{sentences, table};
use crate::tables::notes::about_matching;
use crate::tables::sheet::Tabular as _;
use crate::tables::task_table::TaskTable;

pub(super) fn task_tables(tables: &[TaskTable]) -> Section {
    let content = html! {
        @for task in tables {
            @let sheet = task.sheet();
            h3 { "Task " (task.task) }
            p.about { "Rates in %. " (about_matching(&task.matching_criterion)) }
            @if let [main, counts] = &sheet.parts[..] {
                (table(&main.grid, &sheet.notes, &format!("Task {}: rates and speeds", task.task)))
                details {
                    summary { "Counts" }
                    (table(&counts.grid, &sheet.notes, &format!("Task {}: counts", task.task)))
                }
            }
            (sentences(&sheet.notes))
        }
    };
    Section::new("Tables", "Found, missed and false", content)
}
