//! Scores of detectors under one condition after another: a table, and `robustness.csv` with one row for every condition,
//! task and detector.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::{Fixed, percent_or_dash};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{INTERVAL_TITLE, about_interval};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::task_grids::interval_cell;
use crate::tables::task_table::{MeasuredRow, Score, TableRow, TaskTable};
use crate::vocabulary::task::Task;

const TITLE: &str = "F-rate in % under each condition (all simulated).";

/// A condition, and the data set of a run that was driven under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedCondition {
    /// The group of the condition, such as `sensor`.
    pub group: String,
    /// Its name, such as `vlp-16`.
    pub condition: String,
    /// Whether trees that come with the program were trained under it, on other drives.
    pub trained: bool,
    /// Id of the data set.
    pub dataset: String,
}

/// The scores under one condition.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionScores {
    /// The condition.
    pub named: NamedCondition,
    /// The scores of each detector in each of [`Task::ALL`], in the order of the columns.
    pub detectors: Vec<(String, [Score; 2])>,
}

impl ConditionScores {
    /// The scores: detector by detector, and task by task.
    pub fn scores(&self) -> impl Iterator<Item = (&str, Task, &Score)> {
        self.detectors.iter().flat_map(|(detector, scores)| {
            Task::ALL.into_iter().zip(scores).map(move |(task, it)| (detector.as_str(), task, it))
        })
    }
}

/// The scores under each of `conditions`, from the tables of both tasks of a run over their data sets. Conditions without a
/// row in a table are left out.
pub fn condition_scores(conditions: &[NamedCondition], tables: &[TaskTable]) -> Vec<ConditionScores> {
    let [Some(first), Some(second)] = Task::ALL.map(|task| tables.iter().find(|it| it.task == task)) else {
        return Vec::new();
    };
    let scores = conditions.iter().filter_map(|named| {
        let [rows, others] = [row_of(first, &named.dataset)?, row_of(second, &named.dataset)?];
        let scores = rows.scores.iter().zip(&others.scores).map(|(one, other)| [*one, *other]);
        let detectors = first.detectors.iter().cloned().zip(scores).collect();
        Some(ConditionScores { named: named.clone(), detectors })
    });
    scores.collect()
}

fn row_of<'a>(table: &'a TaskTable, dataset: &str) -> Option<&'a MeasuredRow> {
    table.rows.iter().find_map(|it| match it {
        TableRow::Measured(row) if row.extent.name() == dataset => Some(row),
        _ => None,
    })
}

/// One row a condition, the F-rates of both tasks for each detector, and beneath it their intervals.
#[derive(Debug, Clone, Copy)]
pub struct RobustnessTable<'a> {
    /// The scores.
    pub conditions: &'a [ConditionScores],
    /// The notes beneath.
    pub notes: &'a [String],
}

impl Tabular for RobustnessTable<'_> {
    fn sheet(&self) -> Sheet {
        let scores = self.conditions.iter().flat_map(ConditionScores::scores);
        let kind = scores.filter_map(|(.., it)| it.intervals.f_rate).map(|it| it.blocks.kind).next();
        let about_intervals = kind.map(|it| format!("{INTERVAL_TITLE}: {}", about_interval(it)));
        let sentences = self.notes.iter().cloned().chain(about_intervals).collect();
        Sheet::of(TITLE.to_owned(), grid(self.conditions), sentences).labelled("robustness")
    }
}

fn grid(conditions: &[ConditionScores]) -> Grid {
    let of_tasks = |group: &str| ["obj", "veh"].map(|title| Column::number(title).within(group));
    let mut columns = vec![Column::left("kind"), Column::left("condition")];
    columns.extend(of_tasks("NO"));
    for (detector, _) in conditions.first().map_or(&[][..], |it| &it.detectors) {
        columns.extend(of_tasks(detector));
    }
    let mut group_before = "";
    let mut lines = Vec::new();
    for it in conditions {
        let group = if it.named.group == group_before { "" } else { &it.named.group };
        group_before = &it.named.group;
        lines.push(line(group, it));
        lines.extend(interval_line(it));
    }
    Grid { columns, lines }
}

fn line(group: &str, scores: &ConditionScores) -> Line {
    // Which annotations count does not depend on the detector.
    let no = |task: usize| {
        scores.detectors.first().map_or_else(|| "–".to_owned(), |(_, it)| it[task].counts.no().to_string())
    };
    let NamedCondition { condition, trained, .. } = &scores.named;
    let condition = if *trained { format!("{condition} ✓") } else { condition.clone() };
    let texts = [group.to_owned(), condition, no(0), no(1)];
    let rates = scores.scores().map(|(.., it)| percent_or_dash(it.counts.f_rate()));
    Line { kind: LineKind::Dataset, cells: texts.into_iter().chain(rates).map(Cell::new).collect() }
}

/// Intervals of the rates of the line above; `None` if none is known.
fn interval_line(scores: &ConditionScores) -> Option<Line> {
    let intervals: Vec<_> = scores.scores().map(|(.., it)| it.intervals.f_rate).collect();
    intervals.iter().any(Option::is_some).then(|| {
        let labels = [Cell::default(), Cell::new(INTERVAL_TITLE), Cell::default(), Cell::default()];
        let cells = labels.into_iter().chain(intervals.into_iter().map(interval_cell)).collect();
        Line { kind: LineKind::Detail, cells }
    })
}

row! {
    /// What one detector found under one condition, with what the rates are made of.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct ConditionRow {
        data: String,
        group: String,
        condition: String,
        trained: bool,
        task: Task,
        detector: String,
        n_scans: u64,
        no: u64,
        tp: u64,
        mo: u64,
        fo: Option<u64>,
        precision: Option<Fixed<4>>,
        recall: Option<Fixed<4>>,
        f_rate: Option<Fixed<4>>,
        f_rate_low: Option<Fixed<4>>,
        f_rate_high: Option<Fixed<4>>,
        few_blocks: Option<bool>,
    }
}

impl ConditionRow {
    /// The rows of a condition that was simulated.
    pub fn simulated(scores: &ConditionScores) -> Vec<Self> {
        let row = |(detector, task, score): (&str, Task, &Score)| {
            let (counts, f_rate_within) = (score.counts, score.intervals.f_rate);
            Self {
                data: "simulated".to_owned(),
                group: scores.named.group.clone(),
                condition: scores.named.condition.clone(),
                trained: scores.named.trained,
                task,
                detector: detector.to_owned(),
                n_scans: score.n_scans,
                no: counts.no(),
                tp: counts.tp(),
                mo: counts.mo(),
                fo: counts.fo(),
                precision: counts.precision().map(Fixed),
                recall: counts.recall().map(Fixed),
                f_rate: counts.f_rate().map(Fixed),
                f_rate_low: f_rate_within.map(|it| Fixed(it.ends[0])),
                f_rate_high: f_rate_within.map(|it| Fixed(it.ends[1])),
                few_blocks: f_rate_within.map(|it| it.blocks.decide_nothing()),
            }
        };
        scores.scores().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::rows::counts::Counts;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::sample;
    use crate::tables::task_table::RateIntervals;

    fn scores(group: &str, condition: &str, tp: u64) -> ConditionScores {
        let score = |no, tp, fo, f_rate| Score {
            n_scans: 6,
            counts: Counts::new(no, tp, Some(fo)).unwrap(),
            intervals: RateIntervals { f_rate, ..RateIntervals::default() },
            ..Score::default()
        };
        let blocks = BlockCount { n_blocks: 6, degrees_of_freedom: 5, kind: BlockKind::Seconds };
        let interval = (tp != 30).then_some(Interval { ends: [0.25, 0.625], blocks });
        let detector =
            |name: &str, tp| (name.to_owned(), [score(200, tp, 50, interval), score(0, 0, 0, None)]);
        let trained = condition == "vlp-16";
        let [group, condition, dataset] = [group, condition, ""].map(str::to_owned);
        ConditionScores {
            named: NamedCondition { group, condition, trained, dataset },
            detectors: vec![detector("grid", tp), detector("tree", tp / 2)],
        }
    }

    fn conditions() -> [ConditionScores; 3] {
        [
            scores("standard", "as drawn", 100),
            scores("sensor", "vlp-16", 30),
            scores("sensor", "os1-128", 120),
        ]
    }

    #[test]
    fn conditions_of_a_kind_stand_together_and_rates_over_nothing_are_undefined() {
        let (conditions, notes) = (conditions(), ["A note.".to_owned()]);
        let table = RobustnessTable { conditions: &conditions, notes: &notes };
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&table), @r"
        F-rate in % under each condition (all simulated).

                                     NO        grid        tree
                                  ────────   ─────────   ─────────
        kind      condition       obj  veh    obj  veh    obj  veh
        ──────────────────────────────────────────────────────────
        standard  as drawn        200    0   57.1    –   33.3    –
                  95 % interval        25.0–62.5§  25.0–62.5§
        sensor    vlp-16 ✓        200    0   21.4    –   11.3    –
                  os1-128         200    0   64.9    –   38.7    –
                  95 % interval        25.0–62.5§  25.0–62.5§

        A note.
        95 % interval: cluster bootstrap, 10000 resamples; each second of driving is one block, because
          there are fewer than 10 drives: the intervals cover other scans of the same drives, but not other
          drives.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
    }

    #[test]
    fn conditions_are_data_sets_of_a_run() {
        let named = |dataset: &str| NamedCondition {
            group: "road".to_owned(),
            condition: dataset.to_uppercase(),
            trained: false,
            dataset: dataset.to_owned(),
        };
        let tables = sample::tables();
        let scores = condition_scores(&[named("main_road"), named("nowhere")], &tables);
        let [scores] = &scores[..] else { panic!("{scores:?}") };
        assert_eq!(scores.named.condition, "MAIN_ROAD");
        let TableRow::Measured(row) = &tables[0].rows[0] else { panic!("no row") };
        for ((_, [of_objects, _]), score) in scores.detectors.iter().zip(&row.scores) {
            assert!(of_objects.n_scans == 20 && score.intervals.f_rate.is_some());
            assert_eq!(of_objects, score);
        }
        assert_eq!(condition_scores(&[named("main_road")], &tables[..1]), []);
    }

    #[test]
    fn rows_hold_what_the_rates_are_made_of() {
        let rows = ConditionRow::simulated(&conditions()[0]);
        let text = csv_text(&rows);
        insta::assert_snapshot!(text, @r"
        data,group,condition,trained,task,detector,n_scans,no,tp,mo,fo,precision,recall,f_rate,f_rate_low,f_rate_high,few_blocks
        simulated,standard,as drawn,false,objects,grid,6,200,100,100,50,0.6667,0.5000,0.5714,0.2500,0.6250,true
        simulated,standard,as drawn,false,vehicles,grid,6,0,0,0,0,,,,,,
        simulated,standard,as drawn,false,objects,tree,6,200,50,150,50,0.5000,0.2500,0.3333,0.2500,0.6250,true
        simulated,standard,as drawn,false,vehicles,tree,6,0,0,0,0,,,,,,
        ");
        assert_eq!(rows_of::<ConditionRow>(&text).unwrap().len(), rows.len());
    }
}
