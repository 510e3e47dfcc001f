//! The table for programs: one row a data set and detector, with every count beside its rates.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::{CsvRow, row, to_csv_bytes};
use crate::files::fixed_decimals::{Fixed, fixed_decimals};
use crate::numbers::blocks::{BlockColumns, Interval};
use crate::protocols::protocol_number::ProtocolNumber;
use crate::tables::formats::format::Format;
use crate::tables::paper_figures::{PaperRow, PaperScore};
use crate::tables::protocol_table::ProtocolTable;
use crate::tables::task_table::{MeasuredRow, RateIntervals, Score, TableRow, TaskTable};
use crate::vocabulary::protocol::Protocol;

/// Comma-separated values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Csv;

row! {
    #[derive(Default, Serialize, Deserialize)]
    pub(crate) struct TaskRow {
        task: String,
        source: String,
        dataset: String,
        origin: String,
        detector: String,
        n_scans: Option<u64>,
        no: u64,
        tp: Option<u64>,
        mo: Option<u64>,
        fo: Option<u64>,
        precision: Option<Fixed<6>>,
        recall: Option<Fixed<6>>,
        f_rate: Option<String>,
        ignored_annotations: Option<u64>,
        ignored_detections: Option<u64>,
        n_timed_scans: Option<u64>,
        fps_mean: Option<String>,
        precision_within: [Option<Fixed<6>>; 2] = ["precision_low", "precision_high"],
        recall_within: [Option<Fixed<6>>; 2] = ["recall_low", "recall_high"],
        f_rate_within: [Option<Fixed<6>>; 2] = ["f_rate_low", "f_rate_high"],
        blocks: BlockColumns = ["n_blocks", "blocks", "few_blocks"],
    }
}

impl Format<TaskTable> for Csv {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.csv")
    }

    /// The table as CSV; rates as fractions of one, undefined values empty.
    ///
    /// `…_low` and `…_high` are the ends of 95 % intervals, drawn from `n_blocks` blocks of scans of the kind `blocks`;
    /// where `few_blocks` is true these are too few for anything to rest on the interval. The column `source` says whether a
    /// row was measured or published in a paper, `origin` where its scans come from. A published row stands beside our
    /// detector that does what the paper describes.
    fn text(&self, table: &TaskTable) -> String {
        let rows = table.rows.iter().flat_map(|row| {
            table.detectors.iter().enumerate().filter_map(move |(detector_idx, detector)| {
                let of_row = match row {
                    TableRow::Measured(row) => TaskRow::measured(row, &row.scores[detector_idx]),
                    TableRow::Paper(row) => {
                        TaskRow::published(row, &table.paper?.score_beside(row, detector)?)
                    }
                };
                Some(TaskRow { task: table.task.name().to_owned(), detector: detector.clone(), ..of_row })
            })
        });
        text_of(&rows.collect::<Vec<_>>())
    }
}

impl TaskRow {
    fn measured(row: &MeasuredRow, score: &Score) -> Self {
        let counts = score.counts;
        let RateIntervals { precision, recall, f_rate } = score.intervals;
        let ends = |it: Option<Interval>| it.map_or([None; 2], |it| it.ends.map(|end| Some(Fixed(end))));
        Self {
            source: "measured".to_owned(),
            dataset: row.extent.name().to_owned(),
            origin: row.origin.name().to_owned(),
            n_scans: Some(score.n_scans),
            no: counts.no(),
            tp: Some(counts.tp()),
            mo: Some(counts.mo()),
            fo: counts.fo(),
            precision: counts.precision().map(Fixed),
            recall: counts.recall().map(Fixed),
            f_rate: counts.f_rate().map(|it| fixed_decimals(it, 6)),
            ignored_annotations: Some(score.n_ignored_annotations),
            ignored_detections: Some(score.n_ignored_detections),
            n_timed_scans: Some(score.n_timed_scans),
            fps_mean: score.fps.map(|it| fixed_decimals(it, 3)),
            precision_within: ends(precision),
            recall_within: ends(recall),
            f_rate_within: ends(f_rate),
            blocks: recall.or(f_rate).map(|it| it.blocks).into(),
            ..Self::default()
        }
    }

    /// A published row, with no more digits than the paper has.
    fn published(row: &PaperRow, score: &PaperScore) -> Self {
        Self {
            source: "published".to_owned(),
            dataset: row.name.to_owned(),
            origin: "recorded".to_owned(),
            no: row.no.into(),
            f_rate: Some(fixed_decimals(score.f_rate_percent / 100.0, 2)),
            fps_mean: Some(score.fps.to_string()),
            ..Self::default()
        }
    }
}

row! {
    #[derive(Serialize, Deserialize)]
    pub(crate) struct ProtocolRow {
        protocol: Protocol,
        dataset: String,
        detector: String,
        class: String,
        metric: String,
        value: Option<String>,
        unit: String,
        higher_is_better: Option<bool>,
        n: u64,
        within: [Option<String>; 2] = ["low", "high"],
        blocks: BlockColumns = ["n_blocks", "blocks", "few_blocks"],
    }
}

impl Format<ProtocolTable<'_>> for Csv {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.csv")
    }

    /// One row a number, with all digits; undefined values and unknown intervals are empty.
    fn text(&self, table: &ProtocolTable<'_>) -> String {
        let row = |it: &&ProtocolNumber| ProtocolRow {
            protocol: it.protocol,
            dataset: it.dataset.clone(),
            detector: it.detector.clone(),
            class: it.metric.class.clone(),
            metric: it.metric.id.clone(),
            value: it.value.map(|it| it.to_string()),
            unit: it.metric.unit.to_owned(),
            higher_is_better: it.metric.direction.higher_is_better(),
            n: it.metric.n,
            within: [0, 1].map(|end: usize| it.interval.map(|it| it.ends[end].to_string())),
            blocks: it.interval.map(|it| it.blocks).into(),
        };
        text_of(&table.numbers().iter().map(row).collect::<Vec<_>>())
    }
}

fn text_of<Row: CsvRow>(rows: &[Row]) -> String {
    let bytes = to_csv_bytes(rows).expect("all numbers are finite");
    String::from_utf8(bytes).expect("rows of text are text")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::sample;

    #[test]
    fn every_rate_has_its_counts_in_the_same_row() {
        insta::assert_snapshot!(Csv.text(&sample::tables()[0]), @r"
        task,source,dataset,origin,detector,n_scans,no,tp,mo,fo,precision,recall,f_rate,ignored_annotations,ignored_detections,n_timed_scans,fps_mean,precision_low,precision_high,recall_low,recall_high,f_rate_low,f_rate_high,n_blocks,blocks,few_blocks
        objects,measured,main_road,simulated,paper,20,412,371,41,52,0.877069,0.900485,0.888623,17,230,19,121.300,,,,,0.863523,0.903523,20,drives,false
        objects,measured,main_road,simulated,kd-tree,20,412,340,72,140,0.708333,0.825243,0.762332,17,230,19,8.040,,,,,0.737232,0.777232,20,drives,false
        objects,measured,main_road,simulated,pca,20,412,318,94,97,0.766265,0.771845,0.769045,17,230,19,46.000,,,,,0.743945,0.783945,20,drives,false
        objects,measured,kitti_tracking,recorded,paper,20,318,290,28,,,0.911950,,17,230,19,98.200,,,,,,,,,
        objects,measured,kitti_tracking,recorded,kd-tree,20,318,271,47,,,0.852201,,17,230,19,0.471,,,,,,,,,
        objects,measured,kitti_tracking,recorded,pca,20,318,204,114,,,0.641509,,17,230,19,39.900,,,,,,,,,
        objects,measured,kitti_object,recorded,paper,20,61,55,6,,,0.901639,,17,230,19,104.000,,,,,,,,,
        objects,measured,kitti_object,recorded,kd-tree,20,61,61,0,,,1.000000,,17,230,19,0.500,,,,,,,,,
        objects,measured,kitti_object,recorded,pca,20,61,40,21,,,0.655738,,17,230,19,41.000,,,,,,,,,
        objects,measured,overall-recorded,recorded,paper,40,379,345,34,,,0.910290,,34,460,38,101.017,,,,,,,,,
        objects,measured,overall-recorded,recorded,kd-tree,40,379,332,47,,,0.875989,,34,460,38,0.485,,,,,,,,,
        objects,measured,overall-recorded,recorded,pca,40,379,244,135,,,0.643799,,34,460,38,40.443,,,,,,,,,
        objects,published,Budapest #1,recorded,paper,,669,,,,,,0.89,,,,29,,,,,,,,,
        objects,published,Budapest #1,recorded,kd-tree,,669,,,,,,0.77,,,,0.38,,,,,,,,,
        objects,published,Budapest #2,recorded,paper,,429,,,,,,0.79,,,,25,,,,,,,,,
        objects,published,Budapest #2,recorded,kd-tree,,429,,,,,,0.64,,,,0.22,,,,,,,,,
        objects,published,KITTI,recorded,paper,,496,,,,,,0.82,,,,29,,,,,,,,,
        objects,published,KITTI,recorded,kd-tree,,496,,,,,,0.75,,,,0.46,,,,,,,,,
        objects,published,overall,recorded,paper,,1594,,,,,,0.83,,,,28,,,,,,,,,
        objects,published,overall,recorded,kd-tree,,1594,,,,,,0.72,,,,0.35,,,,,,,,,
        ");
    }
}
