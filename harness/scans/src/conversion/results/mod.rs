//! Detections in the files that other people's evaluators read.

use detector::{Detection, DetectorOutput};

use super::ConversionError;
use crate::annotation::LabeledScan;
use crate::dataset::foreign_frame::ForeignFrame;

pub mod detection_rows;
pub mod class_words;
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
    /// Its bytes.
    pub content: Vec<u8>,
}

/// Writer of results in some format: of one detector in the scans of one data set.
pub trait ResultWriter {
    /// Takes the output of the detector for a scan, and returns the files that are complete with it.
    fn add(&mut self, scan: &LabeledScan, frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles;

    /// The files that are complete after the last scan.
    fn finish(self: Box<Self>) -> CompleteFiles;

    /// Whether the format has a class for objects that are no vehicles; otherwise they are left out.
    fn has_objects(&self) -> bool {
        true
    }
}

/// All boxes that evaluators may rank: the detections, then the unlikely vehicles, each with whether it is one. Their boxes
/// have a volume: the points of a fence seen from its end lie in one plane, and readers take a side of 0 for damage.
fn ranked(output: &DetectorOutput) -> impl Iterator<Item = (Detection<'_>, bool)> {
    let detections = output.detections.iter().map(|it| (it, false));
    let all = detections.chain(output.unlikely.iter().map(|it| (it, true)));
    all.map(|(mut it, is_unlikely)| {
        it.bounding_box.length_width_height_m =
            it.bounding_box.length_width_height_m.map(|side_m| side_m.max(LEAST_SIDE_M));
        (it, is_unlikely)
    })
}

/// The shortest side of a written box, in metres.
const LEAST_SIDE_M: f32 = 0.01;

/// Files that are complete.
pub type CompleteFiles = Result<Vec<ResultFile>, ConversionError>;

/// The error of a writer about a data set that does not fit its format.
fn unwritable(scan: &LabeledScan, format: &'static str, problem: &str) -> ConversionError {
    ConversionError::Unwritable { scan: scan.id.to_string(), format, problem: problem.to_owned() }
}

#[cfg(test)]
mod tests {
    use detector::{DetectedClass, OrientedBox};

    use super::*;

    #[test]
    fn a_written_box_has_a_volume_and_a_solid_one_stays_as_it_is() {
        let mut output = DetectorOutput::default();
        let fence =
            OrientedBox { center_m: [9.0, 2.0, -1.0], length_width_height_m: [1.9, 0.0, 1.7], yaw_rad: 0.3 };
        let car = OrientedBox { length_width_height_m: [4.2, 1.7, 1.5], ..fence };
        output.detections.push(Detection::new(&[0], fence, DetectedClass::Object, None));
        output.unlikely.push(Detection::new(&[], car, DetectedClass::Vehicle, None));
        let written: Vec<_> =
            ranked(&output).map(|(it, is_unlikely)| (it.bounding_box, is_unlikely)).collect();
        let fence = OrientedBox { length_width_height_m: [1.9, LEAST_SIDE_M, 1.7], ..fence };
        assert_eq!(written, [(fence, false), (car, true)]);
    }
}
