//! Logs the numbers that change from scan to scan.

use std::time::Duration;

use detector::detector::StageTime;
use evaluation::matching::outcome::{Assignment, DetectionOutcome};
use evaluation::metrics::counts::{Counts, FalseDetections};
use re_sdk_types::archetypes::{Scalars, SeriesLines, SeriesPoints};
use reports::vocabulary::task::Task;
use rerun::{EntityPath, RecordingStream};

use super::error::StreamError;
use super::palette::Rgb;
use super::{entity_paths, legend, palette, recording};

/// Names and colours of the lines of counts.
const COUNT_LINES: [(&str, Rgb); 3] =
    [("found", palette::MATCHED), ("missed", palette::MISSED), ("false", palette::FALSE)];

/// Logs name and colour of the lines of the detector at `detector_idx`, for the whole recording.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_lines(stream: &RecordingStream, detector: &str, detector_idx: usize) -> Result<(), StreamError> {
    for task in Task::ALL {
        log_line_of(stream, entity_paths::f_rate(task, detector), detector, detector_idx)?;
        for (name, color) in COUNT_LINES {
            let line = SeriesLines::new().with_names([name]).with_colors([legend::rgba(color)]);
            recording::log_static(stream, entity_paths::count(detector, task, name), &line)?;
        }
    }
    log_line_of(stream, entity_paths::latency(detector), detector, detector_idx)
}

/// A line in the colour of the detector, and a dot at each value: of a single one there is no line.
fn log_line_of(
    stream: &RecordingStream,
    path: EntityPath,
    detector: &str,
    detector_idx: usize,
) -> Result<(), StreamError> {
    let color = legend::rgba(palette::detector_color(detector_idx));
    let line = SeriesLines::new().with_names([detector]).with_colors([color]).with_widths([2.0]);
    let dots = SeriesPoints::new().with_names([detector]).with_colors([color]).with_marker_sizes([3.5]);
    recording::log_static(stream, path.clone(), &line)?;
    recording::log_static(stream, path, &dots)
}

/// Logs name and colour of the lines that the detector at `detector_idx` has where nothing is labelled.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_lines_without_labels(
    stream: &RecordingStream,
    detector: &str,
    detector_idx: usize,
) -> Result<(), StreamError> {
    Task::ALL.into_iter().try_for_each(|task| {
        log_line_of(stream, entity_paths::number_of_detections(task, detector), detector, detector_idx)
    })
}

/// Logs how many detections of `assignment` its task asks for, at the current time.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_number_of_detections(
    stream: &RecordingStream,
    detector: &str,
    assignment: &Assignment,
) -> Result<(), StreamError> {
    let n = assignment.detections.iter().filter(|it| **it != DetectionOutcome::NotAsked).count();
    let path = entity_paths::number_of_detections(assignment.task, detector);
    recording::log(stream, path, &Scalars::single(n as f64))
}

/// Logs how the lines of the series `names` are drawn, for the whole recording.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_further_lines(stream: &RecordingStream, names: &[&str]) -> Result<(), StreamError> {
    for name in names {
        let line = SeriesLines::new()
            .with_names([*name])
            .with_colors([legend::rgba(palette::YELLOW)])
            .with_widths([2.0]);
        recording::log_static(stream, entity_paths::further(name), &line)?;
    }
    Ok(())
}

/// Logs the F-rate so far at the current time; one that is undefined leaves a gap.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_f_rate(
    stream: &RecordingStream,
    detector: &str,
    task: Task,
    f_rate: Option<f64>,
) -> Result<(), StreamError> {
    let Some(f_rate) = f_rate else { return Ok(()) };
    recording::log(stream, entity_paths::f_rate(task, detector), &Scalars::single(f_rate))
}

/// Logs the numbers of found, missed and false objects of the scan at the current time; an unknown number leaves a gap.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_counts(
    stream: &RecordingStream,
    detector: &str,
    assignment: &Assignment,
    false_detections: FalseDetections,
) -> Result<(), StreamError> {
    let counts = Counts::of(assignment).scored(false_detections);
    let numbers = [Some(counts.tp()), Some(counts.mo()), counts.fo()];
    for ((name, _), number) in COUNT_LINES.into_iter().zip(numbers) {
        if let Some(number) = number {
            let path = entity_paths::count(detector, assignment.task, name);
            recording::log(stream, path, &Scalars::single(number as f64))?;
        }
    }
    Ok(())
}

/// Logs the values of further series at the current time; one that is undefined leaves a gap.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_further(
    stream: &RecordingStream,
    series: &[(&'static str, Option<f64>)],
) -> Result<(), StreamError> {
    for (name, value) in series {
        if let Some(value) = value {
            recording::log(stream, entity_paths::further(name), &Scalars::single(*value))?;
        }
    }
    Ok(())
}

/// Logs the latency of the scan at the current time.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_latency(stream: &RecordingStream, detector: &str, latency: Duration) -> Result<(), StreamError> {
    recording::log(stream, entity_paths::latency(detector), &Scalars::single(milliseconds(latency)))
}

/// Logs the stage times of the scan at the current time, and the names of the stages unless they are `known_stages`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_stage_times(
    stream: &RecordingStream,
    detector: &str,
    stage_times: &[StageTime],
    known_stages: &mut Vec<&'static str>,
) -> Result<(), StreamError> {
    let path = entity_paths::stage_times(detector);
    if !stage_times.iter().map(|it| it.stage).eq(known_stages.iter().copied()) {
        *known_stages = stage_times.iter().map(|it| it.stage).collect();
        let lines = SeriesLines::new()
            .with_names(known_stages.iter().copied())
            .with_colors(palette::CYCLE.iter().cycle().take(known_stages.len()).map(|it| legend::rgba(*it)))
            .with_widths(vec![1.5; known_stages.len()]);
        recording::log_static(stream, path.clone(), &lines)?;
    }
    let times_ms = stage_times.iter().map(|it| milliseconds(it.duration));
    recording::log(stream, path, &Scalars::new(times_ms))
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}
