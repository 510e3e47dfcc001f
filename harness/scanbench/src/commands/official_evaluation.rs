//! `--protocol`: what comes of a scan under protocols of others.

use std::collections::BTreeSet;

use evaluation::protocols::known_protocols::official_protocol;
use evaluation::protocols::official_objects::OfficialScanView;
use evaluation::protocols::official_protocol::{FoundInScan, OfficialProtocol, ProtocolRows};
use evaluation::protocols::semantic_kitti::label_scores::{FoundPoints, LabeledPoints, scores_labels};
use evaluation::run::sink::{JudgedScan, WatchedDataset};
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_name::ScanName;
use reports::vocabulary::protocol::Protocol;
use scans::annotation::LabeledScan;
use scans::dataset::Dataset;

use crate::commands::failure::{Failure, Usage};
use crate::commands::standard_streams::print_diagnostic;

/// The rows of a scan under all protocols.
#[derive(Debug, Default)]
pub struct OfficialRows {
    /// Of protocols that rank boxes by the distance of centres.
    pub boxes: Vec<RankedBoxRow>,
    /// Of KITTI's evaluation of objects.
    pub kitti: Vec<KittiObjectRow>,
    /// Of protocols that score labels of points.
    pub labels: Vec<LabelScoreRow>,
}

impl OfficialRows {
    /// Adds them to `tally`.
    pub fn add_to(&self, tally: &mut ProtocolTally) {
        for row in &self.boxes {
            tally.add_ranked_box(row);
        }
        for row in &self.kitti {
            tally.add_kitti_object(row);
        }
        for row in &self.labels {
            tally.add_label_score(row);
        }
    }
}

/// Evaluates scans under some protocols.
pub struct OfficialEvaluation {
    of_boxes: Vec<&'static dyn OfficialProtocol>,
    of_labels: Vec<Protocol>,
    // Those that did not tell ground in some scan of the data set.
    tell_no_ground: BTreeSet<&'static str>,
}

impl OfficialEvaluation {
    /// By `protocols`; `None` if there are none.
    pub fn of(protocols: &[Protocol]) -> Option<Self> {
        let evaluation = Self {
            of_boxes: protocols.iter().filter_map(|it| official_protocol(*it)).collect(),
            of_labels: protocols.iter().copied().filter(|it| scores_labels(*it)).collect(),
            tell_no_ground: BTreeSet::new(),
        };
        (!protocols.is_empty()).then_some(evaluation)
    }

    /// Begins a data set.
    ///
    /// # Errors
    ///
    /// If it has not what one of the protocols needs.
    pub fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.tell_no_ground.clear();
        let lacking = self.of_boxes.iter().find_map(|it| Some((it.protocol(), it.lacks(watched.dataset)?)));
        match lacking {
            None => Ok(()),
            Some((protocol, what)) => {
                let id = &watched.dataset.description().id;
                Err(Failure::usage(format!("--protocol {protocol}"), format!("{id:?} {what}")))
            }
        }
    }

    /// The rows of a scan.
    ///
    /// # Errors
    ///
    /// If its labels cannot be read.
    pub fn rows(&mut self, judged: &JudgedScan<'_>) -> Result<OfficialRows, Failure> {
        let mut rows = OfficialRows::default();
        let scan_id = &judged.results.scan.id;
        let dataset = judged.dataset().id.clone();
        let name = ScanName { dataset, sequence: scan_id.sequence.clone(), scan: scan_id.index };
        if !self.of_boxes.is_empty() {
            self.add_boxes(judged, &name, &mut rows)?;
        }
        if !self.of_labels.is_empty() {
            self.add_labels(judged, &name, &mut rows.labels)?;
        }
        Ok(rows)
    }

    fn add_boxes(
        &self,
        judged: &JudgedScan<'_>,
        name: &ScanName,
        rows: &mut OfficialRows,
    ) -> Result<(), Failure> {
        let results = judged.results;
        let view = OfficialScanView::new(judged.watched.dataset, judged.scan_idx(), results.scan)?;
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
            for protocol in &self.of_boxes {
                match protocol.rows(&found) {
                    ProtocolRows::RankedBoxes(of_scan) => rows.boxes.extend(of_scan),
                    ProtocolRows::KittiObjects(of_scan) => rows.kitti.extend(of_scan),
                }
            }
        }
        Ok(())
    }

    fn add_labels(
        &mut self,
        judged: &JudgedScan<'_>,
        name: &ScanName,
        rows: &mut Vec<LabelScoreRow>,
    ) -> Result<(), Failure> {
        let (results, scan) = (judged.results, judged.results.scan);
        let labels = labels_for(&self.of_labels, judged.watched.dataset, (judged.scan_idx(), scan))?;
        let points = LabeledPoints::new(&scan.cloud, labels, &self.of_labels);
        let asks_for_ground = self.of_labels.contains(&Protocol::Ground);
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let labels = detector.point_labels(scan);
            let found = FoundPoints {
                detections: &result.output.detections,
                labels: labels.as_deref(),
                ground: asks_for_ground.then(|| detector.ground_points(&scan.cloud)).flatten(),
            };
            if asks_for_ground && found.told_ground().is_none() {
                self.tell_no_ground.insert(result.detector);
            }
            let scores = self.of_labels.iter().flat_map(|it| points.scores(*it, &found));
            let row =
                |score| LabelScoreRow { scan: name.clone(), detector: result.detector.to_owned(), score };
            rows.extend(scores.map(row));
        }
        Ok(())
    }

    /// Says which detectors did not tell what a protocol asks for.
    pub fn end_dataset(&self) {
        for name in &self.tell_no_ground {
            print_diagnostic(format_args!(
                "warning: {name:?} does not tell which points are ground: it has no numbers under the protocol ground"
            ));
        }
    }
}

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
