//! Recorders of a run, scan by scan, and their input.

use std::collections::BTreeMap;
use std::fmt;

use detector::DetectorOutput;
use reports::verdicts::change::ChangeKind;
use scans::annotation::LabeledScan;

use super::sink::JudgedScan;
use crate::matching::outcome::Assignment;

/// A scan that is recorded.
pub struct RecordedScan<'a> {
    /// The scan with the results of all detectors.
    pub judged: &'a JudgedScan<'a>,
    /// Marked positions in it.
    pub marks: &'a [Mark],
}

/// A marked position.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Position on the ground plan, in the frame of the sensor, in metres.
    pub position_m: [f32; 2],
    /// Label of the mark.
    pub text: String,
    /// The kind of change that it points at, if it is one.
    pub change: Option<ChangeKind>,
}

/// What is pointed at in a recording: by detector, and by number of the scan.
pub type MarksByDetector = BTreeMap<String, BTreeMap<i64, Vec<Mark>>>;

/// A scan with the results of two runs, as their rows say: nothing is detected or matched again.
pub struct ChangedScan<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Its number in the recording.
    pub number: usize,
    /// Marked changes.
    pub marks: &'a [Mark],
    /// All that is pointed at, in words, with the kind of change if it is one.
    pub lines: &'a [(Option<ChangeKind>, String)],
    /// Before, and after.
    pub sides: [SideOfScan; 2],
}

/// The results of one run in a scan.
pub struct SideOfScan {
    /// Name of the run.
    pub name: &'static str,
    /// Its detections, without points.
    pub output: DetectorOutput,
    /// Their outcomes.
    pub assignment: Assignment,
}

/// Records scans while a run goes on.
pub trait ScanRecorder {
    /// Why a scan cannot be recorded.
    type Error;

    /// Records one scan, if it is selected for recording. Returns a warning the first time that data is lost.
    ///
    /// # Errors
    ///
    /// If the recording cannot be written.
    fn record(&mut self, recorded: &RecordedScan<'_>) -> Result<Option<String>, Self::Error>;

    /// Records one scan of two runs.
    ///
    /// # Errors
    ///
    /// If the recording cannot be written.
    fn record_change(&mut self, changed: &ChangedScan<'_>) -> Result<(), Self::Error>;

    /// Completes the recording.
    ///
    /// # Errors
    ///
    /// If the recording cannot be completed.
    fn finish(self) -> Result<RecordingEnding, Self::Error>;
}

/// A view of the products of a stage of a detector, as a figure shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FigureView {
    /// Its name.
    pub title: &'static str,
    /// The detector.
    pub detector: &'static str,
    /// The stage.
    pub stage: &'static str,
}

/// How a recording ended.
#[derive(Debug)]
pub struct RecordingEnding {
    /// Warning of lost data, if it has not been returned before.
    pub warning: Option<String>,
    /// The server that still serves the recording.
    pub served: Option<Box<dyn Served>>,
}

/// A recording that is complete and can be connected to until this is dropped.
pub trait Served: fmt::Debug {
    /// Address of the recording.
    fn url(&self) -> &str;
}
