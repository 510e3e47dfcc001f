//! `--protocol`: the rows of protocols of others, to files and to sums.

use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::files::csv_rows::{CsvRow, CsvRowWriter};
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::run_folder::run_directory::{
    KITTI_OBJECT_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_LABELS_CSV, RunDirectory, protocol_file,
};
use reports::vocabulary::protocol::Protocol;

use crate::commands::failure::Failure;
use crate::commands::official_evaluation::OfficialEvaluation;

/// Evaluates every scan under some protocols.
pub struct ProtocolRowFiles<'a> {
    evaluation: OfficialEvaluation,
    boxes: RowFile<RankedBoxRow>,
    kitti: RowFile<KittiObjectRow>,
    labels: RowFile<LabelScoreRow>,
    tally: &'a mut ProtocolTally,
}

impl<'a> ProtocolRowFiles<'a> {
    /// Begins the files of `protocols` in `directory`; `tally` gets the rows, too. `None` if there are no protocols.
    pub fn begin(
        directory: &RunDirectory,
        protocols: &[Protocol],
        tally: &'a mut ProtocolTally,
    ) -> Result<Option<Self>, Failure> {
        let Some(evaluation) = OfficialEvaluation::of(protocols) else { return Ok(None) };
        let boxes = RowFile::begin(directory, PROTOCOL_BOXES_CSV, protocols)?;
        let kitti = RowFile::begin(directory, KITTI_OBJECT_CSV, protocols)?;
        let labels = RowFile::begin(directory, PROTOCOL_LABELS_CSV, protocols)?;
        Ok(Some(Self { evaluation, boxes, kitti, labels, tally }))
    }
}

impl RunSink<Failure> for ProtocolRowFiles<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.evaluation.begin_dataset(watched)
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        let rows = self.evaluation.rows(judged)?;
        self.boxes.write(&rows.boxes)?;
        self.kitti.write(&rows.kitti)?;
        self.labels.write(&rows.labels)?;
        self.tally.add(&rows);
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        self.evaluation.end_dataset();
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        self.boxes.finish()?;
        self.kitti.finish()?;
        self.labels.finish()
    }
}

/// A file, unless no protocol has such rows.
struct RowFile<Row>(Option<CsvRowWriter<Row>>);

impl<Row: CsvRow> RowFile<Row> {
    fn begin(directory: &RunDirectory, name: &str, protocols: &[Protocol]) -> Result<Self, Failure> {
        if protocols.iter().all(|it| protocol_file(*it) != name) {
            return Ok(Self(None));
        }
        Ok(Self(Some(CsvRowWriter::new(directory.begin_file(name)?)?)))
    }

    fn write(&mut self, rows: &[Row]) -> Result<(), Failure> {
        if let Some(file) = &mut self.0 {
            for row in rows {
                file.write(row)?;
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<(), Failure> {
        Ok(self.0.map_or(Ok(()), CsvRowWriter::finish)?)
    }
}
