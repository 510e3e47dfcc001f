//! Recordings for the Rerun viewer.

use evaluation::run::scan_recorder::{RecordedScan, RecordingEnding, ScanRecorder};
use evaluation::sweep::summary::SweepResults;
use reports::run_directory::RunDirectory;
use reports::table::sweep_score::SweepScores;
use viewer::run_recording::{RecordingError, RunRecording, RunRecordingOptions};
use viewer::sweep_recording;
use viewer::{FirstTab, Opening, StreamError, StreamOptions, ViewerChoice};

use super::RecordingPlan;
use crate::cli::stream::{StreamArgs, TabName};
use crate::commands::failure::{Classified, Failure};
use crate::commands::standard_streams::print_diagnostic;

/// An open recording of a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Recorder(RunRecording);

/// Whether a recording is asked for.
///
/// # Errors
///
/// None here.
#[allow(clippy::unnecessary_wraps, reason = "without the viewer there is an error")]
pub fn is_wanted(arguments: &StreamArgs) -> anyhow::Result<bool> {
    Ok(!arguments.no_rrd)
}

/// Begins the recording of `plan`; `None` if none is wanted.
///
/// # Errors
///
/// If the file cannot be written, or the viewer or the server not be started.
pub fn begin(plan: &RecordingPlan<'_>) -> anyhow::Result<Option<Recorder>> {
    let arguments = plan.arguments;
    if arguments.no_rrd {
        return Ok(None);
    }
    let viewer = match (&arguments.connect, arguments.spawn, arguments.serve) {
        (Some(url), _, _) => ViewerChoice::Connect(url.parse().map_err(of_stream)?),
        (None, true, _) => ViewerChoice::Spawn,
        (None, false, Some(port)) => ViewerChoice::Serve { port },
        (None, false, None) => ViewerChoice::None,
    };
    let opening = Opening {
        shown_task: plan.shown_task,
        first_tab: match arguments.blueprint {
            TabName::Compare => FirstTab::Compare,
            TabName::Stages => FirstTab::Stages,
            TabName::Drive => FirstTab::Drive,
        },
        has_poses: plan.has_poses,
        at_the_start: plan.at_the_start,
    };
    let options = RunRecordingOptions {
        stream: StreamOptions {
            name: plan.name.to_owned(),
            file: plan.default_file.clone(),
            viewer,
            opening,
            max_points: arguments.rerun_points,
        },
        elsewhere: arguments.save_rrd.clone().flatten(),
        every: arguments.rerun_every,
    };
    let recording = RunRecording::begin(options, plan.detectors).map_err(of_stream)?;
    if let Some(url) = recording.served_at() {
        print_diagnostic(format_args!("The recording is served: rerun {url}"));
    }
    Ok(Some(Recorder(recording)))
}

impl ScanRecorder for Recorder {
    type Error = anyhow::Error;

    fn record(&mut self, recorded: &RecordedScan<'_>) -> anyhow::Result<Option<String>> {
        self.0.record(recorded).map_err(classified)
    }

    fn finish(self) -> anyhow::Result<RecordingEnding> {
        self.0.finish().map_err(classified)
    }
}

/// Records one scan of a sweep at all its points.
///
/// # Errors
///
/// If the scan cannot be read or the file not be written.
pub fn record_sweep(
    directory: &RunDirectory,
    results: &SweepResults<'_>,
    scores: &SweepScores,
) -> anyhow::Result<()> {
    sweep_recording::record_sweep(directory, results, scores).map_err(classified)
}

/// The version of Rerun that recordings are made with.
#[allow(clippy::unnecessary_wraps, reason = "without the viewer there is none")]
pub fn rerun_version() -> Option<String> {
    Some(viewer::rerun_version())
}

fn classified(error: RecordingError) -> anyhow::Error {
    match error {
        RecordingError::Dataset(error) => error.into(),
        RecordingError::Stream(error) => of_stream(error),
    }
}

fn of_stream(error: StreamError) -> anyhow::Error {
    let failure = match &error {
        StreamError::BadUrl { .. }
        | StreamError::SwitchedOff
        | StreamError::ViewerNotInstalled { .. }
        | StreamError::ViewerFailed { .. } => Failure::Usage,
        StreamError::Create { source, .. } => Failure::of_writing(source.kind()),
        StreamError::Serve { .. }
        | StreamError::Write { .. }
        | StreamError::Log { .. }
        | StreamError::UnknownDetector { .. }
        | StreamError::ProductLength { .. }
        | StreamError::AssignmentLength { .. } => Failure::Internal,
    };
    Classified { failure, error: error.into() }.into()
}
