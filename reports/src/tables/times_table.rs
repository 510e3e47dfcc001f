//! The table of the times of detection.

use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::numbers::pools::Pool;
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::run_folder::manifest::Manifest;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Mark, Undefined};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::task_grids::extent_cell;
use crate::verdicts::times_doubt::share_on_busy_machine;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::{LatencyStatistic, Metric};
use crate::vocabulary::origin::Origin;

/// Times of each detector of a run, data set by data set.
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

/// Metrics that only some detectors have; columns without a value are left out.
const OF_SOME: [(&str, Metric); 4] = [
    ("CPU", Metric::CpuMean),
    ("overhead", Metric::OverheadP50),
    ("instructions", Metric::Instructions),
    ("memory", Metric::PeakMemory),
];

impl TimesTable {
    /// The times of `report`. They are the same for every task.
    pub fn new(report: &RunReport, manifest: &Manifest) -> Self {
        let mut columns = vec![Column::left("data set"), Column::left("detector"), Column::number("scans")];
        columns.extend(STATISTICS.iter().map(|(title, metric)| {
            let group = if metric.unit() == "ms" { "time of a scan [ms]" } else { "scans per second" };
            Column::number(*title).within(group)
        }));
        let is_known = |metric: &Metric| report.rows().iter().any(|it| it.metric == *metric);
        let of_some: Vec<_> = OF_SOME.into_iter().filter(|(_, metric)| is_known(metric)).collect();
        columns.extend(of_some.iter().map(|(title, metric)| Column::number(*title).within(group_of(metric))));
        let datasets = manifest.datasets.iter();
        let mut extents: Vec<(Extent, Origin)> =
            datasets.map(|it| (Extent::Dataset(it.id.clone()), it.origin())).collect();
        let several = manifest.pools().into_iter().filter(Pool::is_of_several);
        extents.extend(several.map(|it| (it.extent, it.origin)));
        let mut lines = Vec::new();
        for (extent, origin) in extents {
            for (detector_idx, detector) in manifest.detectors.iter().enumerate() {
                let row = |metric: &Metric| {
                    report.row(&Subject::of_all(extent.name(), report.first_task()?, &detector.name), metric)
                };
                let is_first = detector_idx == 0;
                let label = if is_first { extent_cell(&extent, origin) } else { Cell::default() };
                let kind = if is_first { LineKind::of(&extent) } else { LineKind::Detail };
                let busy = share_on_busy_machine(report, extent.name(), detector).map(|_| Mark::BusyMachine);
                let name = Cell { mark: busy, ..Cell::new(&*detector.name) };
                lines.push(Line { kind, cells: cells(row, &of_some, [label, name]) });
            }
        }
        Self { grid: Grid { columns, lines }, cpu_model: manifest.machine.cpu_model.clone() }
    }
}

impl Tabular for TimesTable {
    fn sheet(&self) -> Sheet {
        let sentence =
            "Percentiles by nearest rank. On another machine, only ratios between detectors can be compared.";
        let has = |title: &str| self.grid.columns.iter().any(|it| it.title == title);
        let of_cpu = "CPU: mean time on processors, on all threads and in all processes; more than the time of a scan \
                      where several work at once.";
        let of_overhead = "overhead: median of the way to a detector that is a program of its own, and back, measured beside it \
                       with one that reads the points and finds nothing.";
        let of_instructions =
            "instructions: mean of a scan in user mode, on all threads and in all processes of the detector.";
        let of_memory = "memory: mean over scans of the most at once; of a built-in detector what its detections allocate, of \
                         a program what its processes have in memory.";
        let of_some = [
            ("CPU", of_cpu),
            ("overhead", of_overhead),
            ("instructions", of_instructions),
            ("memory", of_memory),
        ];
        let of_some = of_some.into_iter().filter(|(title, _)| has(title));
        let sentences = [sentence].into_iter().chain(of_some.map(|it| it.1)).map(str::to_owned);
        let title = format!("Times of detection only, on {}.", self.cpu_model);
        Sheet::of(title, self.grid.clone(), sentences.collect()).labelled("times")
    }
}

/// What columns of a metric that only some detectors have stand under.
fn group_of(metric: &Metric) -> &'static str {
    match metric {
        Metric::Instructions => "per scan [million]",
        Metric::PeakMemory => "at most [MiB]",
        _ => "per scan [ms]",
    }
}

fn cells<'a>(
    row: impl Fn(&Metric) -> Option<&'a MetricRow>,
    of_some: &[(&str, Metric)],
    [label, name]: [Cell; 2],
) -> Vec<Cell> {
    let n_scans = row(&Metric::FpsMean).map_or(0, |it| it.n);
    let numbers = STATISTICS.iter().map(|(_, metric)| {
        let Some((row, value)) = row(metric).and_then(|row| Some((row, row.value()?))) else {
            return Cell::undefined(Undefined::NotTimed);
        };
        let text = if metric.unit() == "ms" { fixed_decimals(value, 2) } else { three_digits(value) };
        match metric.caveat(row.n) {
            Some(_) => Cell::marked(text, Mark::FewScans),
            None => Cell::new(text),
        }
    });
    let of_some = of_some.iter().map(|(_, metric)| {
        let value = row(metric).and_then(MetricRow::value);
        Cell::new(value.map_or_else(String::new, |it| fixed_decimals(it, 2)))
    });
    let names = [label, name, Cell::new(n_scans.to_string())];
    names.into_iter().chain(numbers).chain(of_some).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::sample;
    use crate::vocabulary::task::Task;

    /// A run of `n` scans on one street.
    fn table(n: u64) -> String {
        let mut manifest = sample::manifest();
        manifest.datasets.truncate(1);
        manifest.detectors.truncate(2);
        let row = |detector: &str, metric: &Metric, value: Option<f64>| {
            MetricRow::new(Subject::of_all("main_road", Task::Objects, detector), metric.clone(), value, n)
        };
        let rows = STATISTICS.iter().zip(1..).flat_map(|((_, metric), index)| {
            [row("paper", metric, Some(f64::from(index) * 1.5)), row("kd-tree", metric, None)]
        });
        let report = RunReport::new(1, rows.collect()).unwrap();
        Terminal { width: Some(100) }.text(&TimesTable::new(&report, &manifest))
    }

    #[test]
    fn percentiles_of_few_scans_are_marked() {
        insta::assert_snapshot!(table(58), @r"
        Times of detection only, on Example CPU @ 2 GHz.

                                                         time of a scan [ms]            scans per second
                                                 ────────────────────────────────────   ─────────────
        data set               detector  scans    min   p50   p90    p95    p99   max   1/mean  1/p50
        ─────────────────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)  paper        58   1.50  3.00  4.50  6.00‡  7.50‡  9.00     10.5   12.0
                               kd-tree      58   –¹    –¹    –¹    –¹     –¹     –¹        –¹     –¹

        Percentiles by nearest rank. On another machine, only ratios between detectors can be compared.
        simulated: from a simulator, not recorded.
        ‡ from too few scans to be reliable: p95 needs 59, p99 needs 299.
        ¹ undefined: no scan was timed.
        ");
        let marked = |n: u64| table(n).matches('‡').count();
        // Each of those marked, and the note.
        assert_eq!([58, 59, 299].map(marked), [3, 2, 0]);
    }

    #[test]
    fn a_group_that_is_too_wide_comes_apart() {
        let text =
            Terminal { width: Some(75) }.text(&TimesTable::new(&sample::report(), &sample::manifest()));
        for line in text.lines() {
            assert!(line.chars().count() <= 75, "{line}");
        }
    }

    #[test]
    fn all_data_sets_are_in_the_markdown() {
        let text = Markdown.text(&TimesTable::new(&sample::report(), &sample::manifest()));
        assert!(text.contains("| kitti_object | paper |") && text.contains("**overall**"), "{text}");
    }
}
