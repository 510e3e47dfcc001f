//! The table of the worth of each part of a method.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::run_report::RunReport;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Undefined};
use crate::tables::notes::{INTERVAL_TITLE, about_interval, about_matching};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::studies::ablation_score::AblationScore;
use crate::tables::task_grids::{extent_cell, interval_cell, rate_cell, recall_cell};
use crate::tables::task_table::TaskTable;
use crate::vocabulary::task::Task;

/// Scores of the variants, and the facts that they share.
#[derive(Debug, Clone, PartialEq)]
pub struct AblationTable {
    /// The method whose parts are left out.
    pub method: String,
    /// The task.
    pub task: Task,
    /// When a detection matches an annotation, in words.
    pub matching_criterion: String,
    /// The processor that the times were taken on.
    pub cpu_model: String,
    /// Data set by data set and then overall, and within these variant by variant.
    pub scores: Vec<AblationScore>,
}

impl Tabular for AblationTable {
    fn sheet(&self) -> Sheet {
        let Self { method, task, matching_criterion, .. } = self;
        let title =
            format!("Ablation of {method}. Task {task}. Rates in %. {}", about_matching(matching_criterion));
        let kind = self.scores.iter().find_map(|it| it.f_rate_within).map(|it| it.blocks.kind);
        let about_intervals = kind.map(|kind| {
            format!(
                "{INTERVAL_TITLE}: of the F-rate alone, {} All variants look at the same scans: scanbench compare shows the \
                 intervals of their differences.",
                about_interval(kind)
            )
        });
        let mut sentences = vec![
            "NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). P: precision, \
             TP / ND. R: recall, TP / NO."
                .to_owned(),
            "over: oversegmentation, the share of NO that is split: at least two detections each have a tenth of its points. \
             under: undersegmentation, the share of held that joins several; held: detections that have more than half of \
             the points of an annotation."
                .to_owned(),
            format!(
                "p50: median time of detection per scan, with all variants in turns, on {}. overall: ratios of \
                 summed counts, and medians over all scans.",
                self.cpu_model
            ),
        ];
        sentences.extend(about_intervals);
        Sheet::of(title, self.grid(), sentences).labelled("ablation")
    }
}

impl AblationTable {
    /// The scores of the variants of `method`, which are the detectors of the run that `report` is of, in the task of
    /// `table`.
    pub fn new(method: &str, table: &TaskTable, report: &RunReport) -> Self {
        Self {
            method: method.to_owned(),
            task: table.task,
            matching_criterion: table.matching_criterion.clone(),
            cpu_model: table.cpu_model.clone(),
            scores: AblationScore::all(table, report),
        }
    }

    fn grid(&self) -> Grid {
        let titles =
            ["scans", "NO", "ND", "F-rate", INTERVAL_TITLE, "P", "R", "over", "held", "under", "p50 ms"];
        let numbers = titles.map(Column::number);
        let columns = [Column::left("data set")].into_iter().chain(numbers).collect();
        let of_extents = self.scores.chunk_by(|left, right| left.extent == right.extent);
        let lines =
            of_extents.flat_map(|scores| [head(&scores[0])].into_iter().chain(scores.iter().map(line)));
        Grid { columns, lines: lines.collect() }
    }
}

/// The head line of a data set, with the cells that all variants share.
fn head(score: &AblationScore) -> Line {
    let mut cells = vec![extent_cell(&score.extent, score.origin)];
    cells.extend([score.n_scans, score.counts.no()].map(|it| Cell::new(it.to_string())));
    cells.resize(12, Cell::default());
    Line { kind: LineKind::of(&score.extent), cells }
}

fn line(score: &AblationScore) -> Line {
    let counts = score.counts;
    let percent = |rate: Option<f64>| match rate {
        Some(rate) => Cell::new(fixed_decimals(100.0 * rate, 1)),
        None => Cell::undefined(Undefined::ZeroDenominator),
    };
    let n_detections = counts.nd().map(|it| Cell::new(it.to_string()));
    let p50_ms = score.latency_p50_ms.map(|it| Cell::new(fixed_decimals(it, 2)));
    let cells = vec![
        Cell::new(score.variant.clone()),
        Cell::default(),
        Cell::default(),
        n_detections.unwrap_or(Cell::undefined(Undefined::FalseObjectsUnknown)),
        rate_cell(counts.f_rate(), counts),
        interval_cell(score.f_rate_within),
        rate_cell(counts.precision(), counts),
        recall_cell(counts),
        percent(score.over_segmentation),
        Cell::new(score.n_holding.to_string()),
        percent(score.under_segmentation),
        p50_ms.unwrap_or(Cell::undefined(Undefined::NotTimed)),
    ];
    Line { kind: LineKind::Detail, cells }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::csv_text;
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::rows::counts::Counts;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::studies::ablation_score::AblationRow;
    use crate::vocabulary::extent::Extent;
    use crate::vocabulary::origin::Origin;

    fn interval() -> Interval {
        let blocks = BlockCount { n_blocks: 9, degrees_of_freedom: 8, kind: BlockKind::Seconds };
        Interval { ends: [0.75, 0.85], blocks }
    }

    fn score(extent: Extent, origin: Origin, variant: &str, tp: u64, fo: Option<u64>) -> AblationScore {
        AblationScore {
            extent,
            origin,
            variant: variant.to_owned(),
            n_scans: 20,
            counts: Counts::new(100, tp, fo).unwrap(),
            f_rate_within: fo.filter(|_| tp > 0).map(|_| interval()),
            over_segmentation: Some(0.05),
            n_holding: tp,
            under_segmentation: (tp > 0).then(|| 10.0 / tp as f64),
            latency_min_ms: Some(3.5),
            latency_p50_ms: Some(4.25),
        }
    }

    fn table() -> AblationTable {
        let dataset = |id: &str| Extent::Dataset(id.to_owned());
        let (whole, less) = ("whole method", "without terrain");
        AblationTable {
            method: "hierarchical".to_owned(),
            task: Task::Objects,
            matching_criterion: "points, IoU at least 0.5".to_owned(),
            cpu_model: "Example CPU @ 2 GHz".to_owned(),
            scores: vec![
                score(dataset("street"), Origin::Simulated, whole, 80, Some(20)),
                score(dataset("street"), Origin::Simulated, less, 0, Some(0)),
                score(dataset("kitti"), Origin::Recorded, whole, 90, None),
                score(dataset("kitti"), Origin::Recorded, less, 50, None),
                score(Extent::OverallOf(Origin::Recorded), Origin::Recorded, whole, 85, None),
                score(Extent::OverallOf(Origin::Recorded), Origin::Recorded, less, 25, None),
            ],
        }
    }

    #[test]
    fn variants_stand_below_each_other() {
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&table()), @r"
        Ablation of hierarchical. Task objects. Rates in %. Matched by a point-set IoU of at least 0.5.

        data set            scans   NO    ND  F-rate  95 % interval     P     R  over  held  under  p50 ms
        ──────────────────────────────────────────────────────────────────────────────────────────────────
        street (simulated)     20  100
          whole method                  100     80.0     75.0–85.0§  80.0  80.0   5.0    80   12.5    4.25
          without terrain                 0      0.0                  –²    0.0   5.0     0    –²     4.25
        kitti                  20  100
          whole method                    –¹     –¹                   –¹   90.0   5.0    90   11.1    4.25
          without terrain                 –¹     –¹                   –¹   50.0   5.0    50   20.0    4.25
        ──────────────────────────────────────────────────────────────────────────────────────────────────
        overall (recorded)     20  100
          whole method                    –¹     –¹                   –¹   85.0   5.0    85   11.8    4.25
          without terrain                 –¹     –¹                   –¹   25.0   5.0    25   40.0    4.25

        NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). P:
          precision, TP / ND. R: recall, TP / NO.
        over: oversegmentation, the share of NO that is split: at least two detections each have a tenth of
          its points. under: undersegmentation, the share of held that joins several; held: detections that
          have more than half of the points of an annotation.
        p50: median time of detection per scan, with all variants in turns, on Example CPU @ 2 GHz. overall:
          ratios of summed counts, and medians over all scans.
        95 % interval: of the F-rate alone, cluster bootstrap, 10000 resamples; each second of driving is
          one block, because there are fewer than 10 drives: the intervals cover other scans of the same
          drives, but not other drives. All variants look at the same scans: scanbench compare shows the
          intervals of their differences.
        recorded: from a sensor.
        simulated: from a simulator, not recorded.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ¹ undefined: not every class of object is annotated, so false objects cannot be counted.
        ² undefined: the denominator is zero.
        ");
    }

    #[test]
    fn rows_of_the_file_stand_alone() {
        let rows: Vec<_> = table().scores.iter().map(|it| AblationRow::new(Task::Objects, it)).collect();
        insta::assert_snapshot!(csv_text(&rows), @r"
        task,dataset,origin,variant,n_scans,no,tp,mo,fo,f_rate,precision,recall,over_segmentation,n_holding,under_segmentation,latency_min_ms,latency_p50_ms,f_rate_low,f_rate_high,few_blocks
        objects,street,simulated,whole method,20,100,80,20,20,0.800000,0.800000,0.800000,0.050000,80,0.125000,3.5000,4.2500,0.750000,0.850000,true
        objects,street,simulated,without terrain,20,100,0,100,0,0.000000,,0.000000,0.050000,0,,3.5000,4.2500,,,
        objects,kitti,recorded,whole method,20,100,90,10,,,,0.900000,0.050000,90,0.111111,3.5000,4.2500,,,
        objects,kitti,recorded,without terrain,20,100,50,50,,,,0.500000,0.050000,50,0.200000,3.5000,4.2500,,,
        objects,overall-recorded,recorded,whole method,20,100,85,15,,,,0.850000,0.050000,85,0.117647,3.5000,4.2500,,,
        objects,overall-recorded,recorded,without terrain,20,100,25,75,,,,0.250000,0.050000,25,0.400000,3.5000,4.2500,,,
        ");
    }
}
