//! The Rerun recording of a run, where the program was built with Rerun.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use reports::files::unfinished::{Kind, Unfinished};
use reports::vocabulary::task::Task;
use tempfile::NamedTempFile;

use crate::cli::{StreamArgs, TabName};
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::standard_streams::print_diagnostic;
use crate::dataset::{Dataset, DatasetDescription};
use crate::matching::criterion::Criterion;
use crate::matching::mistake::Evidence;
use crate::matching::outcome::Assignment;
use crate::metrics::counts::FalseDetections;
use crate::run::drive_frame::DriveFrame;
use crate::run::scores::DatasetScores;
use crate::run::side_by_side::{DetectorScan, ScanResults};
use crate::stream::{
    DetectorView, FirstTab, Mark, Opening, ScanView, ServedRecording, Stream, StreamError, StreamOptions,
    TaskView, ViewerChoice, ViewerState,
};

/// An open recording that follows a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Recording {
    stream: Stream,
    elsewhere: Option<RecordingElsewhere>,
    every: u32,
    n_scans: u32,
    drive: DriveFrame,
    viewer_was_lost: bool,
}

/// What a recording is about.
pub struct RecordingPlan<'a> {
    /// What was asked for.
    pub arguments: &'a StreamArgs,
    /// Where it is written unless the arguments say otherwise.
    pub default_file: PathBuf,
    /// Its name in the viewer.
    pub name: &'a str,
    /// The task that it shows at first.
    pub shown_task: Task,
    /// The detectors.
    pub detectors: &'a [&'a str],
    /// Where the scans come from.
    pub datasets: &'a [OpenedDataset],
    /// Whether it opens at its first scan, and not at the last.
    pub at_the_start: bool,
}

/// A scan that is recorded.
pub struct RecordedScan<'a> {
    /// What the detectors made of it.
    pub results: &'a ScanResults<'a>,
    /// The scores of its data set so far.
    pub scores: &'a DatasetScores,
    /// Its data set.
    pub dataset: &'a dyn Dataset,
    /// Which of the data set's scans it is.
    pub scan_idx: usize,
    /// How it was judged.
    pub criterion: Criterion,
    /// Places in it that are pointed at.
    pub marks: &'a [Mark],
}

/// How a recording ended.
#[derive(Debug)]
pub struct RecordingEnding {
    /// What went wrong with the viewer, if it has not been said before.
    pub warning: Option<String>,
    /// The server that still has the recording.
    pub served: Option<ServedRecording>,
}

impl Recording {
    /// Begins the recording of `plan`; `None` if none is wanted.
    ///
    /// # Errors
    ///
    /// If the file cannot be written, or the viewer or the server not be started.
    pub fn begin(plan: &RecordingPlan<'_>) -> anyhow::Result<Option<Self>> {
        let arguments = plan.arguments;
        if arguments.no_rrd {
            return Ok(None);
        }
        let viewer = match (&arguments.connect, arguments.spawn, arguments.serve) {
            (Some(url), _, _) => ViewerChoice::Connect(url.parse()?),
            (None, true, _) => ViewerChoice::Spawn,
            (None, false, Some(port)) => ViewerChoice::Serve { port },
            (None, false, None) => ViewerChoice::None,
        };
        let elsewhere = arguments.save_rrd.as_ref().and_then(Option::as_deref);
        let elsewhere = elsewhere.map(RecordingElsewhere::begin).transpose()?;
        let file = elsewhere.as_ref().map_or_else(|| plan.default_file.clone(), |it| it.path().to_owned());
        let opening = Opening {
            shown_task: plan.shown_task,
            first_tab: match arguments.blueprint {
                TabName::Compare => FirstTab::Compare,
                TabName::Stages => FirstTab::Stages,
                TabName::Drive => FirstTab::Drive,
            },
            has_poses: plan.datasets.iter().any(has_poses),
            at_the_start: plan.at_the_start,
        };
        let (name, max_points) = (plan.name.to_owned(), arguments.rerun_points);
        let options = StreamOptions { name, file, viewer, opening, max_points };
        let stream = Stream::open(&options, plan.detectors)?;
        if let Some(url) = stream.served_at() {
            print_diagnostic(format_args!("The recording is served: rerun {url}"));
        }
        Ok(Some(Self {
            stream,
            elsewhere,
            every: arguments.rerun_every,
            n_scans: 0,
            drive: DriveFrame::default(),
            viewer_was_lost: false,
        }))
    }

    /// Logs one scan, if it is its turn, and what all detectors made of it. Returns a warning the first time the viewer is
    /// lost.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn log(&mut self, recorded: &RecordedScan<'_>) -> anyhow::Result<Option<String>> {
        let number = self.n_scans;
        self.n_scans += 1;
        if !number.is_multiple_of(self.every) {
            return Ok(None);
        }
        let RecordedScan { results, scores, dataset, .. } = recorded;
        let description = dataset.description();
        let scan = results.scan;
        let pose = dataset.world_from_sensor(recorded.scan_idx)?;
        let world_from_sensor = pose.map(|it| self.drive.start_from_sensor(&description.id, &scan.id, it));
        let step = i64::from(number);
        let drive_m = self.drive.places_m();
        self.stream.log_scan(&ScanView { scan, step, marks: recorded.marks, world_from_sensor, drive_m })?;
        for (detector_idx, (result, detector)) in results.results.iter().zip(results.detectors).enumerate() {
            let products = detector.stage_products(&scan.cloud);
            let evidence = Evidence::gather(scan, &result.output.detections, &products, recorded.criterion);
            let f_rates = scores.f_rates(detector_idx).into_iter().map(|(_, f_rate)| f_rate);
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
                Ok(Some(format!("the viewer was lost ({reason}); the recording goes on to the file alone")))
            }
            _ => Ok(None),
        }
    }

    /// Writes the end of the file.
    ///
    /// # Errors
    ///
    /// If the file is not complete.
    pub fn finish(self) -> anyhow::Result<RecordingEnding> {
        let ending = self.stream.finish()?;
        if let Some(elsewhere) = self.elsewhere {
            elsewhere.finish()?;
        }
        let warning = match ending.viewer {
            ViewerState::Lost { reason } if !self.viewer_was_lost => {
                Some(format!("the viewer was lost ({reason}) and may lack the end; the file is complete"))
            }
            _ => None,
        };
        Ok(RecordingEnding { warning, served: ending.served })
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
    result.assignments.iter().zip(f_rates_so_far).map(view).collect()
}

/// Goes on serving the recording, of which everything is written, until the user ends it.
pub fn serve_until_interrupted(served: &ServedRecording, interrupted: &AtomicBool) {
    print_diagnostic(format_args!("Serving the recording until Ctrl-C: rerun {}", served.url));
    while !interrupted.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn has_poses(opened: &OpenedDataset) -> bool {
    let first = opened.scan_indices.first();
    first.is_some_and(|&scan_idx| matches!(opened.dataset.world_from_sensor(scan_idx), Ok(Some(_))))
}

/// A recording outside of the run directory.
struct RecordingElsewhere {
    file: PathBuf,
    /// Where it is written until it is complete; `None` for devices and pipes, which are written at once.
    unfinished: Option<(NamedTempFile, Unfinished)>,
}

impl RecordingElsewhere {
    fn begin(file: &Path) -> Result<Self, StreamError> {
        let create_error = |source| StreamError::Create { path: file.to_owned(), source };
        if file.is_dir() {
            return Err(create_error(std::io::ErrorKind::IsADirectory.into()));
        }
        // A link stays one, and a device is not replaced by a file.
        let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        if file.exists() && !file.is_file() {
            return Ok(Self { file, unfinished: None });
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
        Ok(Self { file, unfinished: Some((made, registered)) })
    }

    /// Where to write.
    fn path(&self) -> &Path {
        self.unfinished.as_ref().map_or(&self.file, |(made, _)| made.path())
    }

    fn finish(self) -> Result<(), StreamError> {
        if let Some((made, registered)) = self.unfinished {
            let persisted = registered.undisturbed(|| made.persist(&self.file));
            persisted.map_err(|it| StreamError::Create { path: self.file, source: it.error })?;
        }
        Ok(())
    }
}
