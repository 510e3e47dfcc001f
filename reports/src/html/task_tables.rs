//! The papers' tables, with the papers' figures beside ours, and the counts they are made of.

use maud::{Markup, html};

use super::markup::{sentences, table};
use crate::table::notes::notes;
use crate::table::task_grids::{counts_grid, main_grid};
use crate::table::task_table::TaskTable;

pub(super) fn task_tables(tables: &[TaskTable]) -> Markup {
    html! {
        section #tables aria-labelledby="tables-title" {
            h2 #tables-title { "Found, missed and false" }
            @for task in tables {
                @let (main, counts) = (main_grid(task), counts_grid(task));
                @let notes = notes(task, &[&main, &counts]);
                h3 { "Task " (task.task) }
                p.about { "Rates in %. Matched by " (task.matching_criterion) "." }
                (table(&main, &notes, &format!("Task {}: rates and speeds", task.task)))
                details {
                    summary { "Counts" }
                    (table(&counts, &notes, &format!("Task {}: counts", task.task)))
                }
                (sentences(&notes))
            }
        }
    }
}
