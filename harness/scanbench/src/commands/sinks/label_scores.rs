//! `protocol_labels.csv`: scores of labels of points, under the protocols that have them.

use std::collections::BTreeSet;

use evaluation::protocols::semantic_kitti::label_scores::{FoundPoints, LabeledPoints, scores_labels};
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::files::csv_rows::CsvRowWriter;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::scan_name::ScanName;
use reports::run_folder::run_directory::{PROTOCOL_LABELS_CSV, RunDirectory};
use reports::vocabulary::protocol::Protocol;
use scans::annotation::LabeledScan;
use scans::dataset::Dataset;

use crate::commands::failure::{Failure, Usage};
use crate::commands::standard_streams::print_diagnostic;

/// The labels of the points of a scan of `dataset`, given by its place.
///
/// # Errors
///
/// If they are damaged, or the data set has none.
pub fn labels_for(
    protocols: &[Protocol],
    dataset: &dyn Dataset,
    (scan_idx, scan): (usize, &LabeledScan),
) -> Result<Vec<u32>, Failure> {
    let none = || {
        let names: Vec<&str> = protocols.iter().map(|it| it.name()).collect();
        let (names, id) = (names.join(","), &dataset.description().id);
        Usage(format!(
            "--protocol {names} needs labels of points, as semantic-kitti has them; {id:?} has none"
        ))
    };
    Ok(dataset.point_labels(scan_idx, scan)?.ok_or_else(none)?)
}

/// Scores every scan under `protocols`, writes the rows and adds them up.
pub struct LabelScores<'a> {
    rows: CsvRowWriter<LabelScoreRow>,
    tally: &'a mut ProtocolTally,
    protocols: Vec<Protocol>,
    // Those that did not tell ground in some scan of the data set.
    tell_no_ground: BTreeSet<&'static str>,
}

impl<'a> LabelScores<'a> {
    /// Begins the file in `directory`; `None` if none of `protocols` scores labels.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub fn begin(
        directory: &RunDirectory,
        protocols: &[Protocol],
        tally: &'a mut ProtocolTally,
    ) -> Result<Option<Self>, Failure> {
        let protocols: Vec<Protocol> = protocols.iter().copied().filter(|it| scores_labels(*it)).collect();
        if protocols.is_empty() {
            return Ok(None);
        }
        let rows = CsvRowWriter::new(directory.begin_file(PROTOCOL_LABELS_CSV)?)?;
        Ok(Some(Self { rows, tally, protocols, tell_no_ground: BTreeSet::new() }))
    }

    fn asks_for_ground(&self) -> bool {
        self.protocols.contains(&Protocol::Ground)
    }
}

impl RunSink<Failure> for LabelScores<'_> {
    fn begin_dataset(&mut self, _: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.tell_no_ground.clear();
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        let (results, scan) = (judged.results, judged.results.scan);
        let labels = labels_for(&self.protocols, judged.watched.dataset, (judged.scan_idx(), scan))?;
        let name = ScanName {
            dataset: judged.dataset().id.clone(),
            sequence: scan.id.sequence.clone(),
            scan: scan.id.index,
        };
        let points = LabeledPoints::new(&scan.cloud, labels, &self.protocols);
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let labels = detector.point_labels(scan);
            let found = FoundPoints {
                detections: &result.output.detections,
                labels: labels.as_deref(),
                ground: self.asks_for_ground().then(|| detector.ground_points(&scan.cloud)).flatten(),
            };
            if self.asks_for_ground() && found.told_ground().is_none() {
                self.tell_no_ground.insert(result.detector);
            }
            for score in self.protocols.iter().flat_map(|it| points.scores(*it, &found)) {
                let row = LabelScoreRow { scan: name.clone(), detector: result.detector.to_owned(), score };
                self.rows.write(&row)?;
                self.tally.add_label_score(&row);
            }
        }
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        for name in &self.tell_no_ground {
            print_diagnostic(format_args!(
                "warning: {name:?} does not tell which points are ground: it has no numbers under the protocol ground"
            ));
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        Ok(self.rows.finish()?)
    }
}
