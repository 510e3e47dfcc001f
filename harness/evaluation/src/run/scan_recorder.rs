//! What records a run scan by scan, and what it gets of each scan.

use std::fmt;

use super::sink::JudgedScan;

/// A scan that is recorded.
pub struct RecordedScan<'a> {
    /// The scan with what all detectors made of it.
    pub judged: &'a JudgedScan<'a>,
    /// Positions in it that are pointed at.
    pub marks: &'a [Mark],
}

/// A position that is pointed at.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// On the ground plan of the sensor, in metres.
    pub position_m: [f32; 2],
    /// What is there.
    pub text: String,
}

/// Records scans while a run goes on.
pub trait ScanRecorder {
    /// Why it cannot.
    type Error;

    /// Records one scan, if it is its turn. Returns a warning the first time that something is lost.
    ///
    /// # Errors
    ///
    /// If the recording cannot be written.
    fn record(&mut self, recorded: &RecordedScan<'_>) -> Result<Option<String>, Self::Error>;

    /// Ends the recording, which is complete then.
    ///
    /// # Errors
    ///
    /// If it is not complete.
    fn finish(self) -> Result<RecordingEnding, Self::Error>;
}

/// A view of what a stage of a detector leaves behind, as a figure shows it.
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
    /// What was lost, if it has not been said before.
    pub warning: Option<String>,
    /// The server that still has the recording.
    pub served: Option<Box<dyn Served>>,
}

/// A recording that is complete and can be connected to until this is dropped.
pub trait Served: fmt::Debug {
    /// Where.
    fn url(&self) -> &str;
}
