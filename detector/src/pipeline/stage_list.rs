//! A detector as a list of stages.

use crate::detection::GivenClass;
use crate::detector::{Detector, DetectorOutput, StageClock};
use crate::pipeline::frame::Frame;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::stage_product::StageProduct;

/// One step from a scan to detections.
///
/// It has parameters and buffers of its own. Results that other stages need are left in the frame; `C` is what it holds
/// between the ground and objects.
pub trait Stage<C>: Send {
    /// Does its work on `cloud` and on the results of earlier stages in `frame`. The last stages write `output`.
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput);

    /// Its products of the latest scan, which is `cloud`. Asked when all stages have run.
    fn products(&self, _cloud: &PointCloud, _frame: &Frame<C>) -> Vec<StageProduct> {
        Vec::new()
    }

    /// The classes that it may give detections.
    fn given_classes(&self) -> Vec<GivenClass> {
        Vec::new()
    }

    /// Its rules beside finding clusters.
    fn rules(&self, _frame: &Frame<C>) -> Vec<Rule> {
        Vec::new()
    }
}

/// A function is a stage without products.
impl<C, F: FnMut(&PointCloud, &mut Frame<C>, &mut DetectorOutput) + Send> Stage<C> for F {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput) {
        self(cloud, frame, output);
    }
}

/// Stages under their names, in the order in which they run.
pub struct Stages<C>(Vec<(&'static str, Box<dyn Stage<C>>)>);

impl<C> Default for Stages<C> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<C> Stages<C> {
    /// Appends `stage`; `name` is one of [`stage`](crate::stage) or of the detector's own.
    pub fn then(mut self, name: &'static str, stage: impl Stage<C> + 'static) -> Self {
        self.0.push((name, Box::new(stage)));
        self
    }

    /// Appends all of `others`.
    pub fn and(mut self, others: Self) -> Self {
        self.0.extend(others.0);
        self
    }

    /// Runs them on `cloud`, and adds the time of each to `output`.
    pub fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, output: &mut DetectorOutput) {
        let mut clock = StageClock::start();
        for (name, stage) in &mut self.0 {
            stage.run(cloud, frame, output);
            clock.lap(name, &mut output.stage_times);
        }
    }
}

/// A detector that consists of a frame and stages over it.
///
/// ```
/// use detector::detector::DetectorOutput;
/// use detector::params::HierarchicalParams;
/// use detector::pipeline::foreground_stages::foreground_stages;
/// use detector::pipeline::frame::Frame;
/// use detector::pipeline::stage_list::Pipeline;
/// use detector::segment::foreground::Foreground;
/// use detector::{DetectedClass, Detection, Detector, OrientedBox, PointCloud};
///
/// // Takes all of the foreground for one object.
/// fn report(_: &PointCloud, frame: &mut Frame<Foreground>, output: &mut DetectorOutput) {
///     let bounding_box =
///         OrientedBox { center_m: [8.0, 0.0, -1.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
///     let points = frame.clustering.point_indices();
///     output.detections.push(Detection::new(points, bounding_box, DetectedClass::Object, None));
/// }
///
/// let params = HierarchicalParams::shipped().front_end();
/// let frame = Frame::new(Foreground::new(params.foreground.clone()), &params, 1.73);
/// let stages = foreground_stages(&params).then("report", report);
/// let mut detector = Pipeline { name: "foreground", frame, stages };
/// let mut output = DetectorOutput::default();
/// detector.detect(&PointCloud::default(), &mut output);
/// let names: Vec<&str> = output.stage_times.iter().map(|it| it.stage).collect();
/// assert_eq!(names, ["grid", "ground", "walls", "foreground", "report"]);
/// ```
pub struct Pipeline<C> {
    /// The name on the command line.
    pub name: &'static str,
    /// The results of its stages on the latest scan.
    pub frame: Frame<C>,
    /// Its stages.
    pub stages: Stages<C>,
}

impl<C: Send> Detector for Pipeline<C> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        self.stages.run(cloud, &mut self.frame, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        self.stages.0.iter().flat_map(|(_, stage)| stage.products(cloud, &self.frame)).collect()
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        self.frame.ground_points(cloud)
    }

    fn given_classes(&self) -> Vec<GivenClass> {
        self.stages.0.iter().flat_map(|(_, stage)| stage.given_classes()).collect()
    }

    fn rules(&self) -> Vec<Rule> {
        self.stages.0.iter().flat_map(|(_, stage)| stage.rules(&self.frame)).collect()
    }
}
