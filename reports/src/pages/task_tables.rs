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
            details {
                summary { "Task " (task.task) ": rates, speeds and counts" }
                p.about { "Rates in %. " (about_matching(&task.matching_criterion)) }
                @for (part, what) in sheet.parts.iter().zip(["rates and speeds", "counts"]) {
                    (table(&part.grid, &sheet.notes, &format!("Task {}: {what}", task.task)))
                }
                (sentences(&sheet.notes))
            }
        }
    };
    Section::new("Tables", "Each data set", content)
}
