//! A recording from its first scan to its last.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use detector::{DetectorOutput, StageProduct};
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{Clear, EntityPath, RecordingStream, RecordingStreamBuilder};

use super::blueprint::send_blueprint;
use super::error::StreamError;
use super::log_outcomes::log_outcomes;
use super::log_products::log_products;
use super::log_scan::log_scan;
use super::log_series::{RunningFRate, log_f_rates, log_latency, log_lines, log_stage_times};
use super::log_static::log_static;
use super::recording_file::RecordingFile;
use super::viewer::{ViewerChoice, ViewerLink, ViewerState};
use super::{entity_paths, recording};
use crate::annotation::LabeledScan;
use crate::matching::outcome::Assignment;
use crate::task::Task;

const APPLICATION_ID: &str = "scanbench";

/// Where a recording goes and how it opens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamOptions {
    /// The name of the recording in the viewer.
    pub name: String,
    /// The file, always written; one that exists is overwritten.
    pub file: PathBuf,
    /// A viewer that gets the same at the same time.
    pub viewer: ViewerChoice,
    /// The task whose outcomes are visible at first.
    pub shown_task: Task,
}

/// What one detector made of one scan.
#[derive(Debug, Clone, Copy)]
pub struct DetectorView<'a> {
    /// Its name, as announced to [`Stream::open`].
    pub name: &'a str,
    /// What it reports.
    pub output: &'a DetectorOutput,
    /// What its stages left behind.
    pub products: &'a [StageProduct],
    /// What became of every annotation and detection, for each task.
    pub assignments: &'a [Assignment],
    /// F-rates over the scans so far, for each task.
    pub f_rates_so_far: &'a [RunningFRate],
    /// Time of the whole detection.
    pub latency: Duration,
}

/// How a recording ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamEnding {
    /// Size of the file.
    pub file_n_bytes: u64,
    /// Whether the viewer got everything.
    pub viewer: ViewerState,
}

/// An open recording.
///
/// [`Self::finish`] tells whether everything was written; a stream that is only dropped may leave a file without its end.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Stream {
    recording: RecordingStream,
    file: RecordingFile,
    viewer: ViewerLink,
    path: PathBuf,
    detectors: Vec<DetectorState>,
}

/// What has to be remembered of a detector from scan to scan.
struct DetectorState {
    name: String,
    on_screen: BTreeSet<EntityPath>,
    stages: Vec<&'static str>,
}

impl Stream {
    /// Creates the file, connects to the viewer if there is to be one, and sends what holds for the whole recording.
    ///
    /// `detectors` are the names of all that will log, in the order in which they are shown. A viewer that does not
    /// answer is no error: see [`Self::viewer_state`].
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the file cannot be written or a viewer has to be started and cannot be.
    pub fn open(options: &StreamOptions, detectors: &[&str]) -> Result<Self, StreamError> {
        let file = RecordingFile::create(&options.file)?;
        let viewer = ViewerLink::open(&options.viewer)?;
        let mut sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        if viewer.state() != ViewerState::None {
            sinks.push(Box::new(viewer.clone()));
        }
        let recording = RecordingStreamBuilder::new(APPLICATION_ID)
            .recording_name(&*options.name)
            // Otherwise the environment variable RERUN=off would leave an empty file.
            .enabled(true)
            .batcher_config(batching())
            .set_sinks(sinks)
            .map_err(|error| StreamError::Log {
                entity: "the recording".to_owned(),
                reason: error.to_string(),
            })?;
        recording.set_log_tick_enabled(false);
        recording.set_log_time_enabled(false);

        let names: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        send_blueprint(&recording, APPLICATION_ID, &names, options.shown_task)?;
        log_static(&recording)?;
        for (detector_idx, name) in names.iter().enumerate() {
            log_lines(&recording, name, detector_idx)?;
        }
        let detectors = names
            .into_iter()
            .map(|name| DetectorState { name, on_screen: BTreeSet::new(), stages: Vec::new() })
            .collect();
        Ok(Self { recording, file, viewer, path: options.file.clone(), detectors })
    }

    /// How the viewer does; one that was lost is worth a warning.
    pub fn viewer_state(&self) -> ViewerState {
        self.viewer.state()
    }

    /// Logs points and annotations of `scan`, the one with this number within the run.
    ///
    /// Whatever is logged afterwards belongs to it, until the next call. Call it from the thread that logs the detectors.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if Rerun refuses, or if an earlier scan could not be written.
    pub fn log_scan(&mut self, scan_number: u32, scan: &LabeledScan) -> Result<(), StreamError> {
        self.flush()?;
        self.recording.set_time_sequence(entity_paths::SCAN_TIMELINE, scan_number);
        log_scan(&self.recording, scan)
    }

    /// Logs what a detector made of `scan`, which is the one that was logged last.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the detector was not announced, if a product or an assignment is not of this scan, or if
    /// Rerun refuses.
    pub fn log_detector(&mut self, scan: &LabeledScan, view: &DetectorView<'_>) -> Result<(), StreamError> {
        let announced = || self.detectors.iter().map(|it| it.name.clone()).collect();
        let Some(detector_idx) = self.detectors.iter().position(|it| it.name == view.name) else {
            return Err(StreamError::UnknownDetector {
                detector: view.name.to_owned(),
                announced: announced(),
            });
        };
        let state = &mut self.detectors[detector_idx];
        let stream = &self.recording;
        let mut on_screen = log_products(stream, &scan.cloud, view.name, view.products)?;
        for assignment in view.assignments {
            on_screen.extend(log_outcomes(stream, scan, view.name, &view.output.detections, assignment)?);
        }
        // What the previous scan had and this one has not would stay otherwise.
        for path in state.on_screen.difference(&on_screen) {
            recording::log(stream, path.clone(), &Clear::flat())?;
        }
        state.on_screen = on_screen;
        log_f_rates(stream, view.name, view.f_rates_so_far)?;
        log_latency(stream, view.name, view.latency)?;
        log_stage_times(stream, view.name, &view.output.stage_times, &mut state.stages)
    }

    /// Writes the end of the file and waits, within limits, until the viewer has everything.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if the file is not complete.
    pub fn finish(self) -> Result<StreamEnding, StreamError> {
        self.flush()?;
        self.file.finish()?;
        let viewer = self.viewer.finish();
        let file_n_bytes = file_size(&self.path)?;
        Ok(StreamEnding { file_n_bytes, viewer })
    }

    /// Lets Rerun write what it holds back, so that memory stays flat and a full disk is noticed.
    fn flush(&self) -> Result<(), StreamError> {
        // Whatever the flush says is known better to the file.
        let flushed = self.recording.flush_blocking();
        self.file.check()?;
        flushed.map_err(|error| StreamError::Write { path: self.path.clone(), reason: error.to_string() })
    }
}

/// Only our own flush, once a scan, cuts chunks and sends them: a timer would do so while a detector is timed.
fn batching() -> ChunkBatcherConfig {
    ChunkBatcherConfig::NEVER
}

fn file_size(path: &Path) -> Result<u64, StreamError> {
    let metadata = std::fs::metadata(path)
        .map_err(|error| StreamError::Write { path: path.to_owned(), reason: error.to_string() })?;
    Ok(metadata.len())
}
