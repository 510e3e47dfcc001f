//! Recordings for the Rerun viewer.

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
use viewer::run_recording::{RecordingError, RecordingPath, RunRecording, RunRecordingOptions};
use viewer::stream_recording::StreamRecording;
use viewer::{
    FirstTab, Opening, PointChoice, StreamError, StreamOptions, ViewerChoice, marks_layer, partial_recording,
    sweep_recording,
};

use super::{RecordingPlace, RecordingPlan};
use crate::cli::PartialArgs;
use crate::cli::stream::{RecordedPoints, StreamArgs, TabName};
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_diagnostic;

/// An open recording of a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Recorder(RunRecording);

#[allow(clippy::unnecessary_wraps, reason = "without the viewer there is an error")]
pub fn is_wanted(arguments: &StreamArgs) -> Result<bool, Failure> {
    Ok(!arguments.no_rrd)
}

/// Begins the recording of `plan`; `None` if none is wanted.
pub fn begin(plan: &RecordingPlan<'_>) -> Result<Option<Recorder>, Failure> {
    let arguments = plan.arguments;
    if arguments.no_rrd {
        return Ok(None);
    }
    let every = arguments.every(plan.n_scans);
    if arguments.rerun_every.is_none() && every > 1 {
        print_diagnostic(format_args!("One of {every} scans is recorded; --rerun-every 1 records all"));
    }
    let viewer = match (&arguments.connect, arguments.spawn, arguments.serve) {
        (Some(url), _, _) => ViewerChoice::Connect(url.parse()?),
        (None, true, _) => ViewerChoice::Spawn,
        (None, false, Some(port)) => ViewerChoice::Serve { port },
        (None, false, None) => ViewerChoice::None,
    };
    let opening = Opening {
        shown_task: plan.shown_task,
        first_tab: match arguments.blueprint {
            _ if plan.shows_changes => FirstTab::Changes,
            TabName::Compare => FirstTab::Compare,
            TabName::Stages => FirstTab::Stages,
            TabName::Drive => FirstTab::Drive,
        },
        has_poses: plan.has_poses,
        follows: plan.follows,
        figures: plan.figures,
    };
    let options = RunRecordingOptions {
        stream: StreamOptions {
            name: plan.name.to_owned(),
            viewer,
            opening,
            points: match arguments.rerun_points {
                None => PointChoice::for_scans(plan.n_scans.div_ceil(every as usize)),
                Some(RecordedPoints::All) => PointChoice::All,
                Some(RecordedPoints::AtMost(n)) => PointChoice::AtMost(n),
            },
        },
        path: match (arguments.save_rrd.clone().flatten(), plan.place.clone()) {
            (Some(file), _) => RecordingPath::Named(file),
            (None, RecordingPlace::File(file)) => RecordingPath::InRun(file),
            (None, RecordingPlace::Layers { folder, joins }) => RecordingPath::Layers { folder, joins },
        },
        every,
    };
    let recording = RunRecording::begin(options, plan.detectors)?;
    if let Some(url) = recording.served_at() {
        print_diagnostic(format_args!("The recording is served: rerun {url}"));
    }
    Ok(Some(Recorder(recording)))
}

impl ScanRecorder for Recorder {
    type Error = Failure;

    fn record(&mut self, recorded: &RecordedScan<'_>) -> Result<Option<String>, Failure> {
        Ok(self.0.record(recorded)?)
    }

    fn record_change(&mut self, changed: &ChangedScan<'_>) -> Result<(), Failure> {
        Ok(self.0.record_change(changed)?)
    }

    fn finish(self) -> Result<RecordingEnding, Failure> {
        Ok(self.0.finish()?)
    }
}

/// Records one scan of a sweep, from its first data set, at all points of the plan.
pub fn record_sweep(
    directory: &RunDirectory,
    plan: &SweepPlan,
    swept: &SweptDataset<'_>,
    scores: &SweepScores,
) -> Result<(), Failure> {
    Ok(sweep_recording::record_sweep(directory, plan, swept, scores)?)
}

pub fn records_growths(arguments: &PartialArgs) -> bool {
    !arguments.no_rrd
}

/// Records objects that grow to the file at `path`.
pub fn record_growths(path: &Path, name: &str, growths: &[Growth]) -> Result<(), Failure> {
    Ok(partial_recording::record_growths(path, name, growths)?)
}

/// Writes a layer with pointers at `marks` into the recording in `folder`.
pub fn record_marks(folder: &Path, marks: &MarksByDetector) -> Result<(), Failure> {
    Ok(marks_layer::write_marks(folder, marks)?)
}

/// Records `picture`, called `name`, to the file at `path`; `scan_of` reads the scan with this index in its drive.
pub fn record_stream(
    path: &Path,
    name: &str,
    picture: &StreamPicture,
    mut scan_of: impl FnMut(usize) -> Result<LabeledScan, Failure>,
) -> Result<(), Failure> {
    let recording = StreamRecording::begin(path, name, picture)?;
    for (scan_idx, taken) in picture.scans.iter().enumerate() {
        recording.add_scan(taken, &scan_of(scan_idx)?)?;
    }
    Ok(recording.finish()?)
}

/// The version of Rerun that recordings are made with.
#[allow(clippy::unnecessary_wraps, reason = "without the viewer there is none")]
pub fn rerun_version() -> Option<String> {
    Some(viewer::rerun_version())
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        match error {
            RecordingError::Dataset(error) => error.into(),
            RecordingError::Stream(error) => error.into(),
            RecordingError::Detector(error) => error.into(),
        }
    }
}

impl From<StreamError> for Failure {
    fn from(error: StreamError) -> Self {
        match &error {
            StreamError::BadUrl { .. }
            | StreamError::SwitchedOff
            | StreamError::ViewerNotInstalled { .. }
            | StreamError::ViewerFailed { .. } => Self::Usage(error.into()),
            StreamError::NoLayout { path, .. } => Self::damaged_run(&path.clone(), error),
            StreamError::Create { source, .. } => Self::of_writing(source.kind(), error),
            StreamError::Write { .. } => Self::Unwritten(error.into()),
            StreamError::Serve { .. }
            | StreamError::Log { .. }
            | StreamError::UnknownDetector { .. }
            | StreamError::ProductLength { .. }
            | StreamError::AssignmentLength { .. } => Self::Internal(error.into()),
        }
    }
}
