//! The table for programs: one row a data set and detector, with every count beside its rates.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::{BlockCount, Interval};
use crate::protocols::protocol_number::ProtocolNumber;
use crate::tables::formats::format::Format;
use crate::tables::paper_figures::PaperRow;
use crate::tables::protocol_table::ProtocolTable;
use crate::tables::task_table::{MeasuredRow, RateIntervals, Score, TableRow, TaskTable};

const COLUMNS: [&str; 26] = [
    "task",
    "source",
    "dataset",
    "origin",
    "detector",
    "n_scans",
    "no",
    "tp",
    "mo",
    "fo",
    "precision",
    "recall",
    "f_rate",
    "ignored_annotations",
    "ignored_detections",
    "n_timed_scans",
    "fps_mean",
    "precision_low",
    "precision_high",
    "recall_low",
    "recall_high",
    "f_rate_low",
    "f_rate_high",
    "n_blocks",
    "blocks",
    "few_blocks",
];

/// Comma-separated values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Csv;

impl Format<TaskTable> for Csv {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.csv")
    }

    /// The table as CSV; rates as fractions of one, undefined values empty.
    ///
    /// `…_low` and `…_high` are the ends of 95 % intervals, from as many blocks of scans as `n_blocks` says, which are what `blocks`
    /// says; where `few_blocks` is true these are too few for anything to rest on the interval.
    /// The column `source` says whether a row was measured or published in a paper, `origin` where its scans come from.
    /// A published row stands beside our detector that does what the paper describes.
    fn text(&self, table: &TaskTable) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut write =
            |record: &[String]| writer.write_record(record).expect("memory takes rows of one length");
        write(&COLUMNS.map(str::to_owned));
        for row in &table.rows {
            for (detector_idx, detector) in table.detectors.iter().enumerate() {
                let record = match row {
                    TableRow::Measured(row) => {
                        Some(measured_record(table, row, detector, &row.scores[detector_idx]))
                    }
                    TableRow::Paper(row) => paper_record(table, row, detector),
                };
                if let Some(record) = record {
                    write(&record);
                }
            }
        }
        let bytes = writer.into_inner().expect("memory takes all that is written");
        String::from_utf8(bytes).expect("rows of text are text")
    }
}

fn measured_record(table: &TaskTable, row: &MeasuredRow, detector: &str, score: &Score) -> [String; 26] {
    let counts = score.counts;
    let rate = |rate: Option<f64>| rate.map_or_else(String::new, |it| fixed_decimals(it, 6));
    let RateIntervals { precision, recall, f_rate } = score.intervals;
    let of_blocks =
        |text: fn(BlockCount) -> String| recall.or(f_rate).map_or_else(String::new, |it| text(it.blocks));
    let end = |interval: Option<Interval>, end_idx: usize| rate(interval.map(|it| it.ends[end_idx]));
    [
        table.task.name().to_owned(),
        "measured".to_owned(),
        row.extent.name().to_owned(),
        row.origin.name().to_owned(),
        detector.to_owned(),
        score.n_scans.to_string(),
        counts.no().to_string(),
        counts.tp().to_string(),
        counts.mo().to_string(),
        counts.fo().map_or_else(String::new, |it| it.to_string()),
        rate(counts.precision()),
        rate(counts.recall()),
        rate(counts.f_rate()),
        score.n_ignored_annotations.to_string(),
        score.n_ignored_detections.to_string(),
        score.n_timed_scans.to_string(),
        score.fps().map_or_else(String::new, |it| fixed_decimals(it, 3)),
        end(precision, 0),
        end(precision, 1),
        end(recall, 0),
        end(recall, 1),
        end(f_rate, 0),
        end(f_rate, 1),
        of_blocks(|it| it.n_blocks.to_string()),
        of_blocks(|it| it.kind.name().to_owned()),
        of_blocks(|it| it.decide_nothing().to_string()),
    ]
}

fn paper_record(table: &TaskTable, row: &PaperRow, detector: &str) -> Option<[String; 26]> {
    let score = table.paper?.score_beside(row, detector)?;
    let mut record: [String; 26] = Default::default();
    table.task.name().clone_into(&mut record[0]);
    "published".clone_into(&mut record[1]);
    row.name.clone_into(&mut record[2]);
    "recorded".clone_into(&mut record[3]);
    detector.clone_into(&mut record[4]);
    record[6] = row.no.to_string();
    record[12] = fixed_decimals(score.f_rate_percent / 100.0, 2);
    record[16] = score.fps.to_string();
    Some(record)
}

const PROTOCOL_COLUMNS: [&str; 14] = [
    "protocol",
    "dataset",
    "detector",
    "class",
    "metric",
    "value",
    "unit",
    "higher_is_better",
    "n",
    "low",
    "high",
    "n_blocks",
    "blocks",
    "few_blocks",
];

impl Format<ProtocolTable<'_>> for Csv {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.csv")
    }

    /// One row a number, with all digits; undefined values and unknown intervals are empty.
    fn text(&self, table: &ProtocolTable<'_>) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut write =
            |record: &[String]| writer.write_record(record).expect("memory takes rows of one length");
        write(&PROTOCOL_COLUMNS.map(str::to_owned));
        for ProtocolNumber { protocol, dataset, detector, metric, value, interval } in table.numbers() {
            let text = |it: Option<f64>| it.map_or_else(String::new, |it| it.to_string());
            let blocks = interval.map(|it| it.blocks);
            let is_better = metric.direction.higher_is_better();
            write(&[
                protocol.name().to_owned(),
                dataset.clone(),
                detector.clone(),
                metric.class.clone(),
                metric.id.clone(),
                text(*value),
                metric.unit.to_owned(),
                is_better.map_or_else(String::new, |it| it.to_string()),
                metric.n.to_string(),
                text(interval.map(|it| it.ends[0])),
                text(interval.map(|it| it.ends[1])),
                blocks.map_or_else(String::new, |it| it.n_blocks.to_string()),
                blocks.map_or_else(String::new, |it| it.kind.name().to_owned()),
                blocks.map_or_else(String::new, |it| it.decide_nothing().to_string()),
            ]);
        }
        let bytes = writer.into_inner().expect("memory takes all that is written");
        String::from_utf8(bytes).expect("names are text")
    }
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
