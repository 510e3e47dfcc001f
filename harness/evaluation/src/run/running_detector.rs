//! A detector that runs on the scans of a data set: built in, another program, or results.

use std::time::{Duration, Instant};

use detector::stage_product::StageProduct;
use detector::{Detector, DetectorOutput, PointCloud, Rule};
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::kitti::label::KittiObject;
use scans::dataset::official::OfficialObject;

use crate::process::problem::DetectorFailure;
use crate::run::counter::{Count, Counter, OwnMeter};
use crate::run::scan_in_drive::ScanInDrive;

/// The times of a detection, and what was counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DetectionTime {
    /// Wall-clock time; `None` if the detections were read instead of made, or slowed down to be counted.
    pub wall: Option<Duration>,
    /// Time on processors, on all threads and in all processes of the detector; `None` if the system does not report it.
    pub cpu: Option<Duration>,
    /// Time of the way to the detector and back, measured separately; `None` if there is no such way or it was not measured.
    pub overhead: Option<Duration>,
    /// Instructions and memory; `None` unless they were to be [counted](RunningDetector::count_by).
    pub count: Option<Count>,
}

/// A program that has been started.
#[cfg(target_os = "linux")]
pub type BegunConversation = crate::process::conversation::Conversation;
/// There are no programs on this system.
#[cfg(not(target_os = "linux"))]
#[derive(Debug)]
pub enum BegunConversation {}

/// Finds objects in the scans of one data set, and may fail.
pub trait RunningDetector: Send {
    /// The name in tables and files.
    fn name(&self) -> &'static str;

    /// Finds the objects of the scan in `asked`, and writes them to `output`, whose previous content is overwritten. It must
    /// not look at the annotations.
    ///
    /// # Errors
    ///
    /// [`DetectorFailure`] if it does not give an answer; `output` is empty then.
    fn detect(
        &mut self,
        asked: &ScanInDrive<'_>,
        output: &mut DetectorOutput,
    ) -> Result<DetectionTime, DetectorFailure>;

    /// Whether it has to be asked for the scans of a drive one after the other, each once: it remembers them. Known after
    /// the first scan.
    fn is_in_order(&self) -> bool {
        false
    }

    /// Counts what its detections take from now on. Detectors whose results are read take nothing.
    fn count_by(&mut self, _counter: &Counter) {}

    /// Products of the stages of the latest detection, as [`Detector::stage_products`].
    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct>;

    /// Objects of the latest scan, `id`, as the file has them from which they were read; empty if there is no such file.
    fn official_objects(&self, _id: &ScanId) -> &[OfficialObject] {
        &[]
    }

    /// Objects of the latest scan, `id`, as KITTI's file has them; `None` if they were read from no such file.
    fn kitti_objects(&self, _id: &ScanId) -> Option<&[KittiObject]> {
        None
    }

    /// Whether each point of the latest scan is ground, as [`Detector::ground_points`].
    fn ground_points(&self, _cloud: &PointCloud) -> Option<Vec<bool>> {
        None
    }

    /// Label of every point of the latest scan, `scan`: class and instance; `None` unless it predicts labels in
    /// SemanticKITTI's format. In a scan in which it found nothing, all points are unlabelled.
    fn point_labels(&self, _scan: &LabeledScan) -> Option<Vec<u32>> {
        None
    }

    /// Whether it may give the classes of its detections: of the latest scan, or of any before the first.
    fn may_give_classes(&self) -> bool {
        false
    }

    /// The classes that it may give, where they are known before its first scan; `None` if its detections show them.
    fn known_classes(&self) -> Option<Vec<AnnotationClass>> {
        None
    }

    /// Rules that it applies besides finding clusters.
    fn rules(&self) -> Vec<Rule> {
        Vec::new()
    }

    /// Its program, to be reused with other parameters; `None` if it is no program.
    fn into_conversation(self: Box<Self>) -> Option<BegunConversation> {
        None
    }

    /// Ends it. Returns warnings for the user.
    fn finish(self: Box<Self>) -> Vec<String> {
        Vec::new()
    }
}

/// A built-in detector under a name.
pub struct BuiltIn {
    name: &'static str,
    detector: Box<dyn Detector>,
    meter: Option<OwnMeter>,
    // Number of detections, and of those that left groups uncut.
    n_detections: usize,
    n_with_groups_uncut: usize,
}

impl BuiltIn {
    /// `detector` under `name`.
    pub fn new(name: &'static str, detector: Box<dyn Detector>) -> Self {
        Self { name, detector, meter: None, n_detections: 0, n_with_groups_uncut: 0 }
    }
}

impl RunningDetector for BuiltIn {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(
        &mut self,
        asked: &ScanInDrive<'_>,
        output: &mut DetectorOutput,
    ) -> Result<DetectionTime, DetectorFailure> {
        let cpu_before = own_cpu_time();
        let started = Instant::now();
        let mut detect = || self.detector.detect(&asked.scan.cloud, output);
        let count = if let Some(meter) = &mut self.meter {
            Some(meter.measure(&mut detect))
        } else {
            detect();
            None
        };
        let wall = started.elapsed();
        self.n_detections += 1;
        self.n_with_groups_uncut += usize::from(output.n_left_uncut > 0);
        let cpu = own_cpu_time().zip(cpu_before).map(|(after, before)| after.saturating_sub(before));
        let is_timed = self.meter.as_ref().is_none_or(|it| !it.is_slow());
        let [wall, cpu] = [Some(wall), cpu].map(|it| it.filter(|_| is_timed));
        Ok(DetectionTime { wall, cpu, overhead: None, count })
    }

    fn count_by(&mut self, counter: &Counter) {
        self.meter = Some(OwnMeter::new(counter.clone()));
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        self.detector.stage_products(cloud)
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        self.detector.ground_points(cloud)
    }

    fn known_classes(&self) -> Option<Vec<AnnotationClass>> {
        let given = self.detector.given_classes();
        Some(given.iter().filter_map(|it| AnnotationClass::met(it.name())).collect())
    }

    fn rules(&self) -> Vec<Rule> {
        self.detector.rules()
    }

    fn finish(self: Box<Self>) -> Vec<String> {
        let Self { name, n_detections, n_with_groups_uncut, .. } = *self;
        let warning = || {
            format!(
                "{name} had more groups to cut than its budget, grouping.cuts.max_groups, in {n_with_groups_uncut} of \
                 {n_detections} detections: objects that touch may have been found as one"
            )
        };
        (n_with_groups_uncut > 0).then(warning).into_iter().collect()
    }
}

/// A detector that cannot run on this system.
#[cfg(not(target_os = "linux"))]
pub(super) struct NotHere(pub(super) &'static str);

#[cfg(not(target_os = "linux"))]
impl RunningDetector for NotHere {
    fn name(&self) -> &'static str {
        self.0
    }

    fn detect(
        &mut self,
        _: &ScanInDrive<'_>,
        output: &mut DetectorOutput,
    ) -> Result<DetectionTime, DetectorFailure> {
        output.clear();
        Err(DetectorFailure {
            detector: self.0.to_owned(),
            scan: None,
            problem: crate::process::problem::DetectorProblem::Machine(
                "detectors that are programs of their own need Linux".to_owned(),
            ),
            last_words: Vec::new(),
            is_final: true,
        })
    }

    fn stage_products(&self, _: &PointCloud) -> Vec<StageProduct> {
        Vec::new()
    }
}

/// User and system time of all threads; `None` if the system does not report it.
#[cfg(target_os = "linux")]
fn own_cpu_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(Duration::new(time.tv_sec.try_into().ok()?, time.tv_nsec.try_into().ok()?))
}

/// User and system time of all threads; `None` if the system does not report it.
#[cfg(not(target_os = "linux"))]
fn own_cpu_time() -> Option<Duration> {
    None
}
