//! What is logged of a scan.

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
    /// Where the sensor was, in a frame that rests, if that is known.
    pub world_from_sensor: Option<Isometry3<f64>>,
    /// Where it was lately in that frame, in metres.
    pub drive_m: &'a [[f32; 3]],
}

/// What one detector made of one scan.
#[derive(Debug, Clone, Copy)]
pub struct DetectorView<'a> {
    /// Its name, as announced when the stream was opened.
    pub name: &'a str,
    /// What it reports.
    pub output: &'a DetectorOutput,
    /// What its stages left behind.
    pub products: &'a [StageProduct],
    /// How that is judged, for each task.
    pub tasks: &'a [TaskView<'a>],
    /// Time of the whole detection.
    pub latency: Option<Duration>,
}

/// How a detector did on one scan in one task.
#[derive(Debug, Clone)]
pub struct TaskView<'a> {
    /// What became of every annotation and detection.
    pub assignment: &'a Assignment,
    /// Whether it can be known what is false.
    pub false_detections: FalseDetections,
    /// What was missed or is false, in words.
    pub mistakes: Vec<Mistake>,
    /// The F-rate over the scans so far, 0 to 1; `None` while its denominator is zero.
    pub f_rate_so_far: Option<f64>,
}
