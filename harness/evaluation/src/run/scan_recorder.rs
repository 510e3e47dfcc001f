//! Recorders of a run, scan by scan, and their input.

use std::fmt;

use super::sink::JudgedScan;

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
