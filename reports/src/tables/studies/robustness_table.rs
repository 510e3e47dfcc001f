//! The table of what detectors find under one condition after another.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::condition_scores::{ConditionScores, DetectorRates, RateOfTask};
use crate::rows::counts::Counts;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{INTERVAL_TITLE, about_interval};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::task_grids::interval_cell;
use crate::tables::task_table::{MeasuredRow, TableRow, TaskTable};
use crate::vocabulary::task::Task;

const TITLE: &str = "F-rate in % under each condition (all simulated).";

/// A condition, and the data set of a run that was driven under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedCondition {
    /// What conditions of this kind have in common.
    pub group: String,
    /// Its name.
    pub condition: String,
    /// Whether trees that come with the program were trained under it, on other drives.
    pub trained: bool,
    /// Id of the data set.
    pub dataset: String,
}

/// What was found under each of `conditions`, from the tables of both tasks of a run over their data sets. What a table has not
/// is left out.
pub fn condition_scores(conditions: &[NamedCondition], tables: &[TaskTable]) -> Vec<ConditionScores> {
    let [Some(objects), Some(vehicles)] = Task::ALL.map(|task| tables.iter().find(|it| it.task == task))
    else {
        return Vec::new();
    };
    let scores = conditions.iter().filter_map(|it| {
        let rows = (row_of(objects, &it.dataset)?, row_of(vehicles, &it.dataset)?);
        let detectors = objects.detectors.iter().enumerate().map(|(detector_idx, detector)| {
            let rate = |row: &MeasuredRow| {
                let score = &row.scores[detector_idx];
                RateOfTask { counts: score.counts, f_rate_within: score.intervals.f_rate }
            };
            DetectorRates { detector: detector.clone(), objects: rate(rows.0), vehicles: rate(rows.1) }
        });
        Some(ConditionScores {
            group: it.group.clone(),
            condition: it.condition.clone(),
            trained: it.trained,
            n_scans: rows.0.scores.first()?.n_scans,
            detectors: detectors.collect(),
        })
    });
    scores.collect()
}

fn row_of<'a>(table: &'a TaskTable, dataset: &str) -> Option<&'a MeasuredRow> {
    table.rows.iter().find_map(|it| match it {
        TableRow::Measured(row) if row.extent.name() == dataset => Some(row),
        _ => None,
    })
}

/// One row a condition, the F-rates of both tasks for each detector, and beneath it how sure they are.
#[derive(Debug, Clone, Copy)]
pub struct RobustnessTable<'a> {
    /// What was found.
    pub conditions: &'a [ConditionScores],
    /// What has to be said beneath.
    pub notes: &'a [String],
}

impl Tabular for RobustnessTable<'_> {
    fn sheet(&self) -> Sheet {
        let rates = self.conditions.iter().flat_map(|it| &it.detectors).flat_map(DetectorRates::tasks);
        let kind = rates.filter_map(|(_, it)| it.f_rate_within).map(|it| it.blocks.kind).next();
        let about_intervals = kind.map(|it| format!("{INTERVAL_TITLE}: {}", about_interval(it)));
        let sentences = self.notes.iter().cloned().chain(about_intervals).collect();
        Sheet::of(TITLE.to_owned(), grid(self.conditions), sentences).labelled("robustness")
    }
}

fn grid(conditions: &[ConditionScores]) -> Grid {
    let of_tasks = |group: &str| ["obj", "veh"].map(|title| Column::number(title).within(group));
    let mut columns = vec![Column::left("kind"), Column::left("condition")];
    columns.extend(of_tasks("NO"));
    for it in conditions.first().map_or(&[][..], |it| &it.detectors) {
        columns.extend(of_tasks(&it.detector));
    }
    let mut group_before = "";
    let mut lines = Vec::new();
    for it in conditions {
        let group = if it.group == group_before { "" } else { &it.group };
        group_before = &it.group;
        lines.push(line(group, it));
        lines.extend(interval_line(it));
    }
    Grid { columns, lines }
}

fn line(group: &str, scores: &ConditionScores) -> Line {
    // Which annotations count does not depend on the detector.
    let no = |task: fn(&DetectorRates) -> Counts| {
        scores.detectors.first().map_or_else(|| "–".to_owned(), |it| task(it).no().to_string())
    };
    let condition =
        if scores.trained { format!("{} ✓", scores.condition) } else { scores.condition.clone() };
    let texts = [group.to_owned(), condition, no(|it| it.objects.counts), no(|it| it.vehicles.counts)];
    let percent = |rate: Option<f64>| rate.map_or_else(|| "–".to_owned(), |it| fixed_decimals(100.0 * it, 1));
    let rates =
        scores.detectors.iter().flat_map(|it| it.tasks().map(|(_, rate)| percent(rate.counts.f_rate())));
    Line { kind: LineKind::Dataset, cells: texts.into_iter().chain(rates).map(Cell::new).collect() }
}

/// How sure the rates of the line above are; `None` if that is known of none.
fn interval_line(scores: &ConditionScores) -> Option<Line> {
    let intervals: Vec<_> =
        scores.detectors.iter().flat_map(|it| it.tasks().map(|(_, rate)| rate.f_rate_within)).collect();
    intervals.iter().any(Option::is_some).then(|| {
        let labels = [Cell::default(), Cell::new(INTERVAL_TITLE), Cell::default(), Cell::default()];
        let cells = labels.into_iter().chain(intervals.into_iter().map(interval_cell)).collect();
        Line { kind: LineKind::Detail, cells }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::sample;
    use crate::tables::studies::condition_row::ConditionRow;

    fn scores(group: &str, condition: &str, tp: u64) -> ConditionScores {
        let rate = |no, tp, fo, f_rate_within| RateOfTask {
            counts: Counts::new(no, tp, Some(fo)).unwrap(),
            f_rate_within,
        };
        let blocks = BlockCount { n_blocks: 6, degrees_of_freedom: 5, kind: BlockKind::Seconds };
        let interval = (tp != 30).then_some(Interval { ends: [0.25, 0.625], blocks });
        let detector = |name: &str, tp| DetectorRates {
            detector: name.to_owned(),
            objects: rate(200, tp, 50, interval),
            vehicles: rate(0, 0, 0, None),
        };
        ConditionScores {
            group: group.to_owned(),
            condition: condition.to_owned(),
            trained: condition == "vlp-16",
            n_scans: 6,
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
        95 % interval: cluster bootstrap, 10000 resamples of seconds, because there are fewer than 10
          drives: they cover other scans of the same drives, but not other drives.
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
        assert_eq!((scores.condition.as_str(), scores.n_scans), ("MAIN_ROAD", 20));
        let TableRow::Measured(row) = &tables[0].rows[0] else { panic!("no row") };
        for (detector, score) in scores.detectors.iter().zip(&row.scores) {
            assert_eq!(detector.objects.counts, score.counts);
            assert!(score.intervals.f_rate.is_some());
            assert_eq!(detector.objects.f_rate_within, score.intervals.f_rate);
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
