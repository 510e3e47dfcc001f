//! The parts of a scan that are logged.

use std::time::Duration;

use detector::{DetectorOutput, StageProduct};
use evaluation::matching::mistake::Mistake;
use evaluation::matching::outcome::Assignment;
use evaluation::metrics::counts::FalseDetections;
use evaluation::run::scan_recorder::Mark;
use nalgebra::Isometry3;
use scans::annotation::LabeledScan;

/// A scan of a recording.
#[derive(Debug, Clone, Copy)]
pub struct ScanView<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Its position on the axis of the recording.
    pub step: i64,
    /// Positions that are pointed at.
    pub marks: &'a [Mark],
    /// Pose of the sensor, in a frame that rests, if known.
    pub world_from_sensor: Option<Isometry3<f64>>,
    /// Its latest positions in that frame, in metres.
    pub drive_m: &'a [[f32; 3]],
}

/// Results of one detector on one scan.
#[derive(Debug, Clone, Copy)]
pub struct DetectorView<'a> {
    /// Its name, as announced when the stream was opened.
    pub name: &'a str,
    /// Its output.
    pub output: &'a DetectorOutput,
    /// Its stage products.
    pub products: &'a [StageProduct],
    /// Their outcomes, for each task.
    pub tasks: &'a [TaskView<'a>],
    /// Time of the whole detection.
    pub latency: Option<Duration>,
}

/// How a detector did on one scan in one task.
#[derive(Debug, Clone)]
pub struct TaskView<'a> {
    /// Outcomes of all annotations and detections.
    pub assignment: &'a Assignment,
    /// Whether false detections can be known.
    pub false_detections: FalseDetections,
    /// Missed and false objects, in words.
    pub mistakes: Vec<Mistake>,
    /// The F-rate over the scans so far, 0 to 1; `None` while its denominator is zero.
    pub f_rate_so_far: Option<f64>,
}
