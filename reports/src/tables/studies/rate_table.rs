//! Rates of several detectors on one part of the objects after another.

use crate::files::fixed_decimals::percent_or_dash;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::paper_figures::{PAPER_TABLES, PaperTable};
use crate::tables::sheet::{Sheet, Tabular};
use crate::vocabulary::task::Task;

/// One row for each part, and one column for each detector.
#[derive(Debug, Clone, PartialEq)]
pub struct RateTable {
    /// Its title.
    pub title: String,
    /// The rate, such as the F-rate.
    pub rate: &'static str,
    /// The detectors.
    pub detectors: Vec<String>,
    /// The parts.
    pub rows: Vec<RateRow>,
    /// The notes beneath.
    pub notes: Vec<String>,
}

/// Rates of detectors on one part of the objects.
#[derive(Debug, Clone, PartialEq)]
pub struct RateRow {
    /// Name of the part.
    pub name: String,
    /// Annotations that count.
    pub no: u64,
    /// The rate of each detector, 0 to 1.
    pub rates: Vec<Option<f64>>,
    /// Whether it is a row of a paper, and not one of ours.
    pub is_printed: bool,
}

/// The rows of the paper's table about `task`, under those of `detectors` that do what it describes.
pub fn printed_rows(task: Task, detectors: &[String]) -> Vec<RateRow> {
    let tables = PAPER_TABLES.iter().filter(|it| it.task == task);
    let of_table = |table: &'static PaperTable| {
        table.rows.iter().map(move |row| RateRow {
            name: format!("{}, as printed", row.name),
            no: row.no.into(),
            rates: detectors
                .iter()
                .map(|it| Some(table.score_beside(row, it)?.f_rate_percent / 100.0))
                .collect(),
            is_printed: true,
        })
    };
    tables.flat_map(of_table).collect()
}

impl Tabular for RateTable {
    fn sheet(&self) -> Sheet {
        let mut columns = vec![Column::left("part"), Column::number("NO")];
        columns.extend(self.detectors.iter().map(|it| Column::number(self.rate).within(it.clone())));
        let line = |RateRow { name, no, rates, is_printed }: &RateRow| {
            let rates = rates.iter().map(|it| percent_or_dash(*it));
            let texts = [name.clone(), no.to_string()].into_iter().chain(rates);
            let kind = if *is_printed { LineKind::Paper } else { LineKind::Dataset };
            Line { kind, cells: texts.map(Cell::new).collect() }
        };
        let grid = Grid { columns, lines: self.rows.iter().map(line).collect() };
        Sheet::of(self.title.clone(), grid, self.notes.clone())
    }
}
