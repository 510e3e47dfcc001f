//! One detector on one scan.

use std::sync::atomic::{AtomicBool, Ordering};

use detector::DetectorOutput;
use reports::numbers::latencies::Latencies;
use scans::annotation::LabeledScan;

use super::running_detector::RunningDetector;
use super::scan_in_drive::ScanInDrive;
use crate::process::problem::DetectorFailure;

/// Results of a detector on a scan.
#[derive(Debug, Clone)]
pub struct SingleScan {
    /// Its detections.
    pub output: DetectorOutput,
    /// Times of the whole detection.
    pub whole: Latencies,
    /// Times of each stage, in the order of the stages.
    pub stages: Vec<(&'static str, Latencies)>,
}

/// Why the repetitions ended early.
#[derive(Debug, thiserror::Error)]
pub enum SingleScanError {
    /// The user interrupted them.
    #[error("interrupted after {n_done} of {n_repeats} detections")]
    Interrupted {
        /// Number of detections that were done.
        n_done: usize,
        /// Number of detections that were to be done.
        n_repeats: usize,
    },
    /// The detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
}

/// Repeats the detection in `scan` `n_repeats` times, at least once.
///
/// # Errors
///
/// [`SingleScanError`] if the detector fails, or `interrupted` is set before the last of the `n_repeats`.
pub fn detect_repeatedly(
    detector: &mut dyn RunningDetector,
    scan: &LabeledScan,
    n_repeats: usize,
    interrupted: &AtomicBool,
) -> Result<SingleScan, SingleScanError> {
    let mut output = DetectorOutput::default();
    let mut whole = Vec::new();
    let mut stages: Vec<(&'static str, Vec<f64>)> = Vec::new();
    for n_done in 0..n_repeats.max(1) {
        if interrupted.load(Ordering::Relaxed) {
            return Err(SingleScanError::Interrupted { n_done, n_repeats });
        }
        let taken = detector.detect(&ScanInDrive::alone(scan), &mut output)?;
        whole.extend(taken.wall.map(|it| 1e3 * it.as_secs_f64()));
        for time in &output.stage_times {
            let time_ms = 1e3 * time.duration.as_secs_f64();
            match stages.iter_mut().find(|(stage, _)| *stage == time.stage) {
                Some((_, times_ms)) => times_ms.push(time_ms),
                None => stages.push((time.stage, vec![time_ms])),
            }
        }
    }
    let stages = stages.into_iter().map(|(stage, times_ms)| (stage, Latencies::new(times_ms)));
    Ok(SingleScan { output, whole: Latencies::new(whole), stages: stages.collect() })
}
