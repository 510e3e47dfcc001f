//! Evaluation of a scan under chosen protocols: rows made of the results of detectors.

use detector::DetectorOutput;
use reports::rows::label_score_row::{LabelScore, LabelScoreRow};
use reports::rows::official_rows::OfficialRows;
use reports::rows::ranked_box_row::{BoxKind, BoxState, RankedBoxRow};
use reports::rows::scan_name::ScanName;
use reports::vocabulary::protocol::Protocol;
use scans::annotation::LabeledScan;
use scans::dataset::{Dataset, DatasetError};

use super::PROTOCOLS;
use super::official_objects::OfficialScanView;
use super::official_protocol::{FoundInScan, OfficialProtocol};
use super::semantic_kitti::label_scores::{FoundPoints, LabeledPoints, scores_labels};
use crate::run::running_detector::RunningDetector;

/// Some protocols, at least one.
pub struct ChosenProtocols {
    of_boxes: Vec<&'static dyn OfficialProtocol>,
    of_labels: Vec<Protocol>,
}

/// Why a scan cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum ProtocolError {
    /// The data set lacks something that one of the protocols needs.
    #[error("--protocol {protocol}: {dataset:?} {what}")]
    Lacks {
        /// The protocol.
        protocol: Protocol,
        /// Id of the data set.
        dataset: String,
        /// The rest of the sentence.
        what: &'static str,
    },
    /// Labels of points are needed, and there are none.
    #[error(
        "--protocol {protocols} needs labels of points, as semantic-kitti has them; {dataset:?} has none"
    )]
    NoLabels {
        /// Names of the protocols.
        protocols: String,
        /// Id of the data set.
        dataset: String,
    },
    /// A file of the scan from the makers of the data set cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
}

/// A scan that is evaluated, with the labels of the makers of the data set.
pub struct ScanUnderProtocols<'a> {
    chosen: &'a ChosenProtocols,
    name: ScanName,
    scan: &'a LabeledScan,
    // `None` if no protocol evaluates boxes.
    view: Option<OfficialScanView<'a>>,
    points: Option<LabeledPoints<'a>>,
}

impl ChosenProtocols {
    /// These protocols; `None` if there are none.
    pub fn of(protocols: &[Protocol]) -> Option<Self> {
        let of_boxes = |protocol: &Protocol| PROTOCOLS.iter().copied().find(|it| it.protocol() == *protocol);
        let chosen = Self {
            of_boxes: protocols.iter().filter_map(of_boxes).collect(),
            of_labels: protocols.iter().copied().filter(|it| scores_labels(*it)).collect(),
        };
        (!protocols.is_empty()).then_some(chosen)
    }

    /// Checks that `dataset` meets the needs of the protocols, as far as that is known without reading a scan.
    ///
    /// # Errors
    ///
    /// [`ProtocolError::Lacks`] if it does not.
    pub fn check(&self, dataset: &dyn Dataset) -> Result<(), ProtocolError> {
        let lacking = self.of_boxes.iter().find_map(|it| Some((it.protocol(), it.lacks(dataset)?)));
        lacking.map_or(Ok(()), |(protocol, what)| {
            Err(ProtocolError::Lacks { protocol, dataset: dataset.description().id.clone(), what })
        })
    }

    /// Whether a protocol evaluates the predicted ground.
    pub fn ask_for_ground(&self) -> bool {
        self.of_labels.contains(&Protocol::Ground)
    }

    /// Prepares `scan`, which is scan `scan_idx` of `dataset`.
    ///
    /// # Errors
    ///
    /// [`ProtocolError`] if its labels are damaged or missing.
    pub fn scan<'a>(
        &'a self,
        dataset: &'a dyn Dataset,
        scan_idx: usize,
        scan: &'a LabeledScan,
    ) -> Result<ScanUnderProtocols<'a>, ProtocolError> {
        let id = &dataset.description().id;
        let name = ScanName { dataset: id.clone(), sequence: scan.id.sequence.clone(), scan: scan.id.index };
        let view = || OfficialScanView::new(dataset, scan_idx, scan);
        let view = (!self.of_boxes.is_empty()).then(view).transpose()?;
        let points = || -> Result<LabeledPoints<'a>, ProtocolError> {
            let none = || {
                let names: Vec<&str> = self.of_labels.iter().map(|it| it.name()).collect();
                ProtocolError::NoLabels { protocols: names.join(","), dataset: id.clone() }
            };
            let labels = dataset.point_labels(scan_idx, scan)?.ok_or_else(none)?;
            Ok(LabeledPoints::new(&scan.cloud, labels, &self.of_labels))
        };
        let points = (!self.of_labels.is_empty()).then(points).transpose()?;
        Ok(ScanUnderProtocols { chosen: self, name, scan, view, points })
    }
}

impl ScanUnderProtocols<'_> {
    /// The rows of `output`, which `detector`, called `name`, has just found in the scan. Without predicted ground there are
    /// no rows of ground.
    pub fn rows(&self, name: &str, detector: &dyn RunningDetector, output: &DetectorOutput) -> OfficialRows {
        let mut rows = OfficialRows::default();
        if let Some(view) = &self.view {
            let id = &self.scan.id;
            let objects = view.found(output, detector.official_objects(id));
            let found = FoundInScan {
                name: self.name.clone(),
                detector: name,
                view,
                output,
                objects: &objects,
                kitti_objects: detector.kitti_objects(id),
            };
            self.add_boxes(&found, &mut rows);
        }
        if let Some(points) = &self.points {
            let labels = detector.point_labels(self.scan);
            let ground =
                self.chosen.ask_for_ground().then(|| detector.ground_points(&self.scan.cloud)).flatten();
            let found = FoundPoints { detections: &output.detections, labels: labels.as_deref(), ground };
            let scores = self.chosen.of_labels.iter().flat_map(|it| points.scores(*it, &found));
            self.add_labels(name, scores, &mut rows);
        }
        rows
    }

    /// The rows of the labels themselves, fed back as the results of a detector `name`.
    pub fn echoed_rows(&self, name: &str) -> OfficialRows {
        let mut rows = OfficialRows::default();
        if let Some(view) = &self.view {
            let (objects, kitti_objects) = (view.echoed(), view.echoed_kitti());
            let found = FoundInScan {
                name: self.name.clone(),
                detector: name,
                view,
                output: &DetectorOutput::default(),
                objects: &objects,
                kitti_objects: Some(&kitti_objects),
            };
            self.add_boxes(&found, &mut rows);
        }
        if let Some(points) = &self.points {
            let scores = self.chosen.of_labels.iter().flat_map(|it| points.echoed_scores(*it));
            self.add_labels(name, scores, &mut rows);
        }
        rows
    }

    /// The rows of the labels of boxes, fed back as what a detector `name` gives that runs here.
    pub fn echoed_detections(&self, name: &str) -> OfficialRows {
        let mut rows = OfficialRows::default();
        if let Some(view) = &self.view {
            let output = view.echoed_output();
            let objects = view.found(&output, &[]);
            let found = FoundInScan {
                name: self.name.clone(),
                detector: name,
                view,
                output: &output,
                objects: &objects,
                kitti_objects: None,
            };
            self.add_boxes(&found, &mut rows);
        }
        rows
    }

    /// Name of the scan.
    pub fn name(&self) -> &ScanName {
        &self.name
    }

    fn add_boxes(&self, found: &FoundInScan<'_>, rows: &mut OfficialRows) {
        self.chosen.of_boxes.iter().for_each(|it| rows.append(it.rows(found)));
    }

    fn add_labels(&self, name: &str, scores: impl Iterator<Item = LabelScore>, rows: &mut OfficialRows) {
        let row = |score| LabelScoreRow { scan: self.name.clone(), detector: name.to_owned(), score };
        rows.labels.extend(scores.map(row));
    }
}

/// Whether any of `rows` is of ground: a detector that does not predict ground has none.
pub fn have_ground(rows: &OfficialRows) -> bool {
    rows.labels.iter().any(|it| it.score.protocol() == Protocol::Ground)
}

/// Number of labels that `protocol` does not take as annotations or as detections: `rows` are of labels fed back. It takes
/// so many detections in a scan at most, or has another range for a class of labels than for detections.
pub fn n_taken_once(rows: &OfficialRows, protocol: Protocol) -> usize {
    let counted = |is_annotation: bool| {
        let counts = move |it: &&RankedBoxRow| {
            let is_it = (it.ranked_box.kind == BoxKind::Annotation) == is_annotation;
            is_it && it.protocol == protocol && it.ranked_box.state == BoxState::Counts
        };
        rows.boxes.iter().filter(counts).count()
    };
    counted(true).abs_diff(counted(false))
}
