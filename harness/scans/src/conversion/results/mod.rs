//! What detectors found, in the files that other people's evaluators read.

use detector::{Detection, DetectorOutput};

use super::ConversionError;
use crate::annotation::LabeledScan;
use crate::dataset::foreign_frame::ForeignFrame;

pub mod detection_rows;
pub mod kitti_results;
pub mod nuscenes_results;
pub mod argoverse2_results;
pub mod own_results;
pub mod result_folder;

/// A file that is to be written, by its name below a folder, with `/` between folders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultFile {
    /// The name.
    pub name: String,
    /// What is in it.
    pub content: Vec<u8>,
}

/// Results in some format: of one detector in the scans of one data set.
pub trait ResultWriter {
    /// Takes what was found in a scan, and returns the files that are complete with it.
    fn add(&mut self, scan: &LabeledScan, frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles;

    /// The files that are complete after the last scan.
    fn finish(self: Box<Self>) -> CompleteFiles;

    /// Whether the format has a class for what is no vehicle; it is left out otherwise.
    fn has_objects(&self) -> bool {
        true
    }
}

/// All that evaluators may rank: the detections, then the unlikely vehicles, which is said of each.
fn ranked(output: &DetectorOutput) -> impl Iterator<Item = (Detection<'_>, bool)> {
    let detections = output.detections.iter().map(|it| (it, false));
    detections.chain(output.unlikely_vehicles.iter().map(|it| (it, true)))
}

/// Files that are complete.
pub type CompleteFiles = Result<Vec<ResultFile>, ConversionError>;

/// The error of a writer for a data set that its format is not for.
fn unwritable(scan: &LabeledScan, format: &'static str, problem: &str) -> ConversionError {
    ConversionError::Unwritable { scan: scan.id.to_string(), format, problem: problem.to_owned() }
}
