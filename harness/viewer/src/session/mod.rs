//! A recording from its first scan to its last.

use std::collections::BTreeSet;

use re_sdk_types::archetypes::Clear;
use reports::verdicts::change::ChangeKind;
use reports::vocabulary::task::Task;
use rerun::EntityPath;
use scans::annotation::LabeledScan;

use super::blueprint::{RecordingLayout, send_blueprint, send_time};
use super::drawn_points::{DrawnPoints, PointChoice};
use super::error::StreamError;
use super::layers::{APPLICATION_ID, Layers};
use super::log_outcomes::{log_changes, log_mistakes, log_mistakes_of_scan, log_outcomes};
use super::log_products::log_products;
use super::log_scan::{log_pose, log_scan, log_title};
use super::log_scores::log_scores;
use super::log_series::{
    log_counts, log_f_rate, log_further, log_further_lines, log_latency, log_lines, log_lines_without_labels,
    log_number_of_detections, log_stage_times,
};
use super::log_static::{log_detector_legend, log_legend, log_static};
use super::product_views::{DetectorOutline, DetectorViews};
use super::recording;
use super::recording_axis::RecordingAxis;
use super::scan_views::{DetectorView, ScanView};
use super::stream_options::{Opening, RecordingTarget, StreamOptions};
use super::viewer::{ServedRecording, ViewerLink, ViewerState};

/// Number of scans that are written at once if no viewer waits for them. Rerun holds the index of the file in memory until
/// its end, and it has a slot for every component in every chunk: a third of a megabyte for each time that something is
/// written.
const MAX_HELD_BACK: u32 = 8;

/// How a recording ended.
#[derive(Debug)]
pub struct StreamEnding {
    /// Size of its files.
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
    layers: Layers,
    viewer: ViewerLink,
    detectors: Vec<DetectorState>,
    axis: RecordingAxis,
    opening: Opening,
    points: PointChoice,
    drawn_points: DrawnPoints,
    is_laid_out: bool,
    /// Whether the scans have labels: as the first one.
    is_labelled: Option<bool>,
    n_held_back: u32,
}

/// State of a detector that is kept from scan to scan.
struct DetectorState {
    name: String,
    on_screen: BTreeSet<EntityPath>,
    stages: Vec<&'static str>,
    /// Known once it has logged.
    outline: Option<DetectorOutline>,
}

impl Stream {
    /// Creates the files of `target`, connects to the viewer if there is to be one, and sends what holds for the whole recording.
    ///
    /// `detectors` are the names of all that will log, in the order in which they are shown. A viewer that does not
    /// answer is no error: see [`Self::viewer_state`].
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the file cannot be written or a viewer has to be started and cannot be.
    pub fn open(
        target: &RecordingTarget,
        options: &StreamOptions,
        detectors: &[&str],
    ) -> Result<Self, StreamError> {
        Self::open_along(target, options, detectors, RecordingAxis::scans())
    }

    /// Opens a recording over something else than scans; otherwise as [`Self::open`].
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_along(
        target: &RecordingTarget,
        options: &StreamOptions,
        detectors: &[&str],
        axis: RecordingAxis,
    ) -> Result<Self, StreamError> {
        // Where the variable RERUN turns recordings off, Rerun itself would leave an empty file.
        if !rerun::decide_logging_enabled(true) {
            return Err(StreamError::SwitchedOff);
        }
        let viewer = ViewerLink::open(&options.viewer)?;
        let layers = Layers::begin(target, &options.name, &viewer, detectors)?;
        log_static(layers.scans())?;
        for (index, name) in detectors.iter().enumerate() {
            let detector_idx = layers.joined.len() + index;
            log_lines(layers.of_detector(index), name, detector_idx)?;
            log_detector_legend(layers.of_detector(index), name, detector_idx)?;
        }
        log_further_lines(layers.scans(), &axis.further_series)?;
        let detectors = detectors
            .iter()
            .map(|&name| DetectorState {
                name: name.to_owned(),
                on_screen: BTreeSet::new(),
                stages: Vec::new(),
                outline: None,
            })
            .collect();
        let stream = Self {
            layers,
            viewer,
            detectors,
            axis,
            opening: options.opening,
            points: options.points,
            drawn_points: DrawnPoints::default(),
            is_laid_out: false,
            is_labelled: None,
            n_held_back: 0,
        };
        for layer in stream.layers.without_layout() {
            send_time(layer, APPLICATION_ID, &stream.axis, stream.is_live())?;
        }
        // A full disk shows here, and not after the first scans.
        stream.layers.flush()?;
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
            self.layers.flush()?;
            self.n_held_back = 0;
        }
        self.n_held_back += 1;
        self.set_step(view.step)?;
        if self.is_labelled.is_none() {
            self.is_labelled = Some(view.scan.is_labeled());
            self.log_lack_of_labels()?;
        }
        self.drawn_points = DrawnPoints::choose(&view.scan.cloud, self.points);
        log_scan(self.layers.scans(), view, &self.drawn_points)?;
        if self.opening.has_poses {
            log_pose(self.layers.scans(), view.world_from_sensor.as_ref(), view.drive_m)?;
        }
        Ok(())
    }

    /// Logs how agreement is drawn, if the scans have no labels.
    fn log_lack_of_labels(&self) -> Result<(), StreamError> {
        if self.is_labelled() {
            return Ok(());
        }
        log_legend(self.layers.scans(), false)?;
        for (index, it) in self.detectors.iter().enumerate() {
            let detector_idx = self.layers.joined.len() + index;
            log_lines_without_labels(self.layers.of_detector(index), &it.name, detector_idx)?;
        }
        Ok(())
    }

    fn is_labelled(&self) -> bool {
        self.is_labelled.unwrap_or(true)
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
        self.layers.flush()?;
        self.set_step(step)?;
        log_title(self.layers.scans(), title)?;
        log_further(self.layers.scans(), further)
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
        let is_labelled = self.is_labelled();
        let state = &mut self.detectors[detector_idx];
        let stream = self.layers.of_detector(detector_idx);
        let mut on_screen = log_products(stream, &self.drawn_points, view.name, view.products)?;
        on_screen.extend(log_scores(stream, view.name, &view.output.detections)?);
        for task in view.tasks {
            let assignment = task.assignment;
            let drawn = log_outcomes(stream, scan, view.name, &view.output.detections, assignment)?;
            on_screen.extend(drawn.entities);
            log_mistakes(stream, view.name, assignment.task, &task.mistakes)?;
            if assignment.task == self.opening.shown_task {
                log_mistakes_of_scan(stream, view.name, assignment.task, &task.mistakes, &drawn.places)?;
            }
            if is_labelled {
                log_counts(stream, view.name, assignment, task.false_detections)?;
                log_f_rate(stream, view.name, assignment.task, task.f_rate_so_far)?;
            } else {
                log_number_of_detections(stream, view.name, assignment)?;
            }
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
        state.outline.get_or_insert_with(|| DetectorOutline::of(view.name, view.products));
        if !self.is_laid_out && self.detectors.iter().all(|it| it.outline.is_some()) {
            self.lay_out(self.is_live())?;
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
        let of_side =
            self.detectors.iter().position(|it| it.name == name).map(|it| self.layers.of_detector(it));
        log_changes(of_side.unwrap_or(self.layers.scans()), name, task, lines)
    }

    /// Writes the ends of its files and waits, within limits, until the viewer has everything.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if the file is not complete.
    pub fn finish(mut self) -> Result<StreamEnding, StreamError> {
        let is_live = self.is_live();
        if !self.is_laid_out {
            self.lay_out(is_live)?;
        }
        self.layers.flush()?;
        let (viewer, served) = self.viewer.finish();
        if is_live {
            // The viewer is done, so only the file gets this.
            self.lay_out(false)?;
            self.layers.flush()?;
        }
        let file_n_bytes = self.layers.finish()?;
        Ok(StreamEnding { file_n_bytes, viewer, served })
    }

    /// Whether a viewer follows the recording now.
    fn is_live(&self) -> bool {
        self.opening.follows && self.viewer.state() == ViewerState::Connected
    }

    /// Sends the blueprint, which depends on the stage products of the detectors.
    fn lay_out(&mut self, is_live: bool) -> Result<(), StreamError> {
        let outline =
            |it: &DetectorState| it.outline.clone().unwrap_or_else(|| DetectorOutline::of(&it.name, &[]));
        let mut outlines = self.layers.joined.clone();
        outlines.extend(self.detectors.iter().map(outline));
        let detectors: Vec<DetectorViews> = outlines.iter().map(DetectorViews::of).collect();
        let (axis, opening) = (&self.axis, self.opening);
        let is_labelled = self.is_labelled();
        let layout = RecordingLayout { detectors: &detectors, axis, opening, is_live, is_labelled };
        send_blueprint(self.layers.layout(&outlines)?, APPLICATION_ID, &layout)?;
        self.is_laid_out = true;
        Ok(())
    }

    fn set_step(&self, step: i64) -> Result<(), StreamError> {
        let timeline = rerun::TimelineName::try_new(&*self.axis.timeline).map_err(|error| {
            StreamError::Log { entity: self.axis.timeline.clone(), reason: error.to_string() }
        })?;
        self.layers.set_step(timeline, step);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
