//! What every detector can do.

use std::time::{Duration, Instant};

use crate::detection::Detections;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::stage_product::StageProduct;

/// Finds objects in single scans.
///
/// A detector owns the buffers it needs and uses them again for the next scan, so that nothing is allocated per
/// point once the first scans have sized them.
pub trait Detector: Send {
    /// The name used on the command line and in files, such as `kd-tree`.
    fn name(&self) -> &'static str;

    /// Finds the objects of `cloud` and writes them to `output`, whose previous content is overwritten.
    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput);

    /// What the stages of the latest [`Self::detect`] left behind, in the order of the stages.
    ///
    /// Meant for drawing: allocates, and is never called inside a stopwatch. `cloud` is the scan that was given to
    /// that call.
    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct>;

    /// What it does beside finding clusters, in the order of the stages.
    fn rules(&self) -> Vec<Rule> {
        Vec::new()
    }
}

/// Everything a detector says about one scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DetectorOutput {
    /// The objects.
    pub detections: Detections,
    /// How long each stage took, in the order of the stages.
    pub stage_times: Vec<StageTime>,
    /// Clusters that did not become detections because of their size.
    pub dropped_clusters: Vec<DroppedCluster>,
}

impl DetectorOutput {
    /// Forgets the content and keeps the memory.
    pub fn clear(&mut self) {
        self.detections.clear();
        self.stage_times.clear();
        self.dropped_clusters.clear();
    }
}

/// The duration of one stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StageTime {
    /// Name of the stage: lower case, words joined by `_`.
    pub stage: &'static str,
    /// Time spent in it.
    pub duration: Duration,
}

/// A cluster whose size rules it out as an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DroppedCluster {
    /// Number of points.
    pub n_points: usize,
    /// Why it was dropped.
    pub reason: DropReason,
}

/// Why a cluster is no detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DropReason {
    /// Fewer points than the detector's minimum.
    TooFewPoints,
    /// More points than the detector's maximum.
    TooManyPoints,
    /// Longer or wider than the detector's maximum.
    TooLarge,
}

/// Splits the time of a scan into consecutive stages.
#[derive(Debug)]
pub struct StageClock {
    stage_started: Instant,
}

impl StageClock {
    /// Starts the first stage.
    pub fn start() -> Self {
        Self { stage_started: Instant::now() }
    }

    /// Ends the current stage, adds its time to `stage_times` under the name `stage`, and starts the next one.
    pub fn lap(&mut self, stage: &'static str, stage_times: &mut Vec<StageTime>) {
        let now = Instant::now();
        stage_times.push(StageTime { stage, duration: now - self.stage_started });
        self.stage_started = now;
    }
}
