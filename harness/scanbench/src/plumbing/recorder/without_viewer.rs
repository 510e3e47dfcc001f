//! Stand-ins for recorders in a program that was built without the viewer: they record nothing.

use std::path::Path;

use evaluation::partial::growth::Growth;
use evaluation::run::scan_recorder::{
    ChangedScan, MarksByDetector, RecordedScan, RecordingEnding, ScanRecorder,
};
use evaluation::streaming::stream_picture::StreamPicture;
use evaluation::sweep::quality_pass::SweptDataset;
use evaluation::sweep::sweep_plan::SweepPlan;
use reports::numbers::sweep_score::SweepScores;
use reports::run_folder::run_directory::RunDirectory;
use scans::annotation::LabeledScan;

use super::RecordingPlan;
use crate::cli::{PartialArgs, StreamArgs};
use crate::plumbing::failure::{Failure, Usage};

/// No recorder exists.
pub enum Recorder {}

/// Whether a recording is asked for: never.
pub fn is_wanted(arguments: &StreamArgs) -> Result<bool, Failure> {
    let for_recordings = [
        ("--save-rrd", arguments.save_rrd.is_some()),
        ("--connect", arguments.connect.is_some()),
        ("--spawn", arguments.spawn),
        ("--serve", arguments.serve.is_some()),
    ];
    match for_recordings.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            Err(Usage(format!("{option} needs Rerun, but this program was built without it")).into())
        }
        None => Ok(false),
    }
}

/// Begins no recording.
pub fn begin(plan: &RecordingPlan<'_>) -> Result<Option<Recorder>, Failure> {
    is_wanted(plan.arguments).map(|_| None)
}

impl ScanRecorder for Recorder {
    type Error = Failure;

    fn record(&mut self, _: &RecordedScan<'_>) -> Result<Option<String>, Failure> {
        match *self {}
    }

    fn record_change(&mut self, _: &ChangedScan<'_>) -> Result<(), Failure> {
        match *self {}
    }

    fn finish(self) -> Result<RecordingEnding, Failure> {
        match self {}
    }
}

/// Records nothing.
#[allow(clippy::unnecessary_wraps, reason = "with the viewer there are errors")]
pub fn record_sweep(
    _: &RunDirectory,
    _: &SweepPlan,
    _: &SweptDataset<'_>,
    _: &SweepScores,
) -> Result<(), Failure> {
    Ok(())
}

/// Whether objects that grow are recorded: never.
pub fn records_growths(_: &PartialArgs) -> bool {
    false
}

/// Records nothing.
#[allow(clippy::unnecessary_wraps, reason = "with the viewer there are errors")]
pub fn record_growths(_: &Path, _: &str, _: &[Growth]) -> Result<(), Failure> {
    Ok(())
}

/// Refuses.
pub fn record_marks(_: &Path, _: &MarksByDetector) -> Result<(), Failure> {
    Err(Usage("--with-viewer needs Rerun, but this program was built without it".to_owned()).into())
}

/// Refuses.
pub fn record_stream(
    _: &Path,
    _: &str,
    _: &StreamPicture,
    _: impl FnMut(usize) -> Result<LabeledScan, Failure>,
) -> Result<(), Failure> {
    Err(Usage("--save-rrd needs Rerun, but this program was built without it".to_owned()).into())
}

/// None: no recordings are made.
pub fn rerun_version() -> Option<String> {
    None
}
