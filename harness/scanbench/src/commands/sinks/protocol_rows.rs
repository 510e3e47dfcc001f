//! `--protocol`: the rows of protocols of others, to files and to sums.

use evaluation::protocols::official_objects::OfficialScanView;
use evaluation::protocols::official_protocol::{FoundInScan, OfficialProtocol, ProtocolRows};
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::files::csv_rows::CsvRowWriter;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_name::ScanName;
use reports::run_folder::run_directory::{KITTI_OBJECT_CSV, PROTOCOL_BOXES_CSV, RunDirectory};
use reports::vocabulary::protocol::Protocol;

use crate::commands::failure::Failure;

/// Evaluates every scan under some protocols.
pub struct ProtocolRowFiles<'a> {
    protocols: Vec<&'static dyn OfficialProtocol>,
    boxes: CsvRowWriter<RankedBoxRow>,
    // `None` unless it is asked for.
    kitti: Option<CsvRowWriter<KittiObjectRow>>,
    tally: &'a mut ProtocolTally,
}

impl<'a> ProtocolRowFiles<'a> {
    /// Begins the files in `directory`; `tally` gets the rows, too.
    ///
    /// # Errors
    ///
    /// If one cannot be written.
    pub fn begin(
        directory: &RunDirectory,
        protocols: Vec<&'static dyn OfficialProtocol>,
        tally: &'a mut ProtocolTally,
    ) -> Result<Self, Failure> {
        let boxes = CsvRowWriter::new(directory.begin_file(PROTOCOL_BOXES_CSV)?)?;
        let is_kitti = protocols.iter().any(|it| it.protocol() == Protocol::KittiObject);
        let kitti =
            if is_kitti { Some(CsvRowWriter::new(directory.begin_file(KITTI_OBJECT_CSV)?)?) } else { None };
        Ok(Self { protocols, boxes, kitti, tally })
    }

    fn write(&mut self, rows: &ProtocolRows) -> Result<(), Failure> {
        match rows {
            ProtocolRows::RankedBoxes(rows) => {
                for row in rows {
                    self.boxes.write(row)?;
                    self.tally.add_ranked_box(row);
                }
            }
            ProtocolRows::KittiObjects(rows) => {
                for row in rows {
                    if let Some(kitti) = &mut self.kitti {
                        kitti.write(row)?;
                    }
                    self.tally.add_kitti_object(row);
                }
            }
        }
        Ok(())
    }
}

impl RunSink<Failure> for ProtocolRowFiles<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        let lacking = self.protocols.iter().find_map(|it| Some((it.protocol(), it.lacks(watched.dataset)?)));
        match lacking {
            None => Ok(()),
            Some((protocol, what)) => {
                let id = &watched.dataset.description().id;
                Err(Failure::usage(format!("--protocol {protocol}"), format!("{id:?} {what}")))
            }
        }
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        let results = judged.results;
        let view = OfficialScanView::new(judged.watched.dataset, judged.scan_idx(), results.scan)?;
        let name = ScanName {
            dataset: judged.dataset().id.clone(),
            sequence: results.scan.id.sequence.clone(),
            scan: results.scan.id.index,
        };
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let objects = view.found(&result.output, detector.official_objects(&results.scan.id));
            let found = FoundInScan {
                name: name.clone(),
                detector: result.detector,
                view: &view,
                output: &result.output,
                objects: &objects,
                kitti_objects: detector.kitti_objects(&results.scan.id),
            };
            for protocol in self.protocols.clone() {
                self.write(&protocol.rows(&found))?;
            }
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        self.kitti.map_or(Ok(()), CsvRowWriter::finish)?;
        Ok(self.boxes.finish()?)
    }
}
