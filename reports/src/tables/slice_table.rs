//! The tables of the slices that users define.

use super::grid::{Cell, Column, Grid, Line, LineKind};
use super::notes::about_interval;
use super::sheet::{Sheet, Tabular};
use crate::files::fixed_decimals::{fixed_decimals, percent_or_dash};
use crate::files::new_file::file_stem_of;
use crate::numbers::blocks::{BlockKind, Interval};
use crate::numbers::pools::Pool;
use crate::numbers::run_report::{MetricRow, RunReport};
use crate::run_folder::manifest::Manifest;
use crate::vocabulary::metric::{Metric, RecallPositions};
use crate::vocabulary::origin::Origin;
use crate::vocabulary::slice::Slice;

/// Numbers of the slices of the user on a data set, or on several together.
#[derive(Debug, Clone, PartialEq)]
pub struct SliceTable {
    /// Id of the data set, or the name of several together.
    dataset: String,
    origin: Origin,
    matching_criterion: String,
    /// Slice by slice, task by task, detector by detector.
    lines: Vec<SliceLine>,
}

/// Numbers of a detector in a task about a slice.
#[derive(Debug, Clone, PartialEq)]
struct SliceLine {
    slice: String,
    task: &'static str,
    detector: String,
    no: u64,
    tp: u64,
    fo: Option<u64>,
    /// Recall, F-rate and average precision.
    rates: [Option<f64>; 3],
    within: Option<Interval>,
}

/// The tables of the slices of a run: of each data set, then of several of one origin together. None without a line.
pub fn slice_tables(report: &RunReport, manifest: &Manifest) -> Vec<SliceTable> {
    let datasets = manifest.datasets.iter().map(|it| (it.id.clone(), it.origin()));
    let several = manifest.pools().into_iter().filter(Pool::is_of_several);
    let several = several.map(|it| (it.extent.name().to_owned(), it.origin));
    let tables = datasets.chain(several).map(|(dataset, origin)| SliceTable {
        lines: lines_of(report, &dataset),
        matching_criterion: manifest.matching_criterion.clone(),
        dataset,
        origin,
    });
    tables.filter(|it| !it.lines.is_empty()).collect()
}

fn lines_of(report: &RunReport, dataset: &str) -> Vec<SliceLine> {
    let rows = report.rows().iter().chain(report.overall());
    let is_own = |it: &&MetricRow| it.subject.dataset == dataset && matches!(it.subject.slice, Slice::Own(_));
    let mut rows: Vec<&MetricRow> = rows.filter(is_own).collect();
    rows.sort_by_key(|it| (it.subject.slice, it.subject.task));
    let lines = rows.chunk_by(|a, b| a.subject == b.subject).map(|rows| {
        let row = |metric: Metric| rows.iter().find(|it| it.metric == metric);
        let value = |metric| row(metric).and_then(|it| it.value());
        let subject = &rows[0].subject;
        SliceLine {
            slice: subject.slice.name().trim_start_matches("own/").to_owned(),
            task: subject.task.name(),
            detector: subject.detector.clone(),
            no: value(Metric::No).unwrap_or(0.0) as u64,
            tp: value(Metric::Tp).unwrap_or(0.0) as u64,
            fo: value(Metric::Fo).map(|it| it as u64),
            rates: [Metric::Recall, Metric::FRate, Metric::AveragePrecision(RecallPositions::R40)].map(value),
            within: row(Metric::FRate).and_then(|it| it.interval()),
        }
    });
    lines.filter(|it| it.no + it.fo.unwrap_or(0) > 0).collect()
}

impl SliceLine {
    fn line(&self) -> Line {
        let whole = |it: Option<u64>| it.map_or_else(|| "?".to_owned(), |it| it.to_string());
        let nd = self.fo.map(|it| it + self.tp);
        let precision = nd.filter(|it| *it > 0).map(|it| self.tp as f64 / it as f64);
        let [recall, f_rate, ap] = self.rates.map(|it| Cell::new(percent_or_dash(it)));
        let ends = |it: Interval| it.ends.map(|end| fixed_decimals(100.0 * end, 1)).join(" to ");
        let within = self.within.map_or_else(|| Cell::new("–"), |it| Cell::interval(ends(it), it.blocks));
        let words = [&self.slice, self.task, &self.detector].map(Cell::new);
        let counts = [self.no.to_string(), whole(nd), self.tp.to_string(), whole(self.fo)].map(Cell::new);
        let rates = [Cell::new(percent_or_dash(precision)), recall, f_rate, within, ap];
        Line { kind: LineKind::Detail, cells: words.into_iter().chain(counts).chain(rates).collect() }
    }
}

impl Tabular for SliceTable {
    fn sheet(&self) -> Sheet {
        let mut columns = ["slice", "task", "detector"].map(Column::left).to_vec();
        columns.extend(
            ["NO", "ND", "TP", "FO", "precision", "recall", "F-rate", "95 %", "AP"].map(Column::number),
        );
        let kinds = self.lines.iter().filter_map(|it| it.within).map(|it| it.blocks.kind);
        let mut sentences = vec![format!(
            "What is within the bounds of a slice, in %, matched by {}: annotations, and detections that are false, by their own \
             centre, box and points. The bounds are in manifest.json. AP: average precision at 40 recalls.",
            self.matching_criterion
        )];
        sentences.extend(kinds.reduce(BlockKind::with).map(|it| format!("95 %: {}", about_interval(it))));
        let title = format!("Slices of {}{}.", self.dataset, self.origin.in_brackets());
        let grid = Grid { columns, lines: self.lines.iter().map(SliceLine::line).collect() };
        Sheet::of(title, grid, sentences).labelled(&format!("slices-{}", self.dataset))
    }
}

impl SliceTable {
    /// Name of the files it is written to, without the ending.
    pub fn file_stem(&self) -> String {
        format!("table_slices_{}", file_stem_of(&self.dataset))
    }
}
