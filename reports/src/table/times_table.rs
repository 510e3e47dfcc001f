//! The table of how long detection takes.

use crate::fixed_decimals::{fixed_decimals, three_digits};
use crate::manifest::Manifest;
use crate::metric::{LatencyStatistic, Metric};
use crate::run_report::{OVERALL, RunReport, SLICE_ALL, Subject};
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind, Mark, Undefined};
use crate::table::notes::Notes;
use crate::table::task_grids::extent_cell;
use crate::table::task_table::{Extent, Origin};
use crate::table::{markdown, terminal};

/// How long each detector of a run takes, data set by data set.
#[derive(Debug, Clone, PartialEq)]
pub struct TimesTable {
    grid: Grid,
    cpu_model: String,
}

const STATISTICS: [(&str, Metric); 8] = [
    ("min", Metric::Latency(LatencyStatistic::Min)),
    ("p50", Metric::Latency(LatencyStatistic::P50)),
    ("p90", Metric::Latency(LatencyStatistic::P90)),
    ("p95", Metric::Latency(LatencyStatistic::P95)),
    ("p99", Metric::Latency(LatencyStatistic::P99)),
    ("max", Metric::Latency(LatencyStatistic::Max)),
    ("1/mean", Metric::FpsMean),
    ("1/p50", Metric::FpsP50),
];

impl TimesTable {
    /// The times of `report`. They are the same for every task.
    pub fn new(report: &RunReport, manifest: &Manifest) -> Self {
        let column = |group: Option<&str>, title, alignment| Column {
            group: group.map(str::to_owned),
            title,
            alignment,
        };
        let mut columns = vec![
            column(None, "data set", Alignment::Left),
            column(None, "detector", Alignment::Left),
            column(None, "scans", Alignment::Decimal),
        ];
        columns.extend(STATISTICS.iter().map(|(title, metric)| {
            let group = if metric.unit() == "ms" { "time of a scan [ms]" } else { "scans per second" };
            column(Some(group), title, Alignment::Decimal)
        }));
        let origin = |simulated| if simulated { Origin::Simulated } else { Origin::Recorded };
        let datasets = manifest.datasets.iter();
        let mut extents: Vec<(Extent, Origin)> =
            datasets.map(|it| (Extent::Dataset(it.id.clone()), origin(it.simulated))).collect();
        if extents.len() > 1 {
            let all = extents.iter().map(|(_, origin)| *origin).reduce(Origin::with);
            extents.extend(all.map(|origin| (Extent::Overall, origin)));
        }
        let task = report.rows().first().map_or("", |it| it.subject.task.as_str());
        let mut lines = Vec::new();
        for (extent, origin) in extents {
            for (detector_idx, detector) in manifest.detectors.iter().enumerate() {
                let dataset = match &extent {
                    Extent::Dataset(id) => id,
                    Extent::Overall => OVERALL,
                };
                let [dataset, task, slice] = [dataset, task, SLICE_ALL].map(str::to_owned);
                let subject = Subject { dataset, task, detector: detector.name.clone(), slice };
                let is_first = detector_idx == 0;
                let label = if is_first { extent_cell(&extent, origin) } else { Cell::default() };
                let kind = match extent {
                    _ if !is_first => LineKind::Detail,
                    Extent::Overall => LineKind::Overall,
                    Extent::Dataset(_) => LineKind::Dataset,
                };
                lines.push(Line { kind, cells: cells(report, &subject, label) });
            }
        }
        Self { grid: Grid { columns, lines }, cpu_model: manifest.machine.cpu_model.clone() }
    }

    /// The table for a terminal of `width` columns.
    pub fn to_terminal(&self, width: usize) -> String {
        let notes = self.notes();
        let mut text = terminal::wrapped_to(&self.title(), width) + "\n";
        terminal::write_folded(&mut text, &self.grid, &notes, width);
        text.push('\n');
        for sentence in &notes.sentences {
            text.push_str(&terminal::wrapped_to(sentence, width));
        }
        text
    }

    /// The table as Markdown.
    pub fn to_markdown(&self) -> String {
        let notes = self.notes();
        let mut text = format!("**{}**\n\n", markdown::escaped(&self.title()));
        markdown::write_grid(&mut text, &self.grid, &notes);
        text.push('\n');
        for sentence in &notes.sentences {
            markdown::push_line(&mut text, &format!("- {}", markdown::escaped(sentence)));
        }
        text
    }

    /// The table for any other renderer.
    pub(crate) fn grid_and_notes(&self) -> (&Grid, Notes) {
        (&self.grid, self.notes())
    }

    fn title(&self) -> String {
        format!("Times of detection only, on {}.", self.cpu_model)
    }

    fn notes(&self) -> Notes {
        let sentences = vec![
            "Percentiles by nearest rank. On another machine, only ratios between detectors can be compared."
                .to_owned(),
        ];
        Notes::beneath(std::slice::from_ref(&self.grid), sentences)
    }
}

fn cells(report: &RunReport, subject: &Subject, label: Cell) -> Vec<Cell> {
    let n_scans = report.row(subject, &Metric::FpsMean).map_or(0, |it| it.n);
    let numbers = STATISTICS.iter().map(|(_, metric)| {
        let row = report.row(subject, metric);
        let Some((row, value)) = row.and_then(|row| Some((row, row.value()?))) else {
            return Cell::undefined(Undefined::NotTimed);
        };
        let text = if metric.unit() == "ms" { fixed_decimals(value, 2) } else { three_digits(value) };
        match metric.caveat(row.n) {
            Some(_) => Cell::marked(text, Mark::FewScans),
            None => Cell::new(text),
        }
    });
    [label, Cell::new(subject.detector.clone()), Cell::new(n_scans.to_string())]
        .into_iter()
        .chain(numbers)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_report::MetricRow;
    use crate::table::sample;

    /// A run of `n` scans on one street.
    fn table(n: u64) -> String {
        let mut manifest = sample::manifest();
        manifest.datasets.truncate(1);
        manifest.detectors.truncate(2);
        let row = |detector: &str, metric: &Metric, value: Option<f64>| {
            let [dataset, task, detector, slice] =
                ["main_road", "objects", detector, SLICE_ALL].map(str::to_owned);
            MetricRow::new(Subject { dataset, task, detector, slice }, metric.clone(), value, n)
        };
        let rows = STATISTICS.iter().zip(1..).flat_map(|((_, metric), place)| {
            [row("hierarchical", metric, Some(f64::from(place) * 1.5)), row("kd-tree", metric, None)]
        });
        let report = RunReport::new(1, rows.collect()).unwrap();
        TimesTable::new(&report, &manifest).to_terminal(100)
    }

    #[test]
    fn percentiles_of_few_scans_are_marked() {
        insta::assert_snapshot!(table(58), @r"
        Times of detection alone, on Example CPU @ 2 GHz.

                                                             time of a scan [ms]            scans per second
                                                     ────────────────────────────────────   ─────────────
        data set               detector      scans    min   p50   p90    p95    p99   max   1/mean  1/p50
        ─────────────────────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)  hierarchical     58   1.50  3.00  4.50  6.00‡  7.50‡  9.00     10.5   12.0
                               kd-tree          58   –¹    –¹    –¹    –¹     –¹     –¹        –¹     –¹

        Percentiles by nearest rank. Only ratios between detectors of one run mean something on another
          machine.
        simulated: made by a simulator, not recorded.
        ‡ of too few scans to be relied on: p95 takes 59, p99 takes 299.
        ¹ undefined: no scan was timed.
        ");
        let marked = |n: u64| table(n).matches('‡').count();
        // Each of those marked, and the note.
        assert_eq!([58, 59, 299].map(marked), [3, 2, 0]);
    }

    #[test]
    fn a_group_that_is_too_wide_comes_apart() {
        let text = TimesTable::new(&sample::report(), &sample::manifest()).to_terminal(75);
        for line in text.lines() {
            assert!(line.chars().count() <= 75, "{line}");
        }
    }

    #[test]
    fn all_data_sets_are_in_the_markdown() {
        let text = TimesTable::new(&sample::report(), &sample::manifest()).to_markdown();
        assert!(text.contains("| kitti_object | hierarchical |") && text.contains("**overall**"), "{text}");
    }
}
