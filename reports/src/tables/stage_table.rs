//! The table of how long each step of the method takes, beside the paper's times.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::run_folder::manifest::Manifest;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Undefined};
use crate::tables::paper_figures::VEHICLE_STEPS;
use crate::tables::sheet::{Sheet, Tabular};
use crate::vocabulary::metric::{LatencyStatistic, Metric};

/// The detector whose stages are those of the paper.
const DETECTOR: &str = "hierarchical";

/// The median time of each step on each data set of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTable {
    grid: Grid,
    cpu_model: String,
}

impl StageTable {
    /// The stages of `hierarchical` in `report`; `None` if it did not run.
    pub fn new(report: &RunReport, manifest: &Manifest) -> Option<Self> {
        manifest.detectors.iter().find(|it| it.name == DETECTOR)?;
        let task = report.first_task()?;
        let rows_of = |dataset: &str| -> Vec<&MetricRow> {
            let subject = Subject::of_all(dataset, task, DETECTOR);
            report.rows().iter().filter(|it| it.subject == subject).collect()
        };
        let datasets: Vec<Vec<&MetricRow>> = manifest.datasets.iter().map(|it| rows_of(&it.id)).collect();
        let mut others: Vec<&str> = Vec::new();
        for row in datasets.iter().flatten() {
            if let Metric::StageP50(stage) = &row.metric {
                let in_paper = VEHICLE_STEPS.iter().any(|it| it.stages.contains(&stage.as_str()));
                if !in_paper && !others.contains(&stage.as_str()) {
                    others.push(stage);
                }
            }
        }
        let step = |name: &str, stages: &[&str], paper_ms: Option<f64>| {
            let sums = datasets.iter().map(|rows| sum_cell(rows, stages));
            line(LineKind::Detail, [name.to_owned(), stages.join(", ")], paper_ms, sums)
        };
        let mut lines: Vec<Line> =
            VEHICLE_STEPS.iter().map(|it| step(it.name, it.stages, Some(it.ms))).collect();
        lines.extend(others.into_iter().map(|stage| step("not in the paper", &[stage], None)));
        let whole = datasets.iter().map(|rows| {
            let p50 = Metric::Latency(LatencyStatistic::P50);
            ms_cell(rows.iter().find(|it| it.metric == p50).and_then(|it| it.value()))
        });
        let paper_sum_ms = VEHICLE_STEPS.iter().map(|it| it.ms).sum();
        lines.push(line(LineKind::Overall, ["whole".to_owned(), String::new()], Some(paper_sum_ms), whole));
        let cpu_model = manifest.machine.cpu_model.clone();
        Some(Self { grid: Grid { columns: columns(manifest), lines }, cpu_model })
    }
}

impl Tabular for StageTable {
    fn sheet(&self) -> Sheet {
        let title = format!("Median times of the stages of {DETECTOR} in ms, on {}.", self.cpu_model);
        let sentence = "A step with several stages has the sum of their medians. paper: VM section 6, with another machine, other \
             scans and fewer features (eight); for orientation.";
        Sheet::of(title, self.grid.clone(), vec![sentence.to_owned()]).labelled("stages")
    }
}

fn columns(manifest: &Manifest) -> Vec<Column> {
    let mut columns = vec![Column::left("step"), Column::left("stages"), Column::number("paper")];
    columns.extend(manifest.datasets.iter().map(|it| {
        let simulated = if it.simulated { " (simulated)" } else { "" };
        Column::number("p50").within(format!("{}{simulated}", it.id))
    }));
    columns
}

fn line(
    kind: LineKind,
    [name, stages]: [String; 2],
    paper_ms: Option<f64>,
    ours: impl Iterator<Item = Cell>,
) -> Line {
    let paper = paper_ms.map_or_else(Cell::default, |it| Cell::new(fixed_decimals(it, 0)));
    let cells = [Cell::new(name), Cell::new(stages), paper].into_iter().chain(ours).collect();
    Line { kind, cells }
}

/// The sum of the medians of `stages`; undefined if one of them was not timed.
fn sum_cell(rows: &[&MetricRow], stages: &[&str]) -> Cell {
    let median = |stage: &&str| {
        let metric = Metric::StageP50((*stage).to_owned());
        rows.iter().find(|it| it.metric == metric).and_then(|it| it.value())
    };
    ms_cell(stages.iter().map(median).sum())
}

fn ms_cell(ms: Option<f64>) -> Cell {
    ms.map_or_else(|| Cell::undefined(Undefined::NotTimed), |it| Cell::new(fixed_decimals(it, 2)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::tables::sample;
    use crate::vocabulary::task::Task;

    fn table(stages: &[(&str, f64)]) -> String {
        let mut manifest = sample::manifest();
        manifest.datasets.truncate(1);
        let subject = || Subject::of_all("main_road", Task::Objects, DETECTOR);
        let times = stages.iter().map(|(stage, ms)| (Metric::StageP50((*stage).to_owned()), *ms));
        let whole = (Metric::Latency(LatencyStatistic::P50), 9.5);
        let rows = times.chain([whole]).map(|(metric, ms)| MetricRow::new(subject(), metric, Some(ms), 20));
        let report = RunReport::new(1, rows.collect()).unwrap();
        Markdown.text(&StageTable::new(&report, &manifest).unwrap())
    }

    #[test]
    fn steps_stand_beside_those_of_the_paper() {
        let stages = [
            ("grid", 1.0),
            ("ground", 0.25),
            ("walls", 0.5),
            ("foreground", 0.125),
            ("dense_level", 0.25),
            ("merge", 0.25),
            ("separation", 0.5),
            ("boxes", 0.5),
            ("features", 0.75),
            ("regrouping", 0.375),
        ];
        insta::assert_snapshot!(table(&stages), @r"
        **Median times of the stages of hierarchical in ms, on Example CPU @ 2 GHz.**

        | step | stages | paper | main_road (simulated): p50 |
        | :-- | :-- | --: | --: |
        | grid | grid | 13 | 1.00 |
        | segmentation | ground, walls, foreground | 4 | 0.88 |
        | separation | dense_level, merge, separation | 6 | 1.00 |
        | features | boxes, features | 18 | 1.25 |
        | SVM | classification | 2 | –¹ |
        | not in the paper | regrouping |  | 0.38 |
        | **whole** |  | 43 | 9.50 |

        - A step with several stages has the sum of their medians. paper: VM section 6, with another machine, other scans and fewer features (eight); for orientation.
        - ¹ undefined: no scan was timed.
        ");
    }

    #[test]
    fn a_run_without_the_detector_has_no_such_table() {
        let mut manifest = sample::manifest();
        manifest.detectors.remove(0);
        assert_eq!(StageTable::new(&sample::report(), &manifest), None);
    }
}
