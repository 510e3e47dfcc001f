//! Parts that several sections of a page share.

use maud::{Markup, PreEscaped, html};

use crate::files::new_file::file_stem_of;
use crate::plots::themed_panel::{Arrangement, KeyEntry, ThemedPanel, sheet};
use crate::tables::folding::pieces;
use crate::tables::grid::{Alignment, Cell, Grid, Line, LineKind};
use crate::tables::notes::Notes;
use crate::tables::sheet::Sheet;

/// A picture that is also saved as a file of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its files, without folder and ending.
    pub file_stem: String,
    /// The document.
    pub svg: String,
}

/// Panels with their title, key and caption.
pub(super) struct FigureMarkup<'a> {
    pub(super) file_stem: &'a str,
    pub(super) title: &'a str,
    pub(super) panels: &'a [ThemedPanel],
    pub(super) key: &'a [KeyEntry],
    pub(super) caption: Markup,
    /// Additional class of the panels.
    pub(super) class: &'a str,
}

impl FigureMarkup<'_> {
    /// The figure on a page; as a file it is added to `files`.
    pub(super) fn render(self, files: &mut Vec<Figure>) -> Markup {
        let file_stem = file_stem_of(self.file_stem);
        files.push(Figure { svg: sheet(self.panels, Arrangement::Row, self.key, self.title), file_stem });
        html! {
            figure {
                (key(self.key))
                div class={ "panels " (self.class) } tabindex="0" role="region" aria-label=(self.title) {
                    @for panel in self.panels { (PreEscaped(panel.inline())) }
                }
                figcaption { (self.caption) }
            }
        }
    }
}

/// A picture that is too wide for small screens, with its caption; `svg` is a document, or part of one.
pub(super) fn wide_picture(name: &str, svg: &str, caption: &Markup) -> Markup {
    html! {
        figure.sweep {
            div.scroll tabindex="0" role="region" aria-label=(name) { (PreEscaped(svg)) }
            figcaption { (caption) }
        }
    }
}

/// Key to the lines and markers of a figure; empty for fewer than two entries.
pub(super) fn key(entries: &[KeyEntry]) -> Markup {
    html! {
        @if entries.len() > 1 {
            ul.key {
                @for entry in entries {
                    li { (PreEscaped(entry.swatch.inline_hidden())) " " (entry.name) }
                }
            }
        }
    }
}

/// Width of a table on a wide screen and on paper, in characters.
const TABLE_WIDTH: usize = 100;

/// A table, in pieces below each other where it is too wide for a page. Each scrolls sideways, by keyboard too, where the
/// screen is narrower.
pub(super) fn table(grid: &Grid, notes: &Notes, label: &str) -> Markup {
    let pieces = pieces(grid, notes, TABLE_WIDTH);
    let n_pieces = pieces.len();
    html! {
        @for (piece, number) in pieces.iter().zip(1..) {
            @if n_pieces == 1 {
                (piece_of_table(piece, notes, label))
            } @else {
                (piece_of_table(piece, notes, &format!("{label} ({number} of {n_pieces})")))
            }
        }
    }
}

fn piece_of_table(grid: &Grid, notes: &Notes, label: &str) -> Markup {
    let fraction_widths = grid.fraction_widths();
    let groups = grid.groups();
    let n_row_heads = grid.columns.iter().take_while(|it| it.alignment == Alignment::Left).count();
    html! {
        div.scroll tabindex="0" role="region" aria-label=(label) {
            table {
                caption.hidden { (label) }
                thead {
                    @if groups.iter().any(|(name, _)| name.is_some()) {
                        tr.groups {
                            @for (name, n_columns) in &groups {
                                @if let Some(name) = name {
                                    th scope="colgroup" colspan=(n_columns) { (name) }
                                } @else {
                                    td colspan=(n_columns) {}
                                }
                            }
                        }
                    }
                    tr {
                        @for (idx, column) in grid.columns.iter().enumerate() {
                            th scope="col" class=(column_class(grid, idx)) { (column.title) }
                        }
                    }
                }
                tbody {
                    @for line in &grid.lines {
                        tr class=(line_class(line)) {
                            @for (idx, cell) in line.cells.iter().enumerate() {
                                @let content = cell_markup(cell, notes, fraction_widths[idx], grid.columns[idx].alignment);
                                @if idx < n_row_heads && !cell.text.is_empty() {
                                    th scope="row" class=(column_class(grid, idx)) { (content) }
                                } @else {
                                    td class=(column_class(grid, idx)) { (content) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The tables of a sheet, each below its title, or below `title` if it has none.
pub(super) fn titled_tables(sheet: &Sheet, title: &str) -> Markup {
    html! {
        @for part in &sheet.parts {
            @let title = part.title.as_deref().unwrap_or(title);
            h3 { (title) }
            (table(&part.grid, &sheet.notes, title))
        }
        (sentences(&sheet.notes))
    }
}

/// The sentences beneath a table.
pub(super) fn sentences(notes: &Notes) -> Markup {
    html! {
        details.notes {
            summary { "What the columns and signs mean" }
            ul { @for sentence in &notes.sentences { li { (sentence) } } }
        }
    }
}

fn column_class(grid: &Grid, idx: usize) -> String {
    let alignment = match grid.columns[idx].alignment {
        Alignment::Left => "text",
        Alignment::Decimal => "number",
    };
    let begins = idx > 0 && grid.columns[idx].group != grid.columns[idx - 1].group;
    if begins { format!("{alignment} begins") } else { alignment.to_owned() }
}

fn line_class(line: &Line) -> &'static str {
    match line.kind {
        LineKind::Dataset => "dataset",
        // It says more about the line above, and does not hold another detector's numbers.
        LineKind::Detail if !line.cells[0].text.is_empty() => "detail",
        LineKind::Detail => "more",
        LineKind::Overall => "overall",
        LineKind::Paper => "paper",
    }
}

fn cell_markup(cell: &Cell, notes: &Notes, fraction_width: usize, alignment: Alignment) -> Markup {
    let sign = notes.sign(cell);
    // Numbers are aligned by their decimal points: missing decimals are filled up with blanks of the same width.
    let missing = fraction_width.saturating_sub(cell.fraction().chars().count());
    let is_filled = alignment == Alignment::Decimal && !cell.is_interval && !cell.text.is_empty();
    let blanks: String = match (is_filled, cell.fraction().is_empty()) {
        (false, _) => String::new(),
        (true, _) if missing == 0 => String::new(),
        (true, true) => format!("\u{2008}{}", "\u{2007}".repeat(missing - 1)),
        (true, false) => "\u{2007}".repeat(missing),
    };
    html! {
        @if cell.is_interval { span.interval { (cell.text) } } @else { (cell.text) }
        @if !sign.is_empty() { sup { (sign) } }
        @if let Some(tag) = Notes::tag(cell) { " " span.tag { (tag) } }
        (blanks)
    }
}

/// A block of commands.
pub(super) fn commands(lines: &str, label: &str) -> Markup {
    html! { pre tabindex="0" role="region" aria-label=(label) { code { (lines) } } }
}
