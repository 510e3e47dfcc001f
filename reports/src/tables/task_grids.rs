//! The grids of a task's table: the papers' table, and the counts that it is made of.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::Interval;
use crate::rows::counts::Counts;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Mark, Undefined};
use crate::tables::notes::{INTERVAL_TITLE, notes, title};
use crate::tables::paper_figures::{PaperRow, PaperTable, Recordings};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::tables::task_table::{MeasuredRow, Score, TableRow, TaskTable};
use crate::vocabulary::extent::{Extent, OVERALL};
use crate::vocabulary::origin::Origin;

/// One line a data set, as in the papers: NO, then for each detector ND, F-rate and fps; beneath it the intervals of the
/// F-rates.
///
/// Where the F-rate is undefined because false objects are unknown, a line with the recall follows.
fn main_grid(table: &TaskTable) -> Grid {
    let mut columns = vec![Column::left("data set"), Column::number("NO")];
    for detector in &table.detectors {
        columns.extend(["ND", "F-rate", "fps"].map(|title| Column::number(title).within(detector)));
    }
    let mut lines = Vec::new();
    for row in &table.rows {
        match row {
            TableRow::Measured(row) => {
                lines.push(measured_line(row));
                lines.extend(interval_line(row, |it| it.intervals.f_rate));
                lines.extend(recall_line(row));
                if row.scores.iter().any(|it| it.counts.fo().is_none()) {
                    lines.extend(interval_line(row, |it| it.intervals.recall));
                }
            }
            TableRow::Paper(row) => {
                lines.extend(table.paper.map(|paper| paper_line(paper, row, &table.detectors)));
            }
        }
    }
    Grid { columns, lines }
}

/// One line a data set and detector: all counts, the rates that [`main_grid`] leaves out, and the ignored objects.
fn counts_grid(table: &TaskTable) -> Grid {
    let left = ["data set", "detector"].map(Column::left);
    let numbers = ["scans", "NO", "TP", "MO", "FO", "P", "R", "IA", "ID"].map(Column::number);
    let columns = left.into_iter().chain(numbers).collect();
    let measured = table.rows.iter().filter_map(|it| match it {
        TableRow::Measured(row) => Some(row),
        TableRow::Paper(_) => None,
    });
    let lines = measured.flat_map(|row| {
        let by_detector = table.detectors.iter().zip(&row.scores).enumerate();
        by_detector.map(|(detector_idx, (detector, score))| {
            let is_first = detector_idx == 0;
            let kind = if is_first { LineKind::of(&row.extent) } else { LineKind::Detail };
            let label = if is_first { label(row) } else { Cell::default() };
            Line { kind, cells: counts_cells(label, detector, score) }
        })
    });
    Grid { columns, lines: lines.collect() }
}

fn counts_cells(label: Cell, detector: &str, score: &Score) -> Vec<Cell> {
    let counts = score.counts;
    let count = |count: u64| Cell::new(count.to_string());
    vec![
        label,
        Cell::new(detector),
        count(score.n_scans),
        count(counts.no()),
        count(counts.tp()),
        count(counts.mo()),
        counts.fo().map_or(Cell::undefined(Undefined::FalseObjectsUnknown), count),
        rate_cell(counts.precision(), counts),
        recall_cell(counts),
        count(score.n_ignored_annotations),
        count(score.n_ignored_detections),
    ]
}

fn label(row: &MeasuredRow) -> Cell {
    extent_cell(&row.extent, row.origin)
}

/// Name of the extent of a row, marked if any of it is simulated.
pub(crate) fn extent_cell(extent: &Extent, origin: Origin) -> Cell {
    match (origin, extent) {
        // Recorded extents are not marked, except beside simulated ones.
        (Origin::Recorded, Extent::OverallOf(_)) => Cell::marked(OVERALL, Mark::Recorded),
        (Origin::Recorded, _) => Cell::new(extent.name()),
        (_, Extent::OverallOf(_)) => Cell::marked(OVERALL, Mark::Simulated),
        _ => Cell::marked(extent.name(), Mark::Simulated),
    }
}

fn measured_line(row: &MeasuredRow) -> Line {
    let mut cells = vec![label(row), Cell::new(row.no.to_string())];
    for score in &row.scores {
        let nd = score.counts.nd();
        cells.extend([
            nd.map_or(Cell::undefined(Undefined::FalseObjectsUnknown), |it| Cell::new(it.to_string())),
            rate_cell(score.counts.f_rate(), score.counts),
            fps_cell(score),
        ]);
    }
    Line { kind: LineKind::of(&row.extent), cells }
}

/// Intervals of the rates of the line above; `None` if none is known.
fn interval_line(row: &MeasuredRow, interval: fn(&Score) -> Option<Interval>) -> Option<Line> {
    let intervals: Vec<_> = row.scores.iter().map(interval).collect();
    intervals.iter().any(Option::is_some).then(|| {
        let mut cells = vec![Cell::new(INTERVAL_TITLE), Cell::default()];
        for interval in intervals {
            cells.extend([Cell::default(), interval_cell(interval), Cell::default()]);
        }
        Line { kind: LineKind::Detail, cells }
    })
}

/// The ends of an interval in percent; empty where there is none.
pub(crate) fn interval_cell(interval: Option<Interval>) -> Cell {
    interval.map_or_else(Cell::default, |it| {
        let [low, high] = it.ends.map(percent_text);
        Cell::interval(format!("{low}–{high}"), it.blocks)
    })
}

fn recall_line(row: &MeasuredRow) -> Option<Line> {
    let is_needed = |score: &Score| score.counts.fo().is_none();
    row.scores.iter().any(is_needed).then(|| {
        let mut cells = vec![Cell::new("recall, TP / NO"), Cell::default()];
        for score in &row.scores {
            let recall = if is_needed(score) { recall_cell(score.counts) } else { Cell::default() };
            cells.extend([Cell::default(), recall, Cell::default()]);
        }
        Line { kind: LineKind::Detail, cells }
    })
}

fn paper_line(paper: &PaperTable, row: &PaperRow, detectors: &[String]) -> Line {
    let text = format!("published: {}", row.name);
    let label = match row.recordings {
        Recordings::Budapest | Recordings::Both => Cell::marked(text, Mark::NotPublic),
        Recordings::Kitti => Cell::new(text),
    };
    let mut cells = vec![label, Cell::new(row.no.to_string())];
    for detector in detectors {
        cells.extend(match paper.score_beside(row, detector) {
            // As printed: with no more digits than the paper has.
            Some(score) => [
                Cell::default(),
                Cell::new(score.f_rate_percent.to_string()),
                Cell::new(score.fps.to_string()),
            ],
            None => Default::default(),
        });
    }
    Line { kind: LineKind::Paper, cells }
}

/// A rate that has ND in its denominator.
pub(crate) fn rate_cell(rate: Option<f64>, counts: Counts) -> Cell {
    match (rate, counts.fo()) {
        (Some(rate), _) => Cell::new(percent_text(rate)),
        (None, None) => Cell::undefined(Undefined::FalseObjectsUnknown),
        (None, Some(_)) => Cell::undefined(Undefined::ZeroDenominator),
    }
}

pub(crate) fn recall_cell(counts: Counts) -> Cell {
    let recall = counts.recall();
    recall.map_or(Cell::undefined(Undefined::ZeroDenominator), |it| Cell::new(percent_text(it)))
}

fn percent_text(rate: f64) -> String {
    fixed_decimals(100.0 * rate, 1)
}

/// Scans per second, marked if a busy machine makes them unreliable.
pub(crate) fn fps_cell(score: &Score) -> Cell {
    match score.fps {
        None => Cell::undefined(Undefined::NotTimed),
        Some(fps) if score.on_busy_machine => Cell::marked(fps_text(fps), Mark::BusyMachine),
        Some(fps) => Cell::new(fps_text(fps)),
    }
}

/// Three digits, but never more than two decimals.
fn fps_text(fps: f64) -> String {
    match fps {
        100.0.. => fixed_decimals(fps, 0),
        10.0.. => fixed_decimals(fps, 1),
        _ => fixed_decimals(fps, 2),
    }
}

impl Tabular for TaskTable {
    /// The papers' table, then the counts that it is made of.
    fn sheet(&self) -> Sheet {
        let [main, counts] = [main_grid(self), counts_grid(self)];
        let notes = notes(self, &[&main, &counts]);
        let parts = vec![Part { title: Some(title(self)), grid: main }, Part { title: None, grid: counts }];
        Sheet { label: self.task.name().to_owned(), lead: Vec::new(), parts, listing: None, notes }
    }

    /// The papers' table alone.
    fn printed(&self) -> Sheet {
        let main = main_grid(self);
        let notes = notes(self, &[&main]);
        let parts = vec![Part { title: Some(title(self)), grid: main }];
        Sheet { label: self.task.name().to_owned(), lead: Vec::new(), parts, listing: None, notes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_have_three_digits_or_two_decimals() {
        assert_eq!([0.384, 8.0, 29.04, 121.3].map(fps_text), ["0.38", "8.00", "29.0", "121"]);
    }
}
