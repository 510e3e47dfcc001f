//! The table of what each part of a method is worth.

use crate::fixed_decimals::fixed_decimals;
use crate::table::ablation_score::AblationScore;
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind, Undefined};
use crate::table::notes::Notes;
use crate::table::task_grids::{extent_cell, rate_cell, recall_cell};
use crate::table::task_table::Extent;
use crate::table::{markdown, terminal};

/// Scores with what is to be said of them all.
#[derive(Debug, Clone, PartialEq)]
pub struct AblationTable {
    /// The method whose parts are left out.
    pub method: String,
    /// What is asked of it.
    pub task: String,
    /// When a detection matches an annotation, in words.
    pub matching_criterion: String,
    /// The processor that the times were taken on.
    pub cpu_model: String,
    /// Data set by data set and then overall, and within these variant by variant.
    pub scores: Vec<AblationScore>,
}

impl AblationTable {
    /// The table for a terminal.
    pub fn to_terminal(&self) -> String {
        let (grid, notes) = (self.grid(), self.notes());
        let mut text = format!("{}\n\n", self.title());
        terminal::write_grid(&mut text, &grid, &notes);
        text.push('\n');
        notes.sentences.iter().for_each(|it| text.push_str(&terminal::wrapped(it)));
        text
    }

    /// The table as Markdown.
    pub fn to_markdown(&self) -> String {
        let (grid, notes) = (self.grid(), self.notes());
        let mut text = format!("**{}**\n\n", markdown::escaped(&self.title()));
        markdown::write_grid(&mut text, &grid, &notes);
        text.push('\n');
        for sentence in &notes.sentences {
            markdown::push_line(&mut text, &format!("- {}", markdown::escaped(sentence)));
        }
        text
    }

    fn title(&self) -> String {
        let Self { method, task, matching_criterion, .. } = self;
        format!("Ablation of {method}. Task {task}. Rates in %. Matched by {matching_criterion}.")
    }

    fn notes(&self) -> Notes {
        let sentences = vec![
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
        Notes::beneath(&[self.grid()], sentences)
    }

    fn grid(&self) -> Grid {
        let column = |title, alignment| Column { group: None, title, alignment };
        let titles = ["scans", "NO", "ND", "F-rate", "P", "R", "over", "held", "under", "p50 ms"];
        let numbers = titles.map(|title| column(title, Alignment::Decimal));
        let columns = [column("data set", Alignment::Left)].into_iter().chain(numbers).collect();
        let of_extents = self.scores.chunk_by(|left, right| left.extent == right.extent);
        let lines =
            of_extents.flat_map(|scores| [head(&scores[0])].into_iter().chain(scores.iter().map(line)));
        Grid { columns, lines: lines.collect() }
    }
}

/// What all variants have in common on a data set.
fn head(score: &AblationScore) -> Line {
    let kind = match score.extent {
        Extent::Dataset(_) => LineKind::Dataset,
        Extent::Overall => LineKind::Overall,
    };
    let mut cells = vec![extent_cell(&score.extent, score.origin)];
    cells.extend([score.n_scans, score.counts.no()].map(|it| Cell::new(it.to_string())));
    cells.resize(11, Cell::default());
    Line { kind, cells }
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
        rate_cell(counts.precision(), counts),
        recall_cell(counts),
        percent(score.over_segmentation()),
        Cell::new(score.n_holding.to_string()),
        percent(score.under_segmentation()),
        p50_ms.unwrap_or(Cell::undefined(Undefined::NotTimed)),
    ];
    Line { kind: LineKind::Detail, cells }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Counts;
    use crate::csv_rows::to_csv_bytes;
    use crate::table::ablation_score::AblationRow;
    use crate::table::task_table::Origin;

    fn score(extent: Extent, origin: Origin, variant: &str, tp: u64, fo: Option<u64>) -> AblationScore {
        AblationScore {
            extent,
            origin,
            variant: variant.to_owned(),
            n_scans: 20,
            counts: Counts::new(100, tp, fo).unwrap(),
            n_split: 5,
            n_holding: tp,
            n_joining: 10,
            latency_min_ms: Some(3.5),
            latency_p50_ms: Some(4.25),
        }
    }

    fn table() -> AblationTable {
        let dataset = |id: &str| Extent::Dataset(id.to_owned());
        let (whole, less) = ("whole method", "without terrain");
        AblationTable {
            method: "hierarchical".to_owned(),
            task: "objects".to_owned(),
            matching_criterion: "points, IoU at least 0.5".to_owned(),
            cpu_model: "Example CPU @ 2 GHz".to_owned(),
            scores: vec![
                score(dataset("street"), Origin::Simulated, whole, 80, Some(20)),
                score(dataset("street"), Origin::Simulated, less, 0, Some(0)),
                score(dataset("kitti"), Origin::Recorded, whole, 90, None),
                score(dataset("kitti"), Origin::Recorded, less, 50, None),
                score(Extent::Overall, Origin::PartlySimulated, whole, 85, None),
                score(Extent::Overall, Origin::PartlySimulated, less, 25, None),
            ],
        }
    }

    #[test]
    fn variants_stand_below_each_other() {
        insta::assert_snapshot!(table().to_terminal(), @r"
        Ablation of hierarchical. Task objects. Rates in %. Matched by points, IoU at least 0.5.

        data set                    scans   NO    ND  F-rate     P     R  over  held  under  p50 ms
        ───────────────────────────────────────────────────────────────────────────────────────────
        street (simulated)             20  100
          whole method                          100     80.0  80.0  80.0   5.0    80   12.5    4.25
          without terrain                         0      0.0   –²    0.0   5.0     0    –²     4.25
        kitti                          20  100
          whole method                            –¹     –¹    –¹   90.0   5.0    90   11.1    4.25
          without terrain                         –¹     –¹    –¹   50.0   5.0    50   20.0    4.25
        ───────────────────────────────────────────────────────────────────────────────────────────
        overall (partly simulated)     20  100
          whole method                            –¹     –¹    –¹   85.0   5.0    85   11.8    4.25
          without terrain                         –¹     –¹    –¹   25.0   5.0    25   40.0    4.25

        NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). P:
          precision, TP / ND. R: recall, TP / NO.
        over: share of NO torn apart, at least two detections each holding a tenth of the points. under:
          share of held, the detections with more than half of the points of an annotation, that hold
          several.
        p50: median time of detection of a scan, all variants in turns on each, on Example CPU @ 2 GHz.
          overall: counts are summed and times put together before a ratio or a median is taken.
        simulated: made by a simulator, not recorded.
        partly simulated: summed over recorded and simulated data sets.
        ¹ undefined: not every class of object is annotated, so false objects cannot be known.
        ² undefined: the denominator is zero.
        ");
    }

    #[test]
    fn markdown_has_the_same_rows() {
        insta::assert_snapshot!(table().to_markdown(), @r"
        **Ablation of hierarchical. Task objects. Rates in %. Matched by points, IoU at least 0.5.**

        | data set | scans | NO | ND | F-rate | P | R | over | held | under | p50 ms |
        | :-- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |
        | street (*simulated*) | 20 | 100 |  |  |  |  |  |  |  |  |
        | whole method |  |  | 100 | 80.0 | 80.0 | 80.0 | 5.0 | 80 | 12.5 | 4.25 |
        | without terrain |  |  | 0 | 0.0 | –² | 0.0 | 5.0 | 0 | –² | 4.25 |
        | kitti | 20 | 100 |  |  |  |  |  |  |  |  |
        | whole method |  |  | –¹ | –¹ | –¹ | 90.0 | 5.0 | 90 | 11.1 | 4.25 |
        | without terrain |  |  | –¹ | –¹ | –¹ | 50.0 | 5.0 | 50 | 20.0 | 4.25 |
        | **overall** (*partly simulated*) | 20 | 100 |  |  |  |  |  |  |  |  |
        | whole method |  |  | –¹ | –¹ | –¹ | 85.0 | 5.0 | 85 | 11.8 | 4.25 |
        | without terrain |  |  | –¹ | –¹ | –¹ | 25.0 | 5.0 | 25 | 40.0 | 4.25 |

        - NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). P: precision, TP / ND. R: recall, TP / NO.
        - over: share of NO torn apart, at least two detections each holding a tenth of the points. under: share of held, the detections with more than half of the points of an annotation, that hold several.
        - p50: median time of detection of a scan, all variants in turns on each, on Example CPU @ 2 GHz. overall: counts are summed and times put together before a ratio or a median is taken.
        - simulated: made by a simulator, not recorded.
        - partly simulated: summed over recorded and simulated data sets.
        - ¹ undefined: not every class of object is annotated, so false objects cannot be known.
        - ² undefined: the denominator is zero.
        ");
    }

    #[test]
    fn rows_of_the_file_stand_alone() {
        let rows: Vec<_> = table().scores.iter().map(|it| AblationRow::new("objects", it)).collect();
        insta::assert_snapshot!(String::from_utf8(to_csv_bytes(&rows).unwrap()).unwrap(), @r"
        task,dataset,origin,variant,n_scans,no,tp,mo,fo,f_rate,precision,recall,n_split,over_segmentation,n_holding,n_joining,under_segmentation,latency_min_ms,latency_p50_ms
        objects,street,simulated,whole method,20,100,80,20,20,0.800000,0.800000,0.800000,5,0.050000,80,10,0.125000,3.5000,4.2500
        objects,street,simulated,without terrain,20,100,0,100,0,0.000000,,0.000000,5,0.050000,0,10,,3.5000,4.2500
        objects,kitti,recorded,whole method,20,100,90,10,,,,0.900000,5,0.050000,90,10,0.111111,3.5000,4.2500
        objects,kitti,recorded,without terrain,20,100,50,50,,,,0.500000,5,0.050000,50,10,0.200000,3.5000,4.2500
        objects,overall,partly simulated,whole method,20,100,85,15,,,,0.850000,5,0.050000,85,10,0.117647,3.5000,4.2500
        objects,overall,partly simulated,without terrain,20,100,25,75,,,,0.250000,5,0.050000,25,10,0.400000,3.5000,4.2500
        ");
    }
}
