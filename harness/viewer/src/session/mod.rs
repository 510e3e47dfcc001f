//! A recording from its first scan to its last.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use re_sdk_types::archetypes::Clear;
use reports::verdicts::change::ChangeKind;
use reports::vocabulary::task::Task;
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{EntityPath, RecordingStream, RecordingStreamBuilder};
use scans::annotation::LabeledScan;

use super::blueprint::{RecordingLayout, send_blueprint};
use super::drawn_points::{DrawnPoints, PointChoice};
use super::error::StreamError;
use super::log_outcomes::{log_changes, log_mistakes, log_outcomes};
use super::log_products::log_products;
use super::log_scan::{log_pose, log_scan, log_title};
use super::log_scores::log_scores;
use super::log_series::{
    log_counts, log_f_rate, log_further, log_further_lines, log_latency, log_lines, log_stage_times,
};
use super::log_static::log_static;
use super::product_views::DetectorViews;
use super::recording;
use super::recording_axis::RecordingAxis;
use super::recording_file::RecordingFile;
use super::scan_views::{DetectorView, ScanView};
use super::stream_options::{ExistingRecording, Opening, StreamOptions};
use super::viewer::{ServedRecording, ViewerLink, ViewerState};

const APPLICATION_ID: &str = "scanbench";
/// Number of scans that are written at once if no viewer waits for them. Rerun holds the index of the file in memory until
/// its end, and it has a slot for every component in every chunk: a third of a megabyte for each time that something is
/// written.
const MAX_HELD_BACK: u32 = 8;

/// How a recording ended.
#[derive(Debug)]
pub struct StreamEnding {
    /// Size of the file.
    pub file_n_bytes: u64,
    /// Whether the viewer got everything.
    pub viewer: ViewerState,
    /// The server that still has the recording, if one was asked for.
    pub served: Option<ServedRecording>,
}

/// An open recording.
///
/// [`Self::finish`] reports whether everything was written; a stream that is only dropped may leave a file without its end.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Stream {
    recording: RecordingStream,
    file: RecordingFile,
    viewer: ViewerLink,
    path: PathBuf,
    detectors: Vec<DetectorState>,
    axis: RecordingAxis,
    opening: Opening,
    points: PointChoice,
    drawn_points: DrawnPoints,
    is_laid_out: bool,
    n_held_back: u32,
}

/// State of a detector that is kept from scan to scan.
struct DetectorState {
    name: String,
    on_screen: BTreeSet<EntityPath>,
    stages: Vec<&'static str>,
    /// Known once it has logged.
    views: Option<DetectorViews>,
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
        Self::open_along(options, detectors, RecordingAxis::scans())
    }

    /// Opens a recording over something else than scans; otherwise as [`Self::open`].
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_along(
        options: &StreamOptions,
        detectors: &[&str],
        axis: RecordingAxis,
    ) -> Result<Self, StreamError> {
        // Where the variable RERUN turns recordings off, Rerun itself would leave an empty file.
        if !rerun::decide_logging_enabled(true) {
            return Err(StreamError::SwitchedOff);
        }
        let file = match options.existing {
            ExistingRecording::Replace => RecordingFile::create(&options.file)?,
            ExistingRecording::WriteTo => RecordingFile::write_to(&options.file)?,
        };
        let viewer = ViewerLink::open(&options.viewer)?;
        let mut sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        if viewer.state() != ViewerState::None {
            sinks.push(Box::new(viewer.clone()));
        }
        let recording = RecordingStreamBuilder::new(APPLICATION_ID)
            .recording_name(&*options.name)
            .batcher_config(batching())
            .set_sinks(sinks)
            .map_err(|error| StreamError::Log {
                entity: "the recording".to_owned(),
                reason: error.to_string(),
            })?;
        recording.set_log_tick_enabled(false);
        recording.set_log_time_enabled(false);

        let names: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        log_static(&recording)?;
        for (detector_idx, name) in names.iter().enumerate() {
            log_lines(&recording, name, detector_idx)?;
        }
        log_further_lines(&recording, &axis.further_series)?;
        let detectors = names
            .into_iter()
            .map(|name| DetectorState { name, on_screen: BTreeSet::new(), stages: Vec::new(), views: None })
            .collect();
        let stream = Self {
            recording,
            file,
            viewer,
            path: options.file.clone(),
            detectors,
            axis,
            opening: options.opening,
            points: options.points,
            drawn_points: DrawnPoints::default(),
            is_laid_out: false,
            n_held_back: 0,
        };
        // A full disk shows here, and not after the first scans.
        stream.flush()?;
        Ok(stream)
    }

    /// Where viewers can connect to, if the recording is served.
    pub fn served_at(&self) -> Option<&str> {
        self.viewer.served_at()
    }

    /// State of the viewer; one that was lost is worth a warning.
    pub fn viewer_state(&self) -> ViewerState {
        self.viewer.state()
    }

    /// Logs points and annotations of a scan.
    ///
    /// Everything logged afterwards belongs to it, until the next call or [`Self::log_step`]. Call it from the thread that
    /// logs the detectors, and outside every stopwatch: earlier data are written now or in a later call, so that nothing of
    /// the recording runs beside a detector. (A viewer is sent to beside it, and shares the processor with it if it runs on
    /// the same machine.)
    ///
    /// # Errors
    ///
    /// [`StreamError`] if Rerun refuses, or if an earlier scan could not be written.
    pub fn log_scan(&mut self, view: &ScanView<'_>) -> Result<(), StreamError> {
        if self.n_held_back == MAX_HELD_BACK || self.viewer.state() == ViewerState::Connected {
            self.flush()?;
            self.n_held_back = 0;
        }
        self.n_held_back += 1;
        self.set_step(view.step)?;
        self.drawn_points = DrawnPoints::choose(&view.scan.cloud, self.points);
        log_scan(&self.recording, view, &self.drawn_points)?;
        if self.opening.has_poses {
            log_pose(&self.recording, view.world_from_sensor.as_ref(), view.drive_m)?;
        }
        Ok(())
    }

    /// Goes on to another position on the axis with the same scan, and writes `title` where the scan is named. The `further`
    /// series have these values there; one that is undefined leaves a gap.
    ///
    /// # Errors
    ///
    /// As [`Self::log_scan`].
    pub fn log_step(
        &mut self,
        step: i64,
        title: String,
        further: &[(&'static str, Option<f64>)],
    ) -> Result<(), StreamError> {
        self.flush()?;
        self.set_step(step)?;
        log_title(&self.recording, title)?;
        log_further(&self.recording, further)
    }

    /// Logs the results of a detector on `scan`, which is the one that was logged last.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the detector was not announced, if a product or an assignment is not of this scan, or if
    /// Rerun refuses.
    pub fn log_detector(&mut self, scan: &LabeledScan, view: &DetectorView<'_>) -> Result<(), StreamError> {
        let Some(detector_idx) = self.detectors.iter().position(|it| it.name == view.name) else {
            return Err(StreamError::UnknownDetector {
                detector: view.name.to_owned(),
                announced: self.detectors.iter().map(|it| it.name.clone()).collect(),
            });
        };
        let state = &mut self.detectors[detector_idx];
        let stream = &self.recording;
        let mut on_screen = log_products(stream, &self.drawn_points, view.name, view.products)?;
        on_screen.extend(log_scores(stream, view.name, &view.output.detections)?);
        for task in view.tasks {
            let assignment = task.assignment;
            on_screen.extend(log_outcomes(stream, scan, view.name, &view.output.detections, assignment)?);
            log_mistakes(stream, view.name, assignment.task, &task.mistakes)?;
            log_counts(stream, view.name, assignment, task.false_detections)?;
            log_f_rate(stream, view.name, assignment.task, task.f_rate_so_far)?;
        }
        // Entities that only the previous scan had would stay otherwise.
        for path in state.on_screen.difference(&on_screen) {
            recording::log(stream, path.clone(), &Clear::flat())?;
        }
        state.on_screen = on_screen;
        if let Some(latency) = view.latency {
            log_latency(stream, view.name, latency)?;
        }
        log_stage_times(stream, view.name, &view.output.stage_times, &mut state.stages)?;
        state.views.get_or_insert_with(|| DetectorViews::of(view.name, view.products));
        if !self.is_laid_out && self.detectors.iter().all(|it| it.views.is_some()) {
            self.lay_out()?;
        }
        Ok(())
    }

    /// Logs the changes that the side `name` of the last scan shows, in words.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if Rerun refuses.
    pub fn log_changes(
        &self,
        name: &str,
        task: Task,
        lines: &[(Option<ChangeKind>, String)],
    ) -> Result<(), StreamError> {
        log_changes(&self.recording, name, task, lines)
    }

    /// Writes the end of the file and waits, within limits, until the viewer has everything.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if the file is not complete.
    pub fn finish(mut self) -> Result<StreamEnding, StreamError> {
        if !self.is_laid_out {
            self.lay_out()?;
        }
        self.flush()?;
        self.file.finish()?;
        let (viewer, served) = self.viewer.finish();
        let file_n_bytes = file_size(&self.path)?;
        Ok(StreamEnding { file_n_bytes, viewer, served })
    }

    /// Sends the blueprint, which depends on the stage products of the detectors.
    fn lay_out(&mut self) -> Result<(), StreamError> {
        let views = |it: &DetectorState| it.views.clone().unwrap_or_else(|| DetectorViews::of(&it.name, &[]));
        let detectors: Vec<DetectorViews> = self.detectors.iter().map(views).collect();
        let opening = self.opening;
        let layout = RecordingLayout { detectors: &detectors, axis: &self.axis, opening };
        send_blueprint(&self.recording, APPLICATION_ID, &layout)?;
        self.is_laid_out = true;
        Ok(())
    }

    fn set_step(&self, step: i64) -> Result<(), StreamError> {
        let timeline = rerun::TimelineName::try_new(&*self.axis.timeline).map_err(|error| {
            StreamError::Log { entity: self.axis.timeline.clone(), reason: error.to_string() }
        })?;
        self.recording.set_time_sequence(timeline, step);
        Ok(())
    }

    /// Lets Rerun write what it holds back, so that memory stays flat and a full disk is noticed.
    fn flush(&self) -> Result<(), StreamError> {
        // The file knows better than the flush why it failed.
        let flushed = self.recording.flush_blocking();
        self.file.check()?;
        flushed.map_err(|error| StreamError::Write { path: self.path.clone(), reason: error.to_string() })
    }
}

/// Only our own flush, between scans, cuts chunks and sends them: a timer would do so while a detector is timed.
fn batching() -> ChunkBatcherConfig {
    ChunkBatcherConfig::NEVER
}

fn file_size(path: &Path) -> Result<u64, StreamError> {
    let metadata = std::fs::metadata(path)
        .map_err(|error| StreamError::Write { path: path.to_owned(), reason: error.to_string() })?;
    Ok(metadata.len())
}

#[cfg(test)]
mod tests;
