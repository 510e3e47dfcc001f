//! One detector on one scan.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use detector::{Detections, Detector, DetectorOutput, PointCloud};
use reports::numbers::latencies::Latencies;

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
    let mut stages: Vec<(&'static str, Vec<f64>)> = Vec::new();
    for n_done in 0..n_repeats.max(1) {
        if interrupted.load(Ordering::Relaxed) {
            return Err(Interrupted { n_done, n_repeats });
        }
        let started = Instant::now();
        detector.detect(cloud, &mut output);
        whole.push(1e3 * started.elapsed().as_secs_f64());
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
