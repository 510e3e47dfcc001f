//! The detector exactly as the papers print it.

use crate::classify::paper_model::PaperModel;
use crate::detector::DetectorOutput;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::fitted_objects::FittedObjects;
use crate::fit::outline::Outline;
use crate::grid::density_weighting::DensityWeighting;
use crate::params::HierarchicalParams;
use crate::params::paper::PaperParams;
use crate::pipeline::blob_stages::{OutlineBoxes, fill_dense_level, merge};
use crate::pipeline::foreground_stages::foreground_stages;
use crate::pipeline::frame::{Blobs, Frame};
use crate::pipeline::object_stages::classification;
use crate::pipeline::stage_list::{Pipeline, Stage};
use crate::point_cloud::PointCloud;
use crate::road_user::RoadUserOdds;
use crate::segment::dense_separation::DenseSeparation;
use crate::stage;
use crate::stage_product::StageProduct;

/// Objects from a hierarchical grid, and vehicles by eight values, as the papers print it; for a sensor `sensor_height_m`
/// above the road.
///
/// Density curve and sizes of vehicles are those of `of_sensor`; without a model the sizes classify vehicles. The papers
/// have no size bounds, no trained judge of groups and no completion, and so this detector has none.
///
/// Paper: HG sections 3 to 4, VM sections 3 to 5.
///
/// ```
/// use detector::classify::paper_model::PaperModel;
/// use detector::params::HierarchicalParams;
/// use detector::params::paper::PaperParams;
/// use detector::pipeline::paper_detector::paper;
/// use detector::{Detector, Rule};
///
/// let of_sensor = HierarchicalParams::shipped();
/// let detector = paper(&PaperParams::shipped(), &of_sensor, Some(PaperModel::shipped()), 1.73);
/// // Which the paper has.
/// assert_eq!(detector.rules(), [Rule::Walls]);
/// ```
pub fn paper(
    params: &PaperParams,
    of_sensor: &HierarchicalParams,
    model: Option<PaperModel>,
    sensor_height_m: f32,
) -> Pipeline<Blobs> {
    let PaperParams { merge: merging, separation, outline, cluster, .. } = params.clone();
    let front_end = params.front_end(of_sensor);
    let weighting = DensityWeighting::new(&front_end.density_weighting);
    let least_points = cluster.min_points;
    let outline = Outline::new(front_end.grid.xi, outline.min_points);
    let mut stages = foreground_stages(&front_end)
        .then(stage::DENSE_LEVEL, fill_dense_level)
        .then(stage::MERGE, merge(merging))
        .then(stage::SEPARATION, DenseSeparation::new(separation, &front_end.grid, &weighting))
        .then(stage::BOXES, OutlineBoxes::new(outline, least_points));
    if let Some(model) = model.clone() {
        stages = stages.then(stage::FEATURES, model);
    }
    let decide = move |fitted: &mut FittedObjects| {
        if let Some(model) = &model {
            fitted.decide(|_, values| RoadUserOdds::of_vehicle(model.decision_on(values)));
        }
    };
    stages = stages
        .then(stage::CLASSIFICATION, classification(of_sensor.vehicle_size.clone(), least_points, decide));
    Pipeline { name: "paper", frame: Frame::new(Blobs::new(&front_end), &front_end, sensor_height_m), stages }
}

/// Computes the values that the model looks at.
///
/// Paper: VM sections 4 and 5.
impl<C> Stage<C> for PaperModel {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        frame
            .fitted
            .describe(|object, positions_m| self.values(&object.bounding_box, positions_m.iter().copied()));
    }

    fn products(&self, _: &PointCloud, frame: &Frame<C>) -> Vec<StageProduct> {
        vehicle_shapes(self.prototypes(), &frame.fitted)
    }
}
