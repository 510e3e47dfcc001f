//! The trait of all detectors, and their output.

use std::time::{Duration, Instant};

use crate::detection::{Detection, Detections, GivenClass};
use crate::point_cloud::PointCloud;
use crate::road_user::{RoadUser, RoadUserOdds};
use crate::rule::Rule;
use crate::stage_product::StageProduct;

/// Finds objects in single scans.
///
/// A detector owns the buffers it needs and uses them again for the next scan, so that nothing is allocated per
/// point once the first scans have sized them.
///
/// ```
/// use detector::detector::StageClock;
/// use detector::stage_product::Shape;
/// use detector::{DetectedClass, Detection, Detector, DetectorOutput, OrientedBox, PointCloud, StageProduct};
///
/// /// Takes all points within `reach_m` ahead of the sensor for one object.
/// struct Bumper {
///     reach_m: f32,
///     near: Vec<u32>,
/// }
///
/// impl Detector for Bumper {
///     fn name(&self) -> &'static str {
///         "bumper"
///     }
///
///     fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
///         output.clear();
///         let mut clock = StageClock::start();
///         self.near.clear();
///         let is_near = |x_m: f32| (0.0..self.reach_m).contains(&x_m);
///         self.near.extend((0..).zip(cloud.x_m()).filter(|(_, x_m)| is_near(**x_m)).map(|(idx, _)| idx));
///         if !self.near.is_empty() {
///             let bounding_box = OrientedBox {
///                 center_m: [0.5 * self.reach_m, 0.0, 0.0],
///                 length_width_height_m: [self.reach_m, 2.0, 2.0],
///                 yaw_rad: 0.0,
///             };
///             output.detections.push(Detection::new(&self.near, bounding_box, DetectedClass::Object, None));
///         }
///         clock.lap("reach", &mut output.stage_times);
///     }
///
///     fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
///         let cluster_of = |idx| self.near.binary_search(&idx).is_ok().then_some(0);
///         let clusters = (0..cloud.len() as u32).map(cluster_of).collect();
///         vec![StageProduct { stage: "reach", name: "clusters", shape: Shape::Clusters(clusters) }]
///     }
/// }
///
/// let cloud: PointCloud = [[1.5, 0.2, 0.0], [9.0, 0.0, 0.0]].into_iter().collect();
/// let mut bumper = Bumper { reach_m: 2.0, near: Vec::new() };
/// let mut output = DetectorOutput::default();
/// bumper.detect(&cloud, &mut output);
/// assert_eq!(output.detections.get(0).point_indices, [0]);
/// assert_eq!(bumper.stage_products(&cloud)[0].shape, Shape::Clusters(vec![Some(0), None]));
/// ```
pub trait Detector: Send {
    /// The name used on the command line and in files, such as `kd-tree`.
    fn name(&self) -> &'static str;

    /// Finds the objects of `cloud` and writes them to `output`, whose previous content is overwritten.
    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput);

    /// The products of the stages of the latest [`Self::detect`], in the order of the stages.
    ///
    /// Meant for drawing: allocates, and is never called inside a stopwatch. `cloud` is the scan that was given to
    /// that call.
    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct>;

    /// Whether each point of the latest scan is ground, in the order of the scan; `None` if the detector reports no ground.
    ///
    /// As [`Self::stage_products`] never called inside a stopwatch, and given the same scan.
    fn ground_points(&self, _cloud: &PointCloud) -> Option<Vec<bool>> {
        None
    }

    /// The classes that it may give its detections; none if it gives none.
    fn given_classes(&self) -> Vec<GivenClass> {
        Vec::new()
    }

    /// The rules of the detector beside finding clusters, in the order of the stages.
    fn rules(&self) -> Vec<Rule> {
        Vec::new()
    }
}

/// Everything a detector says about one scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DetectorOutput {
    /// The objects.
    pub detections: Detections,
    /// Possible road users that were not classified as such. Each has a score below all detections of its class; the score
    /// of its box may be higher. Only protocols that rank detections use these. Some are among `detections` as objects or as
    /// road users of another class, others have too few points for that.
    pub unlikely: Detections,
    /// How long each stage took, in the order of the stages.
    pub stage_times: Vec<StageTime>,
    /// Clusters that did not become detections because of their size.
    pub dropped_clusters: Vec<DroppedCluster>,
    /// Groups that were not cut since the scan had too many: the objects in them may be found as one.
    pub n_left_uncut: usize,
}

/// The log odds of unlikely road users.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnlikelyOdds {
    /// All are greater than this.
    pub above: f32,
    /// All are no greater than that of their class; those of detections of the class are greater.
    pub up_to: RoadUserOdds,
}

impl DetectorOutput {
    /// Drops a cluster of too few points, of these `odds`. It becomes an unlikely road user if they are those of one.
    pub fn drop_small(&mut self, cluster: Detection<'_>, odds: RoadUserOdds, unlikely: UnlikelyOdds) {
        let n_points = cluster.point_indices.len();
        self.dropped_clusters.push(DroppedCluster { n_points, reason: DropReason::TooFewPoints });
        self.rank(cluster, odds, unlikely);
    }

    /// Adds `detection`, of these `odds`, to the unlikely road users, once for each class of which its odds are unlikely.
    pub fn rank(&mut self, detection: Detection<'_>, odds: RoadUserOdds, unlikely: UnlikelyOdds) {
        for road_user in RoadUser::ALL {
            let score = odds.of(road_user);
            if score > unlikely.above && score <= unlikely.up_to.of(road_user) {
                let (class, given) = (road_user.class(), road_user.given());
                self.unlikely.push(Detection { class, given, score: Some(score), ..detection });
            }
        }
    }

    /// Forgets the content and keeps the memory.
    pub fn clear(&mut self) {
        self.detections.clear();
        self.unlikely.clear();
        self.stage_times.clear();
        self.dropped_clusters.clear();
        self.n_left_uncut = 0;
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
