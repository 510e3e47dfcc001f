//! The table of the times of the stages of each detector; those of the papers stand beside the published times.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::run_folder::manifest::Manifest;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Undefined};
use crate::tables::paper_figures::{PAPER_DETECTOR, VEHICLE_STEPS};
use crate::tables::sheet::{Sheet, Tabular};
use crate::vocabulary::metric::{LatencyStatistic, Metric};

/// The median time of each stage on each data set of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTable {
    grid: Grid,
    cpu_model: String,
    has_published: bool,
}

/// The stages of a detector.
struct StagesOfDetector<'a> {
    detector: &'a str,
    /// Its rows for each data set.
    rows: Vec<Vec<&'a MetricRow>>,
    lines: Vec<TimedStages>,
}

/// One line: a stage, or all stages of a step that a paper times.
struct TimedStages {
    stages: Vec<String>,
    /// The name of the step, and its published time in milliseconds.
    published: Option<(&'static str, f64)>,
}

impl StageTable {
    /// The stages of all detectors in `report`, one after the other; `None` if no detector has any.
    pub fn new(report: &RunReport, manifest: &Manifest) -> Option<Self> {
        let of_detector = |name| StagesOfDetector::of(name, report, manifest);
        let detectors = manifest.detectors.iter().filter_map(|it| of_detector(it.name.as_str()));
        let detectors: Vec<StagesOfDetector<'_>> = detectors.collect();
        let has_published = detectors.iter().flat_map(|it| &it.lines).any(|it| it.published.is_some());
        let mut columns = ["detector", "stages"].map(Column::left).to_vec();
        if has_published {
            columns.extend([Column::left("published step"), Column::number("published")]);
        }
        columns.extend(manifest.datasets.iter().map(|it| {
            let simulated = if it.simulated { " (simulated)" } else { "" };
            Column::number("p50").within(format!("{}{simulated}", it.id))
        }));
        let mut lines: Vec<Line> = detectors.iter().flat_map(StagesOfDetector::lines).collect();
        if !has_published {
            for line in &mut lines {
                line.cells.drain(2..4);
            }
        }
        let cpu_model = manifest.machine.cpu_model.clone();
        (!lines.is_empty()).then_some(Self { grid: Grid { columns, lines }, cpu_model, has_published })
    }
}

impl<'a> StagesOfDetector<'a> {
    /// The stages of `detector`; `None` if none was timed.
    fn of(detector: &'a str, report: &'a RunReport, manifest: &Manifest) -> Option<Self> {
        let task = report.first_task()?;
        let rows_of = |dataset: &str| -> Vec<&MetricRow> {
            let subject = Subject::of_all(dataset, task, detector);
            report.rows().iter().filter(|it| it.subject == subject).collect()
        };
        let rows: Vec<Vec<&MetricRow>> = manifest.datasets.iter().map(|it| rows_of(&it.id)).collect();
        let mut stages: Vec<String> = Vec::new();
        for row in rows.iter().flatten() {
            match &row.metric {
                Metric::StageP50(stage) if !stages.contains(stage) => stages.push(stage.clone()),
                _ => {}
            }
        }
        let lines = lines_of(stages, detector);
        (!lines.is_empty()).then_some(Self { detector, rows, lines })
    }

    /// The line of the whole detector, and those of its stages.
    fn lines(&self) -> Vec<Line> {
        let p50 = Metric::Latency(LatencyStatistic::P50);
        let whole = self.rows.iter().map(|rows| median_ms(rows, &p50));
        // For a detector with other stages than the paper has, the sum would say nothing.
        let is_published = self.lines.iter().all(|it| it.published.is_some());
        let published_ms = self.lines.iter().filter_map(|it| Some(it.published?.1)).sum();
        let published = is_published.then_some(("", published_ms));
        let whole = line(LineKind::Overall, [self.detector, "whole"], published, whole);
        let stages = self.lines.iter().map(|TimedStages { stages, published }| {
            let sums = self.rows.iter().map(|rows| {
                stages.iter().map(|it| median_ms(rows, &Metric::StageP50(it.clone()))).sum::<Option<f64>>()
            });
            line(LineKind::Detail, ["", &stages.join(", ")], *published, sums)
        });
        [whole].into_iter().chain(stages).collect()
    }
}

/// Each of `stages` in a line; for the papers' detector those of one step of the paper in one line.
fn lines_of(mut stages: Vec<String>, detector: &str) -> Vec<TimedStages> {
    let mut lines = Vec::new();
    for step in VEHICLE_STEPS.iter().filter(|_| detector == PAPER_DETECTOR) {
        if step.stages.iter().all(|it| stages.iter().any(|stage| stage == it)) {
            stages.retain(|it| !step.stages.contains(&it.as_str()));
            let of_step = step.stages.iter().map(|it| (*it).to_owned()).collect();
            lines.push(TimedStages { stages: of_step, published: Some((step.name, step.ms)) });
        }
    }
    lines.extend(stages.into_iter().map(|it| TimedStages { stages: vec![it], published: None }));
    lines
}

fn median_ms(rows: &[&MetricRow], metric: &Metric) -> Option<f64> {
    rows.iter().find(|it| it.metric == *metric).and_then(|it| it.value())
}

fn line(
    kind: LineKind,
    names: [&str; 2],
    published: Option<(&str, f64)>,
    ours_ms: impl Iterator<Item = Option<f64>>,
) -> Line {
    let ms_cell = |ms: Option<f64>| {
        ms.map_or_else(|| Cell::undefined(Undefined::NotTimed), |it| Cell::new(fixed_decimals(it, 2)))
    };
    let published = published.map_or_else(Default::default, |(step, ms)| {
        // As printed.
        [Cell::new(step), Cell::new(fixed_decimals(ms, 0))]
    });
    let cells = names.map(Cell::new).into_iter().chain(published).chain(ours_ms.map(ms_cell)).collect();
    Line { kind, cells }
}

impl Tabular for StageTable {
    fn sheet(&self) -> Sheet {
        let title = format!("Median times of stages in ms, on {}.", self.cpu_model);
        let about_published = "published: section 6 of the vehicle paper (VM: Börcs, Nagy, Baticz, Benedek), with another machine and other scans; for orientation. Several stages of a step \
             have the sum of their medians.";
        let sentences = self.has_published.then(|| about_published.to_owned()).into_iter().collect();
        Sheet::of(title, self.grid.clone(), sentences).labelled("stages")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::tables::sample;
    use crate::vocabulary::task::Task;

    /// The table of detectors with the times of their stages.
    fn table(detectors: &[(&str, &[(&str, f64)])]) -> Option<String> {
        let mut manifest = sample::manifest();
        manifest.datasets.truncate(1);
        manifest.detectors.clear();
        let mut rows = Vec::new();
        for (detector, stages) in detectors {
            manifest.detectors.push(sample::detector(detector));
            let stages = stages.iter().map(|(stage, ms)| (Metric::StageP50((*stage).to_owned()), *ms));
            let times = stages.chain([(Metric::Latency(LatencyStatistic::P50), 9.5)]);
            let subject = || Subject::of_all("main_road", Task::Objects, detector);
            rows.extend(times.map(|(metric, ms)| MetricRow::new(subject(), metric, Some(ms), 20)));
        }
        let report = RunReport::new(1, rows).unwrap();
        Some(Markdown.text(&StageTable::new(&report, &manifest)?))
    }

    const OF_PAPER: [(&str, f64); 10] = [
        ("grid", 1.0),
        ("ground", 0.25),
        ("walls", 0.5),
        ("foreground", 0.125),
        ("dense_level", 0.25),
        ("merge", 0.25),
        ("separation", 0.5),
        ("boxes", 0.5),
        ("features", 0.75),
        ("classification", 0.375),
    ];

    #[test]
    fn published_steps_stand_beside_the_detector_of_the_papers_alone() {
        let of_tree = [("grid", 1.5), ("best_cut", 0.5)];
        let text = table(&[("hierarchical", &of_tree), ("paper", &OF_PAPER), ("theirs", &[])]).unwrap();
        insta::assert_snapshot!(text, @r"
        **Median times of stages in ms, on Example CPU @ 2 GHz.**

        | detector | stages | published step | published | main_road (simulated): p50 |
        | :-- | :-- | :-- | --: | --: |
        | **hierarchical** | whole |  |  | 9.50 |
        |  | grid |  |  | 1.50 |
        |  | best_cut |  |  | 0.50 |
        | **paper** | whole |  | 43 | 9.50 |
        |  | grid | grid | 13 | 1.00 |
        |  | ground, walls, foreground | segmentation | 4 | 0.88 |
        |  | dense_level, merge, separation | separation | 6 | 1.00 |
        |  | boxes, features | features | 18 | 1.25 |
        |  | classification | SVM | 2 | 0.38 |

        - published: section 6 of the vehicle paper (VM: Börcs, Nagy, Baticz, Benedek), with another machine and other scans; for orientation. Several stages of a step have the sum of their medians.
        ");
    }

    #[test]
    fn a_step_with_a_stage_that_is_left_out_is_not_that_of_the_paper() {
        let without_model: Vec<_> = OF_PAPER.into_iter().filter(|(stage, _)| *stage != "features").collect();
        let text = table(&[("paper", &without_model)]).unwrap();
        check_holds(
            &text,
            &["|  | boxes |  |  | 0.50 |", "| **paper** | whole |  |  | 9.50 |", "| grid | grid | 13 |"],
        );
        assert!(!text.contains("undefined"), "{text}");
    }

    #[test]
    fn without_the_papers_nothing_is_published() {
        let text = table(&[("hierarchical", &[("grid", 1.5)])]).unwrap();
        assert!(text.contains("|  | grid | 1.50 |") && !text.contains("published"), "{text}");
    }

    #[test]
    fn detectors_without_stages_have_no_such_table() {
        assert_eq!(table(&[("theirs", &[])]), None);
    }
}
