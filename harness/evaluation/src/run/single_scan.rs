//! One detector on one scan.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use detector::{Detections, Detector, DetectorOutput, PointCloud};

use crate::metrics::latency::Latencies;

/// What a detector made of a scan.
#[derive(Debug, Clone)]
pub struct SingleScan {
    /// Its detections.
    pub output: DetectorOutput,
    /// Times of the whole detection.
    pub whole: Latencies,
    /// Times of each stage, in the order of the stages.
    pub stages: Vec<(&'static str, Latencies)>,
}

/// The run was ended by the user.
#[derive(Debug, thiserror::Error)]
#[error("interrupted after {n_done} of {n_repeats} detections")]
pub struct Interrupted {
    /// Detections that were done.
    pub n_done: usize,
    /// Detections that were asked for.
    pub n_repeats: usize,
}

/// Lets `detector` look at `cloud` again and again, at least once.
///
/// # Errors
///
/// [`Interrupted`] if `interrupted` is set before the last of the `n_repeats`.
pub fn detect_repeatedly(
    detector: &mut dyn Detector,
    cloud: &PointCloud,
    n_repeats: usize,
    interrupted: &AtomicBool,
) -> Result<SingleScan, Interrupted> {
    let mut output = DetectorOutput::default();
    let mut whole = Vec::new();
    let mut stages: Vec<(&'static str, Vec<Duration>)> = Vec::new();
    for n_done in 0..n_repeats.max(1) {
        if interrupted.load(Ordering::Relaxed) {
            return Err(Interrupted { n_done, n_repeats });
        }
        let started = Instant::now();
        detector.detect(cloud, &mut output);
        whole.push(started.elapsed());
        for time in &output.stage_times {
            match stages.iter_mut().find(|(stage, _)| *stage == time.stage) {
                Some((_, durations)) => durations.push(time.duration),
                None => stages.push((time.stage, vec![time.duration])),
            }
        }
    }
    let stages = stages.into_iter().map(|(stage, durations)| (stage, Latencies::new(durations)));
    Ok(SingleScan { output, whole: Latencies::new(whole), stages: stages.collect() })
}

/// For every point of a scan of `n_points` the detection it belongs to.
pub fn clusters_of_points(detections: &Detections, n_points: usize) -> Vec<Option<u32>> {
    let mut cluster_of_point = vec![None; n_points];
    for (detection, cluster) in detections.iter().zip(0..) {
        for &point_idx in detection.point_indices {
            cluster_of_point[point_idx as usize] = Some(cluster);
        }
    }
    cluster_of_point
}
