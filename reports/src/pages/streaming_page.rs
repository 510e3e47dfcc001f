//! `streaming.html`: detectors on drives, scored per scan and as they stream.

use maud::{Markup, html};

use super::document::{Section, document};
use super::markup::{Figure, titled_tables, wide_picture};
use crate::plots::streaming_plot::streaming_plot;
use crate::streaming::streamed::Streamed;
use crate::tables::sheet::Tabular as _;
use crate::tables::studies::streaming_table::{StreamingTable, is_one_of_several};

/// The page of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamingPage {
    /// The page, whole in itself.
    pub html: String,
    /// Its figures.
    pub figures: Vec<Figure>,
}

impl StreamingPage {
    /// The page of `table`, which was made by `command` of the run called `run`.
    pub fn of(table: &StreamingTable<'_>, run: &str, command: &str) -> Self {
        let figures = figures(table.streamed);
        let pictures = html! {
            @for it in &figures { (wide_picture("The speed of the computer", &it.svg, &caption())) }
        };
        let sheet = table.sheet();
        let header = html! {
            p.kicker { "scanbench" }
            h1 { "Streaming: " (run) }
            p.facts { "Made of the rows of the run, by " code { (command) } }
            @for it in &sheet.lead { p { (it) } }
            p { a href="report.html" { "The page of the run" } }
        };
        let sections = [
            Section::new("Machines", "Which detector is best on which computer", pictures),
            Section::new("Rates", "Per scan, and as it streams", titled_tables(&sheet, "Rates")),
        ];
        Self { html: document(&format!("streaming of {run}"), &header, &sections), figures }
    }
}

fn caption() -> Markup {
    html! {
        "The rate of every detector if the computer were as many times as fast: all its measured times are divided by that. \
         To the left slower detectors drop scans, and their answers are older; to the right all come near what they reach per scan, \
         except for what moves between two scans."
    }
}

/// A figure for all data sets of each origin together.
fn figures(streamed: &[Streamed]) -> Vec<Figure> {
    let mut extents: Vec<&Streamed> = Vec::new();
    for it in streamed {
        if !is_one_of_several(it, streamed) && extents.iter().all(|known| known.extent != it.extent) {
            extents.push(it);
        }
    }
    let is_alone = extents.len() == 1;
    let figure = |it: &&Streamed| {
        let of_extent: Vec<&Streamed> = streamed.iter().filter(|other| other.extent == it.extent).collect();
        let name = it.extent.name();
        let file_stem = if is_alone { "streaming".to_owned() } else { format!("streaming_{name}") };
        Some(Figure { svg: streaming_plot(&of_extent, name)?, file_stem })
    };
    extents.iter().filter_map(figure).collect()
}
