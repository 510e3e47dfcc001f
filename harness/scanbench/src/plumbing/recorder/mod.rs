//! Recorders of runs and sweeps for Rerun; in a program that was built without the viewer, stand-ins.
//!
//! Both have the same items; no other code asks what was built in.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::scan_recorder::{FigureView, RecordingEnding, ScanRecorder as _, Served};
use reports::vocabulary::task::Task;

use crate::cli::{NoRecordingArgs, StreamArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::standard_streams::print_diagnostic;

#[cfg(feature = "viewer")]
mod with_viewer;
#[cfg(feature = "viewer")]
pub use with_viewer::{
    Recorder, begin, is_wanted, record_growths, record_marks, record_stream, record_sweep, records_growths,
    rerun_version,
};
#[cfg(not(feature = "viewer"))]
mod without_viewer;
#[cfg(not(feature = "viewer"))]
pub use without_viewer::{
    Recorder, begin, is_wanted, record_growths, record_marks, record_stream, record_sweep, records_growths,
    rerun_version,
};

/// Says that `--no-rrd` changes nothing for `study`, which never writes a recording, if it is given.
pub fn say_that_none_is_written(arguments: &NoRecordingArgs, study: &str) {
    if arguments.no_rrd {
        print_diagnostic(format_args!("--no-rrd changes nothing: `{study}` never writes a Rerun recording"));
    }
}

/// Where a recording is written unless the user names a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingPlace {
    /// To a folder of layers, in a folder that is itself unfinished.
    Layers {
        folder: PathBuf,
        /// The folder of a recording over the same scans that they are to be put into.
        joins: Option<PathBuf>,
    },
    /// To a file, which appears once it is complete.
    File(PathBuf),
}

#[allow(dead_code, reason = "read by the viewer, where there is one")]
pub struct RecordingPlan<'a> {
    pub arguments: &'a StreamArgs,
    pub place: RecordingPlace,
    /// Its name in the viewer.
    pub name: &'a str,
    /// The task that it shows at first.
    pub shown_task: Task,
    pub detectors: &'a [&'a str],
    /// How many scans there are, recorded or not.
    pub n_scans: usize,
    /// Whether the poses of the sensor are known for some scans at least.
    pub has_poses: bool,
    /// Whether a viewer follows it while it grows. A complete one opens at its first scan.
    pub follows: bool,
    /// Whether it is of changes between two runs.
    pub shows_changes: bool,
    /// Figures that have a tab of their own.
    pub figures: &'static [FigureView],
}

/// Begins the recording in `place`, called `name`, of `compared_detectors` on `datasets`. Returns it with the number n where one
/// scan in n is recorded; `None` if no recording is wanted.
pub fn begin_recording(
    arguments: &StreamArgs,
    figures: &'static [FigureView],
    compared_detectors: &[ComparedDetector],
    datasets: &[OpenedDataset],
    name: &str,
    place: RecordingPlace,
) -> Result<Option<(Recorder, u64)>, Failure> {
    // False objects show only where they can be known: a run on cars and vans alone opens on the vehicles.
    let covers_objects = |it: &OpenedDataset| it.dataset.description().annotated.covers(Task::Objects);
    let shown_task = if datasets.iter().all(covers_objects) { Task::Objects } else { Task::Vehicles };
    let detectors: Vec<&str> = compared_detectors.iter().map(|it| it.name).collect();
    let n_scans = datasets.iter().map(|it| it.part.len()).sum();
    let recorder = begin(&RecordingPlan {
        arguments,
        place,
        name,
        shown_task,
        detectors: &detectors,
        n_scans,
        has_poses: datasets.iter().any(OpenedDataset::has_poses),
        follows: true,
        shows_changes: false,
        figures,
    })?;
    Ok(recorder.map(|it| (it, u64::from(arguments.every(n_scans)))))
}

/// Prints the warning of `ending`, if there is one, and returns the server that still serves the recording.
pub fn report_ending(ending: RecordingEnding) -> Option<Box<dyn Served>> {
    if let Some(warning) = ending.warning {
        print_diagnostic(format_args!("warning: {warning}"));
    }
    ending.served
}

/// Goes on serving the recording, which is completely written, until the user ends it.
pub fn serve_until_interrupted(served: &dyn Served, interrupted: &AtomicBool) {
    print_diagnostic(format_args!("Serving the recording until Ctrl-C: rerun {}", served.url()));
    while !interrupted.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Completes `recording`, which is written to `file`, and goes on serving it if that was asked for.
pub fn finish_and_serve(recording: Recorder, file: &Path) -> Result<(), Failure> {
    let served = report_ending(recording.finish()?);
    print_diagnostic(format_args!("Recording: {}", file.display()));
    if let Some(served) = served {
        serve_until_interrupted(&*served, interruption_flag());
    }
    Ok(())
}
