//! The page of a run.

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::curves::curves;
use super::markup::Figure;
use super::overview::{heading, overview};
use super::parameters::parameters;
use super::ranges::ranges;
use super::reproduction::reproduction;
use super::run_facts::RunFacts;
use super::task_tables::task_tables;
use super::times::times;
use super::worst::worst;
use crate::archive::ArchiveError;
use crate::plot::themed_svg::theme_css;
use crate::run_directory::{FIGURES, REPORT_HTML};
use crate::table::task_table::{TableError, task_tables as tables_of};
use crate::whole_file::write_whole;

/// The page of a run, and its figures as files.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPage {
    /// The page.
    pub html: String,
    /// What goes into the folder [`FIGURES`].
    pub figures: Vec<Figure>,
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A file of the run cannot be read, or the page not be written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The files of the run do not fit together.
    #[error(transparent)]
    Table(#[from] TableError),
}

impl RunPage {
    /// The page of the run in `directory`, made of its files alone.
    ///
    /// # Errors
    ///
    /// [`PageError`] if a file is missing or damaged, or files do not fit together.
    pub fn of(directory: &Path) -> Result<Self, PageError> {
        let facts = RunFacts::read(directory)?;
        let tables = tables_of(&facts.report, &facts.manifest)?;
        let mut figures = Vec::new();
        let sections = html! {
            (overview(&facts, &mut figures))
            (task_tables(&tables))
            (ranges(&facts, &mut figures))
            (curves(&facts, &mut figures))
            (times(&facts, &mut figures))
            (worst(&facts))
            (reproduction(&facts))
            (parameters(&facts.manifest))
        };
        let html = document(&heading(&facts), &sections).into_string();
        Ok(Self { html, figures })
    }

    /// Writes the page and its figures into `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if they cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), ArchiveError> {
        let folder = directory.join(FIGURES);
        std::fs::create_dir_all(&folder)
            .map_err(|source| ArchiveError::Write { path: folder.clone(), source })?;
        for figure in &self.figures {
            write_whole(&folder.join(&figure.file_name), figure.svg.as_bytes())?;
        }
        write_whole(&directory.join(REPORT_HTML), self.html.as_bytes())
    }
}

/// Where the links at the top lead.
const SECTIONS: [(&str, &str); 8] = [
    ("verdict", "Verdict"),
    ("tables", "Tables"),
    ("range", "Range"),
    ("curves", "Curves"),
    ("times", "Times"),
    ("worst", "Worst"),
    ("reproduce", "Make it again"),
    ("manifest", "Manifest"),
];

fn document(title: &str, sections: &Markup) -> Markup {
    let css = format!("{}{}", theme_css(":root"), include_str!("page.css"));
    let content = sections.0.as_str();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                // Whatever a name in a file tries: nothing is loaded and nothing runs.
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { "scanbench: " (title) }
                style { (PreEscaped(css)) }
            }
            body {
                a.skip href="#main" { "Skip to the verdict" }
                nav aria-label="Sections" {
                    ul {
                        @for (id, name) in SECTIONS {
                            @if content.contains(&format!("<section id=\"{id}\"")) { li { a href={ "#" (id) } { (name) } } }
                        }
                    }
                }
                main #main tabindex="-1" { (sections) }
            }
        }
    }
}
