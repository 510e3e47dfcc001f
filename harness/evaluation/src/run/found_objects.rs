//! Detections made of the answer of a foreign detector: points of boxes, boxes of points, and classes.

use std::collections::BTreeMap;
use std::sync::Arc;

use detector::classify::size_gate::{SizeGateParams, size_gate};
use detector::classify::vehicle_model::VehicleModel;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::foreground;
use detector::pipeline::object_stages::{ObjectModels, object_stages};
use detector::pipeline::stage_list::{Pipeline, Stages};
use detector::segment::foreground::Foreground;
use detector::whole::box_model::BoxModels;
use detector::whole::reported_boxes::{BoxParams, ReportedBoxes};
use detector::{BoxDetails, DetectedClass, Detection, Detector, DetectorOutput, OrientedBox, PointCloud};
use reports::vocabulary::class_traits::ClassGroup;
use scans::foreign::foreign_class::ForeignClass;
use scans::foreign::points_in_boxes::PointsAlongX;

/// An object as a foreign detector reports it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FoundObject {
    /// Its points, as indices into the scan, ascending; `None` if they are the points in its box.
    pub point_indices: Option<Vec<u32>>,
    /// Its box in the frame of the scan; `None` if we have to fit one to its points.
    pub bounding_box: Option<OrientedBox>,
    /// Its predicted class, if the detector predicts one.
    pub class: Option<ForeignClass>,
    /// Score of the object, if the detector reports one.
    pub score: Option<f32>,
    /// Score of its box and its motion, if the detector reports them.
    pub box_details: BoxDetails,
}

impl FoundObject {
    /// An object of which only the points are known.
    pub fn of_points(point_indices: Vec<u32>) -> Self {
        Self { point_indices: Some(point_indices), ..Self::default() }
    }
}

/// The points of each cluster, ascending; `clusters` has the cluster of every point, 0 for none.
pub fn members_of(clusters: &[u32]) -> BTreeMap<u32, Vec<u32>> {
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (&id, point_idx) in clusters.iter().zip(0..) {
        if id > 0 {
            members.entry(id).or_default().push(point_idx);
        }
    }
    members
}

/// Classifies objects whose detector predicts no class, and fits boxes to objects that have none.
pub struct ForeignVehicles {
    size: SizeGateParams,
    hull_fit: ConvexHullBox,
    foreground: Pipeline<Foreground>,
    by_model: Option<ByModel>,
    boxes: ReportedBoxes,
    // Detections of the objects that had no box.
    fitted: DetectorOutput,
}

/// Our own stages for classifying the objects.
struct ByModel {
    stages: Stages<Foreground>,
    output: DetectorOutput,
}

/// An object with its points and its box.
struct PreparedObject {
    points: Vec<u32>,
    bounding_box: OrientedBox,
    // Whether we fitted the box.
    is_fitted: bool,
    class: Option<ForeignClass>,
    score: Option<f32>,
    box_details: BoxDetails,
}

/// Why objects cannot be made into detections, as the rest of a sentence.
pub type ObjectProblem = String;

impl ForeignVehicles {
    /// Classifies by the size in `params`, in scans of a sensor `sensor_height_m` above the road. Objects without a box get
    /// the box that our own detectors would report: that of the whole vehicle, by `box_model` if there is one.
    pub fn by_size(
        params: &HierarchicalParams,
        box_model: Option<Arc<BoxModels>>,
        sensor_height_m: f32,
    ) -> Self {
        Self {
            size: params.vehicle_size.clone(),
            hull_fit: ConvexHullBox::default(),
            foreground: foreground(&params.front_end(), sensor_height_m),
            by_model: None,
            boxes: ReportedBoxes::new(params.boxes).with_model(box_model),
            fitted: DetectorOutput::default(),
        }
    }

    /// As [`Self::by_size`], but classifies vehicles by `model`, as our own detectors do.
    pub fn by_model(
        params: &HierarchicalParams,
        model: VehicleModel,
        box_model: Option<Arc<BoxModels>>,
        sensor_height_m: f32,
    ) -> Self {
        let mut as_found = params.clone();
        // Objects stay as their detector found them.
        as_found.completion.enabled = false;
        as_found.boxes = BoxParams { outline: false, whole: false };
        as_found.cluster.min_points = 1;
        let stages =
            object_stages(&as_found, ObjectModels { vehicles: Some(model.of_vehicles()), boxes: None });
        let by_model = ByModel { stages, output: DetectorOutput::default() };
        Self { by_model: Some(by_model), ..Self::by_size(params, box_model, sensor_height_m) }
    }

    /// Makes detections of `objects`, in their order; objects with neither a point nor a box are left out.
    ///
    /// # Errors
    ///
    /// If they hold too many points.
    pub fn detections_of(
        &mut self,
        objects: Vec<FoundObject>,
        cloud: &PointCloud,
        output: &mut DetectorOutput,
    ) -> Result<(), ObjectProblem> {
        let mut points_along_x = None;
        let mut prepared = Vec::with_capacity(objects.len());
        for mut object in objects {
            object.box_details.has_points_of_box = object.point_indices.is_none();
            let points = match (object.point_indices, object.bounding_box) {
                (Some(points), _) => points,
                (None, Some(bounding_box)) => {
                    let points = points_along_x.get_or_insert_with(|| PointsAlongX::of(cloud));
                    points.inside(cloud, &bounding_box)?
                }
                (None, None) => continue,
            };
            let is_fitted = object.bounding_box.is_none();
            let bounding_box = object.bounding_box.or_else(|| self.fit(&points, cloud));
            let Some(bounding_box) = bounding_box else { continue };
            let FoundObject { class, score, box_details, .. } = object;
            prepared.push(PreparedObject { points, bounding_box, is_fitted, class, score, box_details });
        }
        if prepared.iter().any(|it| it.is_fitted || it.class.is_none() && self.by_model.is_some()) {
            self.foreground.detect(cloud, &mut DetectorOutput::default());
        }
        let predicted = self.classes_of(&prepared, cloud);
        self.fitted.clear();
        let detections = prepared.iter().zip(&predicted).map(|(it, &(class, score))| {
            let PreparedObject { points, bounding_box, is_fitted, .. } = it;
            (is_fitted, Detection::new(points, *bounding_box, class, score))
        });
        for (_, detection) in detections.clone().filter(|(is_fitted, _)| **is_fitted) {
            self.fitted.detections.push(detection);
        }
        let frame = &self.foreground.frame;
        self.boxes.replace(cloud, |it| frame.ground_below_m(it), &mut self.fitted);
        let mut fitted = self.fitted.detections.iter();
        for ((is_fitted, detection), object) in detections.zip(&prepared) {
            let mut reported = if *is_fitted { fitted.next() } else { None }.unwrap_or(detection);
            reported.given = object.class.and_then(|it| it.given);
            if object.score.is_some() {
                // Scores of foreign detectors are no log odds, so they cannot be combined with ours.
                reported.box_details.score = None;
            }
            reported.box_details = BoxDetails {
                score: object.box_details.score.or(reported.box_details.score),
                seen: reported.box_details.seen,
                ..object.box_details
            };
            output.detections.push(reported);
        }
        Ok(())
    }

    /// Class and score of each object: the class as its detector predicts, else by the model, else by size; the score as its
    /// detector reports, else by the model.
    fn classes_of(
        &mut self,
        objects: &[PreparedObject],
        cloud: &PointCloud,
    ) -> Vec<(DetectedClass, Option<f32>)> {
        let by_model = self.classes_by_model(objects, cloud);
        let class_of = |(object_idx, object): (usize, &PreparedObject)| {
            let PreparedObject { points, bounding_box, class, score, .. } = object;
            let predicted = class.map(|it| match it.class.group() {
                Some(ClassGroup::Vehicle) => DetectedClass::Vehicle,
                _ => DetectedClass::Object,
            });
            let by_model = by_model.as_ref().and_then(|it| it.get(object_idx).copied());
            let (class, decision) = match (predicted, by_model) {
                (Some(predicted), _) => (predicted, None),
                (None, Some(by_model)) => by_model,
                (None, None) => (size_gate(points.len(), bounding_box, &self.size), None),
            };
            (class, score.or(decision))
        };
        objects.iter().enumerate().map(class_of).collect()
    }

    fn fit(&mut self, points: &[u32], cloud: &PointCloud) -> Option<OrientedBox> {
        let positions_m = points.iter().map(|&it| cloud.position_m(it as usize));
        let heights_m = positions_m.clone().map(|it| it[2]);
        let z_range_m =
            heights_m.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        self.hull_fit.fit(positions_m.map(|[x_m, y_m, _]| [x_m, y_m]), z_range_m)
    }

    /// Class and score that the model predicts for each object; `None` without a model, or if the detector predicted all
    /// classes.
    fn classes_by_model(
        &mut self,
        objects: &[PreparedObject],
        cloud: &PointCloud,
    ) -> Option<Vec<(DetectedClass, Option<f32>)>> {
        if objects.iter().all(|it| it.class.is_some()) {
            return None;
        }
        let mut by_model = self.by_model.take()?;
        let ByModel { stages, output } = &mut by_model;
        output.clear();
        self.foreground.frame.fitted.clear();
        let mut has_points = Vec::new();
        for PreparedObject { points, bounding_box, .. } in objects {
            has_points.push(!points.is_empty());
            if points.is_empty() {
                continue;
            }
            // For its outline.
            self.fit(points, cloud);
            let positions = points.iter().map(|&it| (it, cloud.position_m(it as usize)));
            self.foreground.frame.fitted.add(positions, *bounding_box, self.hull_fit.hull_m());
        }
        stages.run(cloud, &mut self.foreground.frame, output);
        let mut judged: Vec<_> = output.detections.iter().map(|it| (it.class, it.score)).collect();
        judged.reverse();
        self.by_model = Some(by_model);
        // An object without points has no shape.
        let nothing = (DetectedClass::Object, None);
        let of_object = |has_points| if has_points { judged.pop().unwrap_or(nothing) } else { nothing };
        Some(has_points.into_iter().map(of_object).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::eligibility::counts_as_vehicle;
    use reports::vocabulary::class::AnnotationClass;
    use scans::annotation::Annotation;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    use crate::matching::box_overlap::bev_iou;
    use crate::run::config::RunConfig;

    fn found(objects: Vec<FoundObject>, cloud: &PointCloud) -> Result<DetectorOutput, ObjectProblem> {
        let mut output = DetectorOutput::default();
        let mut params = HierarchicalParams::shipped();
        params.boxes.whole = false;
        ForeignVehicles::by_size(&params, None, 1.73).detections_of(objects, cloud, &mut output)?;
        Ok(output)
    }

    const CAR: OrientedBox =
        OrientedBox { center_m: [8.0, 0.0, 0.5], length_width_height_m: [4.2, 1.8, 1.5], yaw_rad: 0.0 };

    /// 60 points on the floor of [`CAR`], and one far away.
    fn cloud() -> PointCloud {
        let inside = (0..60_u8).map(|it| [6.0 + f32::from(it) / 15.0, 0.5, 0.1 + f32::from(it % 10) / 10.0]);
        inside.chain([[30.0, 0.0, 0.0]]).collect()
    }

    #[test]
    fn a_box_alone_has_the_points_in_it_and_a_cluster_alone_the_box_around_it() {
        let boxed = FoundObject { bounding_box: Some(CAR), ..FoundObject::default() };
        let clustered = FoundObject { point_indices: Some((0..60).collect()), ..FoundObject::default() };
        let output = found(vec![boxed, clustered], &cloud()).unwrap();
        let [first, second] = [0, 1].map(|it| output.detections.get(it));
        assert_eq!(first.point_indices, second.point_indices);
        assert_eq!((first.bounding_box, first.class), (CAR, DetectedClass::Vehicle));
        assert!((second.bounding_box.length_width_height_m[0] - 59.0 / 15.0).abs() < 1e-4);
    }

    #[test]
    fn a_box_of_nothing_is_a_detection_and_a_cluster_of_nothing_is_none() {
        let far = OrientedBox { center_m: [90.0, 0.0, 0.0], ..CAR };
        let boxed = FoundObject { bounding_box: Some(far), score: Some(0.5), ..FoundObject::default() };
        let clustered = FoundObject { point_indices: Some(Vec::new()), ..FoundObject::default() };
        let output = found(vec![boxed, clustered], &cloud()).unwrap();
        assert_eq!(output.detections.len(), 1);
        assert_eq!(
            (output.detections.get(0).point_indices.len(), output.detections.get(0).score),
            (0, Some(0.5))
        );
    }

    #[test]
    fn the_class_is_the_detectors_if_it_predicts_one() {
        let with = |class: Option<AnnotationClass>| FoundObject {
            bounding_box: Some(CAR),
            class: class.map(ForeignClass::from),
            ..FoundObject::default()
        };
        let classes = [Some(AnnotationClass::Bus), Some(AnnotationClass::Misc), None].map(with);
        let output = found(classes.to_vec(), &cloud()).unwrap();
        let seen: Vec<DetectedClass> = output.detections.iter().map(|it| it.class).collect();
        assert_eq!(seen, [DetectedClass::Vehicle, DetectedClass::Object, DetectedClass::Vehicle]);
        let given: Vec<Option<&str>> = output.detections.iter().map(|it| Some(it.given?.name())).collect();
        assert_eq!(given, [Some("bus"), None, None]);
    }

    #[test]
    fn the_model_classifies_cars_among_annotated_points() {
        let options = OpenOptions { n_simulated_scans: Some(2), ..OpenOptions::default() };
        let street = open_dataset("street-main-road", &options, &built_in_catalogue().unwrap()).unwrap();
        let scan = street.read_scan(0).unwrap();
        let description = street.description();
        let config = RunConfig::load(None).unwrap().for_sensor(&description.sensor).unwrap();
        let model = config.vehicle_models.as_ref().unwrap().clusters();
        let mut vehicles =
            ForeignVehicles::by_model(&config.hierarchical, model, None, description.sensor_height_m);
        let large: Vec<_> = scan.annotations.iter().filter(|it| it.point_indices.len() >= 100).collect();
        let objects = large.iter().map(|it| FoundObject {
            point_indices: Some(it.point_indices.clone()),
            ..FoundObject::default()
        });
        let mut output = DetectorOutput::default();
        vehicles.detections_of(objects.collect(), &scan.cloud, &mut output).unwrap();
        let predicted = output.detections.iter().zip(&large);
        let n_right = predicted.filter(|(it, annotation)| {
            (it.class == DetectedClass::Vehicle) == counts_as_vehicle(annotation.class)
        });
        let n_right = n_right.count();
        assert_eq!(output.detections.len(), large.len());
        assert!(large.len() > 5 && 10 * n_right >= 8 * large.len(), "{n_right} of {}", large.len());
    }

    #[test]
    fn clusters_get_the_boxes_of_our_detectors_by_their_predicted_class_and_boxes_stay() {
        let options = OpenOptions { n_simulated_scans: Some(1), ..OpenOptions::default() };
        let street = open_dataset("street-main-road", &options, &built_in_catalogue().unwrap()).unwrap();
        let (scan, description) = (street.read_scan(0).unwrap(), street.description());
        let config = RunConfig::load(None).unwrap().for_sensor(&description.sensor).unwrap();
        // The car of which the smallest part is visible.
        let is_car = |it: &&Annotation| it.class == AnnotationClass::Car && it.point_indices.len() >= 60;
        let area_m2 = |it: &OrientedBox| it.length_width_height_m[0] * it.length_width_height_m[1];
        let visible_part = |car: &&Annotation| {
            let seen = found(vec![FoundObject::of_points(car.point_indices.clone())], &scan.cloud).unwrap();
            area_m2(&seen.detections.get(0).bounding_box) / area_m2(&car.bounding_box.unwrap())
        };
        let cars = scan.annotations.iter().filter(is_car);
        let car = cars.min_by(|a, b| visible_part(a).total_cmp(&visible_part(b))).unwrap();
        let cluster = FoundObject::of_points(car.point_indices.clone());
        let given = FoundObject { bounding_box: Some(CAR), ..cluster.clone() };
        let other = FoundObject { class: Some(AnnotationClass::Misc.into()), ..cluster.clone() };
        let as_car = FoundObject { class: Some(AnnotationClass::Car.into()), ..cluster };
        let boxes_of = |mut vehicles: ForeignVehicles| {
            let mut output = DetectorOutput::default();
            let objects = vec![as_car.clone(), given.clone(), other.clone()];
            vehicles.detections_of(objects, &scan.cloud, &mut output).unwrap();
            [0, 1, 2].map(|it| output.detections.get(it).bounding_box)
        };
        let (params, height_m) = (&config.hierarchical, description.sensor_height_m);
        let model = config.vehicle_models.as_ref().unwrap().clusters();
        let by_model = boxes_of(ForeignVehicles::by_model(params, model, None, height_m));
        assert_eq!(by_model, boxes_of(ForeignVehicles::by_size(params, None, height_m)));
        let scored = FoundObject { score: Some(0.3), ..as_car.clone() };
        let mut output = DetectorOutput::default();
        let mut vehicles = ForeignVehicles::by_size(params, None, height_m);
        vehicles.detections_of(vec![as_car.clone(), scored], &scan.cloud, &mut output).unwrap();
        let [ours, theirs] = [0, 1].map(|it| output.detections.get(it));
        // The score of the detector ranks it.
        assert_eq!((theirs.box_score(), ours.box_details.seen), (Some(0.3), theirs.box_details.seen));
        assert!(ours.score.is_none() && ours.box_score().is_some() && theirs.box_details.seen.is_some());
        let [whole, given, seen] = by_model;
        assert_eq!(given, CAR);
        let annotated = car.bounding_box.unwrap();
        assert!(bev_iou(&whole, &annotated) > bev_iou(&seen, &annotated), "{whole:?}, {seen:?}");
        assert!(area_m2(&whole) > 1.1 * area_m2(&seen), "{whole:?}, {seen:?}");
    }
}
