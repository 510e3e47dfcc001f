//! The recording of a run, scan by scan.

use std::path::{Path, PathBuf};

use evaluation::matching::mistake::Evidence;
use evaluation::matching::outcome::Assignment;
use evaluation::metrics::counts::FalseDetections;
use evaluation::process::problem::DetectorFailure;
use evaluation::run::scan_recorder::{
    ChangedScan, RecordedScan, RecordingEnding, ScanRecorder, Served, SideOfScan,
};
use evaluation::run::side_by_side::DetectorScan;
use reports::files::unfinished::{Kind, Unfinished};
use reports::numbers::tally::Tally;
use reports::rows::counts::Counts;
use scans::dataset::{DatasetDescription, DatasetError};
use tempfile::NamedTempFile;

use super::drive_frame::DriveFrame;
use super::error::StreamError;
use super::scan_views::{DetectorView, ScanView, TaskView};
use super::session::Stream;
use super::stream_options::{RecordingTarget, StreamOptions};
use super::viewer::ViewerState;

/// An open recording that follows a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct RunRecording {
    stream: Stream,
    elsewhere: Option<RecordingElsewhere>,
    every: u32,
    drive: DriveFrame,
    tally: Tally,
    viewer_was_lost: bool,
}

/// How and where a run is recorded, and which of its scans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunRecordingOptions {
    /// How it is streamed.
    pub stream: StreamOptions,
    /// Where it is written.
    pub path: RecordingPath,
    /// One of so many scans is recorded.
    pub every: u32,
}

/// Where a recording is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingPath {
    /// A folder of layers, in a folder that is itself unfinished.
    Layers {
        /// The folder.
        folder: PathBuf,
        /// That of a recording over the same scans, if they are to be put into it.
        joins: Option<PathBuf>,
    },
    /// A file that appears once it is complete. It is one that the user has named: a link stays one, and a device or a pipe is written to.
    Named(PathBuf),
    /// A file that appears once it is complete, in the directory of a run: a link is replaced.
    InRun(PathBuf),
}

/// Why a run cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The recording cannot be made.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The data set cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A detector that is run once more fails.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
}

impl RunRecording {
    /// Begins the recording of `detectors`.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the file cannot be written, or the viewer or the server not be started.
    pub fn begin(options: RunRecordingOptions, detectors: &[&str]) -> Result<Self, StreamError> {
        let RunRecordingOptions { stream, path, every } = options;
        let (target, elsewhere) = match path {
            RecordingPath::Layers { folder, joins } => (RecordingTarget::Layers { folder, joins }, None),
            RecordingPath::Named(file) => RecordingElsewhere::begin(&file, true)?,
            RecordingPath::InRun(file) => RecordingElsewhere::begin(&file, false)?,
        };
        Ok(Self {
            stream: Stream::open(&target, &stream, detectors)?,
            elsewhere,
            every,
            drive: DriveFrame::default(),
            tally: Tally::default(),
            viewer_was_lost: false,
        })
    }

    /// Where viewers can connect to, if the recording is served.
    pub fn served_at(&self) -> Option<&str> {
        self.stream.served_at()
    }
}

impl ScanRecorder for RunRecording {
    type Error = RecordingError;

    fn record(&mut self, recorded: &RecordedScan<'_>) -> Result<Option<String>, RecordingError> {
        let RecordedScan { judged, marks } = *recorded;
        let number = judged.number();
        for row in judged.rows.iter().flat_map(|it| &it.tasks) {
            self.tally.add_scan(&row.scan);
        }
        if !number.is_multiple_of(self.every as usize) {
            return Ok(None);
        }
        let (results, description) = (judged.results, judged.dataset());
        let scan = results.scan;
        let pose = judged.watched.dataset.world_from_sensor(judged.scan_idx())?;
        let world_from_sensor = pose.map(|it| self.drive.start_from_sensor(&description.id, &scan.id, it));
        let step = number as i64;
        let drive_m = self.drive.positions_m();
        self.stream.log_scan(&ScanView { scan, step, marks, world_from_sensor, drive_m })?;
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let products = detector.stage_products(&scan.cloud);
            let criterion = judged.watched.criterion;
            let evidence = Evidence::gather(scan, &result.output.detections, &products, criterion);
            let f_rates = shown(result).map(|it| {
                self.tally.counts(&description.id, it.task, result.detector)?.drawn(Counts::f_rate)
            });
            let tasks = task_views(result, description, &evidence, f_rates);
            let view = DetectorView {
                name: result.detector,
                output: &result.output,
                products: &products,
                tasks: &tasks,
                latency: result.times.first,
            };
            self.stream.log_detector(scan, &view)?;
        }
        match self.stream.viewer_state() {
            ViewerState::Lost { reason } if !self.viewer_was_lost => {
                self.viewer_was_lost = true;
                Ok(Some(format!(
                    "lost the connection to the viewer ({reason}); the recording continues in the file"
                )))
            }
            _ => Ok(None),
        }
    }

    fn record_change(&mut self, changed: &ChangedScan<'_>) -> Result<(), RecordingError> {
        let ChangedScan { scan, number, marks, lines, sides } = changed;
        let (step, world_from_sensor) = (*number as i64, None);
        self.stream.log_scan(&ScanView { scan, step, marks, world_from_sensor, drive_m: &[] })?;
        for SideOfScan { name, output, assignment } in sides {
            let tasks = [TaskView {
                assignment,
                false_detections: FalseDetections::Known,
                mistakes: Vec::new(),
                f_rate_so_far: None,
            }];
            let view = DetectorView { name, output, products: &[], tasks: &tasks, latency: None };
            self.stream.log_detector(scan, &view)?;
        }
        // One list for both.
        let [_, after] = sides;
        Ok(self.stream.log_changes(after.name, after.assignment.task, lines)?)
    }

    fn finish(self) -> Result<RecordingEnding, RecordingError> {
        let ending = self.stream.finish()?;
        if let Some(elsewhere) = self.elsewhere {
            elsewhere.finish()?;
        }
        let warning = match ending.viewer {
            ViewerState::Lost { reason } if !self.viewer_was_lost => Some(format!(
                "lost the connection to the viewer ({reason}), which may miss the end; the file is complete"
            )),
            _ => None,
        };
        let served = ending.served.map(|it| Box::new(it) as Box<dyn Served>);
        Ok(RecordingEnding { warning, served })
    }
}

/// How a detector did on a scan in each task, with the F-rates so far in the order of the tasks.
pub fn task_views<'a>(
    result: &'a DetectorScan,
    dataset: &DatasetDescription,
    evidence: &Evidence<'_>,
    f_rates_so_far: impl Iterator<Item = Option<f64>>,
) -> Vec<TaskView<'a>> {
    let view = |(assignment, f_rate_so_far): (&'a Assignment, Option<f64>)| TaskView {
        assignment,
        false_detections: FalseDetections::of(&dataset.annotated, assignment.task),
        mistakes: evidence.mistakes(assignment),
        f_rate_so_far,
    };
    shown(result).zip(f_rates_so_far).map(view).collect()
}

/// The tasks that have views: labels of boxes say which class was given.
fn shown(result: &DetectorScan) -> impl Iterator<Item = &Assignment> {
    result.assignments.iter().filter(|it| it.task.class().is_none())
}

/// A file that is not complete.
pub(super) struct RecordingElsewhere {
    file: PathBuf,
    made: NamedTempFile,
    registered: Unfinished,
}

impl RecordingElsewhere {
    /// Where to write what will be at the path `asked`, and what makes it appear there: nothing of a device or a pipe.
    pub(super) fn begin(
        asked: &Path,
        is_named: bool,
    ) -> Result<(RecordingTarget, Option<Self>), StreamError> {
        let create_error = |source| StreamError::Create { path: asked.to_owned(), source };
        let file = asked.canonicalize().ok().filter(|_| is_named).unwrap_or_else(|| asked.to_owned());
        let there = if is_named { file.metadata() } else { file.symlink_metadata() };
        match there {
            Ok(it) if it.is_dir() => return Err(create_error(std::io::ErrorKind::IsADirectory.into())),
            Ok(it) if is_named && !it.is_file() => return Ok((RecordingTarget::Device(file), None)),
            _ => {}
        }
        let folder = file.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".recording-").suffix(".rrd");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As for any other file: the umask decides who may read it.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let make = || builder.tempfile_in(folder);
        let (registered, made) =
            Unfinished::begin(Kind::File, make, |it| it.path().to_path_buf()).map_err(create_error)?;
        let target = RecordingTarget::File(made.path().to_owned());
        Ok((target, Some(Self { file, made, registered })))
    }

    /// Where it is written.
    pub(super) fn path(&self) -> &Path {
        self.made.path()
    }

    pub(super) fn finish(self) -> Result<(), StreamError> {
        let Self { file, made, registered } = self;
        let persisted = registered.undisturbed(|| made.persist(&file));
        persisted.map_err(|it| StreamError::Create { path: file, source: it.error })?;
        Ok(())
    }
}
