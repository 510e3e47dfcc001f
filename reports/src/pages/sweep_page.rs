//! The page of a sweep: its plots and its table.

use std::path::Path;

use maud::{Markup, html};

use super::again::Made;
use super::document::{Section, document};
use super::markup::wide_picture;
use crate::files::archive::ArchiveError;
use crate::files::csv_rows::MOST_OF_LINE;
use crate::files::regular_file::{BoundedLines, RegularFile, read_text};
use crate::files::whole_file::write_whole;
use crate::plots::curve_panels::NOTHING_DRAWN;
use crate::run_folder::manifest::Manifest;
use crate::run_folder::run_directory::{
    REPORT_HTML, SWEEP_BEST_TXT, SWEEP_CSV, SWEEP_PROTOCOLS_CSV, SWEEP_RRD, SWEEP_TIMES_CSV,
};
use crate::run_folder::run_target::MANIFEST_JSON;

/// The largest plot or text that becomes part of the page, in bytes.
const MOST_OF_PLOT: u64 = 1 << 26;

/// A kind of plots that a sweep leaves.
struct PlotKind {
    /// Prefix of the names of its files.
    beginning: &'static str,
    /// Its name in the links at the top.
    name: &'static str,
    heading: &'static str,
    /// Caption of the plots.
    about: &'static str,
}

const PLOTS: [PlotKind; 4] = [
    PlotKind {
        beginning: "f_rate_",
        name: "Rates",
        heading: "Rates over the parameter",
        about: "With 95 % intervals; the best point is marked.",
    },
    PlotKind {
        beginning: "fitness_",
        name: "Fitness",
        heading: "Cell fitness",
        about: "As in figures 6 a and b of the paper; needs no annotations.",
    },
    PlotKind {
        beginning: "pareto_",
        name: "Times",
        heading: "Rates over times",
        about: "On the Pareto front, no other point is both better and faster.",
    },
    PlotKind {
        beginning: "protocol_",
        name: "Protocols",
        heading: "Protocols of others",
        about: "Their principal numbers with 95 % intervals; the best point is marked.",
    },
];

/// The page of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPage {
    /// The page.
    pub html: String,
}

impl SweepPage {
    /// Whether `directory` holds a sweep.
    pub fn is_sweep(directory: &Path) -> bool {
        directory.join(SWEEP_CSV).is_file()
    }

    /// The page of the sweep in `directory`, made of its files alone.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if a file is missing or damaged.
    pub fn of(directory: &Path) -> Result<Self, ArchiveError> {
        let names = names_of_plots(directory)?;
        let plots = names.into_iter().map(|name| {
            let path = directory.join(&name);
            let svg = read_text(&path, MOST_OF_PLOT).map_err(|source| ArchiveError::Read { path, source })?;
            Ok((name, svg))
        });
        let plots = plots.collect::<Result<Vec<_>, ArchiveError>>()?;
        let scores = Table::read(&directory.join(SWEEP_CSV))?;
        let [times, protocols] = [SWEEP_TIMES_CSV, SWEEP_PROTOCOLS_CSV].map(|it| directory.join(it));
        let [times, protocols] = [Table::read_if_there(&times)?, Table::read_if_there(&protocols)?];
        let best = directory.join(SWEEP_BEST_TXT);
        let best = if best.is_file() {
            read_text(&best, MOST_OF_PLOT).map_err(|source| ArchiveError::Read { path: best, source })?
        } else {
            String::new()
        };
        let manifest_path = directory.join(MANIFEST_JSON);
        let manifest = if manifest_path.is_file() { Some(Manifest::read(&manifest_path)?) } else { None };
        let header = html! {
            p.kicker { "scanbench" }
            h1 { "Sweep of " (scores.swept()) }
            p.facts {
                (scores.rows.len()) " rows of detectors, data sets and tasks"
                @if let Some(it) = &manifest {
                    " · " (it.created.replace('T', " ").replace('Z', " UTC")) " · " (it.machine.cpu_model) " · scanbench "
                    (it.scanbench_version)
                }
            }
        };
        let mut sections = Vec::new();
        if !best.is_empty() {
            let content = html! { div.verdict { @for text in best.lines() { p { (text) } } } };
            sections.push(Section::without_heading("Best", content));
        }
        // Plots of numbers come before those that say that there are none.
        let (empty, drawn): (Vec<_>, Vec<_>) = PLOTS.iter().partition(|it| it.is_empty(&plots));
        sections.extend(drawn.into_iter().chain(empty).filter_map(|it| it.section(&plots)));
        let content = html! {
            details { summary { "sweep.csv" } (scores.markup(SWEEP_CSV)) }
            @if let Some(protocols) = &protocols {
                details { summary { "sweep_protocols.csv" } (protocols.markup(SWEEP_PROTOCOLS_CSV)) }
            }
            @if let Some(times) = &times { details { summary { "times.csv" } (times.markup(SWEEP_TIMES_CSV)) } }
        };
        sections.push(Section::new("Table", "All numbers", content));
        sections.extend(manifest.as_ref().map(|it| again(it, directory.join(SWEEP_RRD).is_file())));
        Ok(Self { html: document("a sweep", &header, &sections) })
    }

    /// Writes the page into `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), ArchiveError> {
        write_whole(&directory.join(REPORT_HTML), self.html.as_bytes())
    }
}

impl PlotKind {
    fn holds(&self, name: &str) -> bool {
        name.starts_with(self.beginning)
    }

    /// Whether none of its plots shows a series.
    fn is_empty(&self, plots: &[(String, String)]) -> bool {
        !plots.iter().any(|(name, svg)| self.holds(name) && !svg.contains(NOTHING_DRAWN))
    }

    /// The section of its plots among `plots`, which are names and contents; `None` if there are none.
    fn section(&self, plots: &[(String, String)]) -> Option<Section> {
        let mut of_kind: Vec<_> = plots.iter().filter(|(name, _)| self.holds(name)).collect();
        // Stable: as their names, but for those that show nothing.
        of_kind.sort_by_key(|(_, svg)| svg.contains(NOTHING_DRAWN));
        let content = html! {
            @for (name, svg) in &of_kind {
                @if is_whole(svg) {
                    (wide_picture(name, svg, &html! { (self.about) " " code { (name) } }))
                } @else {
                    p { (name) " is damaged." }
                }
            }
        };
        (!of_kind.is_empty()).then(|| Section::new(self.name, self.heading, content))
    }
}

/// How to make the sweep again, and where its recording is.
fn again(manifest: &Manifest, is_recorded: bool) -> Section {
    let content = html! {
        (Made::of(manifest).markup())
        @if is_recorded {
            p { "Its recording shows one scan at all points: " code { "rerun " (SWEEP_RRD) } " in this folder." }
        }
    };
    Section::new("Again", "Run it again", content)
}

fn names_of_plots(directory: &Path) -> Result<Vec<String>, ArchiveError> {
    let not_read = |source| ArchiveError::Read { path: directory.to_path_buf(), source };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(not_read)? {
        let path = entry.map_err(not_read)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_plot = path.extension().is_some_and(|it| it == "svg");
        if is_plot && PLOTS.iter().any(|it| it.holds(&name)) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// Whether a document is complete, so that it can stand in a page.
fn is_whole(svg: &str) -> bool {
    svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>")
}

/// A CSV file as it is.
struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, ArchiveError> {
        let bad_row = |source| ArchiveError::Csv { path: path.to_path_buf(), source };
        let file = RegularFile::open(path)
            .map_err(|source| ArchiveError::Read { path: path.to_path_buf(), source })?;
        let mut reader = csv::Reader::from_reader(BoundedLines::new(file, MOST_OF_LINE));
        let words = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
        let heads = words(reader.headers().map_err(bad_row)?);
        let rows = reader.records().map(|it| it.map(|it| words(&it)).map_err(bad_row));
        Ok(Self { heads, rows: rows.collect::<Result<_, _>>()? })
    }

    fn read_if_there(path: &Path) -> Result<Option<Self>, ArchiveError> {
        if path.is_file() { Self::read(path).map(Some) } else { Ok(None) }
    }

    /// The parameters: columns with a dot in their name.
    fn swept(&self) -> String {
        let names: Vec<&str> = self.heads.iter().filter(|it| it.contains('.')).map(String::as_str).collect();
        if names.is_empty() { "parameters".to_owned() } else { names.join(", ") }
    }

    fn markup(&self, label: &str) -> Markup {
        let is_number = |cell: &str| cell.parse::<f64>().is_ok();
        let class = |cell: &str| if is_number(cell) { "number" } else { "text" };
        html! {
            div.scroll tabindex="0" role="region" aria-label=(label) {
                table {
                    caption.hidden { (label) }
                    thead { tr { @for head in &self.heads { th scope="col" { (head) } } } }
                    tbody {
                        @for row in &self.rows {
                            tr { @for cell in row { td class=(class(cell)) { (cell) } } }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    fn sweep() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
        write(SWEEP_CSV, "dataset,hierarchical.grid.cell_size_m,f_rate\na<b,0.6,0.7\n");
        let svg = "<svg viewBox=\"0 0 90 40\"><rect fill=\"#FFFFFF\"/><text fill=\"#000000\">\nF &amp; x\n</text></svg>";
        write("f_rate_street.svg", svg);
        write("pareto_street.svg", "<svg <");
        write("protocol_nuscenes_street.svg", svg);
        write(SWEEP_BEST_TXT, "Best for a<b: 0.6.\n");
        write(SWEEP_PROTOCOLS_CSV, "dataset,metric,value\na<b,nds,0.33\n");
        write("other.svg", svg);
        folder
    }

    #[test]
    fn a_page_has_the_plots_and_the_table_of_a_sweep() {
        let folder = sweep();
        assert!(SweepPage::is_sweep(folder.path()));
        let page = SweepPage::of(folder.path()).unwrap();
        check_holds(
            &page.html,
            &[
                "Sweep of hierarchical.grid.cell_size_m",
                "viewBox=\"0 0 90 40\"",
                "F &amp; x",
                "a&lt;b",
                "f_rate_street.svg",
                "pareto_street.svg is damaged.",
                "Their principal numbers",
                "<p>Best for a&lt;b: 0.6.</p>",
                "nds",
                "href=\"#table\"",
            ],
        );
        assert!(!page.html.contains("other.svg") && !page.html.contains("#fitness"));
        page.write(folder.path()).unwrap();
        assert_eq!(SweepPage::of(folder.path()).unwrap(), page);
    }

    #[test]
    fn a_folder_without_rates_is_no_sweep() {
        let folder = tempfile::tempdir().unwrap();
        assert!(!SweepPage::is_sweep(folder.path()));
        let error = SweepPage::of(folder.path()).unwrap_err();
        assert!(error.to_string().contains(SWEEP_CSV), "{error}");
    }
}
