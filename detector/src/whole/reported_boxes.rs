//! The boxes that are reported.

use std::sync::Arc;

use serde::Deserialize;

use crate::detection::{BoxDetails, DetectedClass, Detection};
use crate::detector::DetectorOutput;
use crate::fit::outline_box::OutlineBox;
use crate::oriented_box::OrientedBox;
use crate::point_cloud::PointCloud;
use crate::road_user::{N_ROAD_USERS, RoadUser};
use crate::whole::box_model::BoxModels;
use crate::whole::whole_box::{SeenRoadUser, WholeBoxes};

/// Objects that end no higher above the ground than this stand on it, in metres.
const MOST_CLEARANCE_M: f32 = 0.6;

/// Which boxes are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxParams {
    /// Whether boxes lie along the outline that the sensor sees; otherwise close to the corners of the convex hull (VM
    /// section 4).
    pub outline: bool,
    /// Whether road users have the box of all of them, and other objects one down to the ground if it ends a little
    /// above it; otherwise that of the seen part.
    pub whole: bool,
}

/// Fits the boxes that are reported, after all other decisions. Points and classes do not change.
#[derive(Debug, Clone)]
pub struct ReportedBoxes {
    outlined: bool,
    // `None` where boxes are those of the seen parts.
    models: Option<Arc<BoxModels>>,
    outline: OutlineBox,
    positions_m: Vec<[f32; 3]>,
    seen: [Vec<SeenRoadUser>; N_ROAD_USERS],
    whole: WholeBoxes,
}

impl ReportedBoxes {
    /// Boxes as `params` say, of whole road users by the models that come with the program.
    pub fn new(params: BoxParams) -> Self {
        Self {
            outlined: params.outline,
            models: params.whole.then(BoxModels::shipped),
            outline: OutlineBox::default(),
            positions_m: Vec::new(),
            seen: Default::default(),
            whole: WholeBoxes::default(),
        }
    }

    /// Replaces the models by `other`, if there are some and road users are made whole at all.
    pub fn with_model(self, other: Option<Arc<BoxModels>>) -> Self {
        Self { models: self.models.map(|shipped| other.unwrap_or(shipped)), ..self }
    }

    /// Whether road users are made whole.
    pub fn are_whole(&self) -> bool {
        self.models.is_some()
    }

    /// Replaces the boxes in `output`, which was found in `cloud`; `ground_below_m` is the elevation of the ground below a
    /// box. Without points a box stays as it is.
    pub fn replace(
        &mut self,
        cloud: &PointCloud,
        ground_below_m: impl Fn(&OrientedBox) -> f32,
        output: &mut DetectorOutput,
    ) {
        for detections in [&mut output.detections, &mut output.unlikely] {
            self.seen.iter_mut().for_each(Vec::clear);
            detections.replace_boxes(|it| (self.fit(cloud, &ground_below_m, &it), BoxDetails::default()));
            let Some(models) = self.models.clone() else { continue };
            for (road_user, seen) in RoadUser::ALL.into_iter().zip(&mut self.seen) {
                let Some(model) = models.of_class(road_user) else { continue };
                let mut whole = self.whole.find(model, seen).iter();
                detections.replace_boxes(|it| {
                    if made_whole(&models, &it) != Some(road_user) {
                        return (it.bounding_box, it.box_details);
                    }
                    let whole = whole.next().expect("one of each");
                    (whole.bounding_box, whole.details(road_user, it.score))
                });
            }
        }
    }

    /// The box of the seen part. A road user that is made whole is recorded.
    fn fit(
        &mut self,
        cloud: &PointCloud,
        ground_below_m: impl Fn(&OrientedBox) -> f32,
        detection: &Detection<'_>,
    ) -> OrientedBox {
        let Self { outlined, models, outline, positions_m, seen: recorded, .. } = self;
        positions_m.clear();
        positions_m.extend(detection.point_indices.iter().map(|&it| cloud.position_m(it as usize)));
        let along = if *outlined { outline.fit(positions_m) } else { None };
        let seen = along.unwrap_or(detection.bounding_box);
        let Some(models) = models.as_ref().filter(|_| !positions_m.is_empty()) else { return seen };
        let ground_m = ground_below_m(&seen);
        if let Some(road_user) = made_whole(models, detection) {
            recorded[road_user as usize].push(SeenRoadUser::new(seen, ground_m, positions_m));
        }
        standing(seen, ground_m)
    }
}

/// `seen`, extended down to the ground if it ends a little above it: low parts are not seen, or taken for ground.
fn standing(seen: OrientedBox, ground_m: f32) -> OrientedBox {
    let [x_m, y_m, z_m] = seen.center_m;
    let [length_m, width_m, height_m] = seen.length_width_height_m;
    let [bottom_m, top_m] = [z_m - 0.5 * height_m, z_m + 0.5 * height_m];
    if bottom_m <= ground_m || bottom_m > ground_m + MOST_CLEARANCE_M {
        return seen;
    }
    OrientedBox {
        center_m: [x_m, y_m, 0.5 * (ground_m + top_m)],
        length_width_height_m: [length_m, width_m, top_m - ground_m],
        ..seen
    }
}

/// The class of a detection that is made whole: one that a model knows, of points.
fn made_whole(models: &BoxModels, detection: &Detection<'_>) -> Option<RoadUser> {
    let is_so = |it: &RoadUser| match it {
        RoadUser::Vehicle => detection.class == DetectedClass::Vehicle,
        other => detection.given.is_some() && detection.given == other.given(),
    };
    let known = RoadUser::ALL.into_iter().find(is_so).filter(|it| models.of_class(*it).is_some());
    known.filter(|_| !detection.point_indices.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classify::forest::Forest;
    use crate::whole::box_model::BoxModel;

    const GROUND_M: f32 = -1.7;

    /// A model by which every vehicle is 1 m longer at its far end than its seen part, and faces the sensor.
    fn model() -> Arc<BoxModels> {
        let always = |it: f32| Forest::new(Vec::new(), it).unwrap();
        let growth_m = [0.0, 1.0, 0.0, 0.0, 0.0].map(always);
        let vehicles = BoxModel { turned: always(-1.0), growth_m, away: always(-1.0), right: always(2.0) };
        Arc::new(BoxModels { vehicles, pedestrians: None, cyclists: None })
    }

    /// Two sides of a thing 3 m long and 1 m wide, whose lowest point is `bottom_m` above the ground.
    fn cloud(bottom_m: f32) -> PointCloud {
        let along = (0..=30_u8).map(|it| [6.0 + 0.1 * f32::from(it), 2.0, GROUND_M + bottom_m]);
        let across = (0..=10_u8).map(|it| [6.0, 2.0 + 0.1 * f32::from(it), GROUND_M + 1.4]);
        along.chain(across).collect()
    }

    const GIVEN: OrientedBox =
        OrientedBox { center_m: [1.0; 3], length_width_height_m: [9.0, 8.0, 7.0], yaw_rad: 0.7 };

    /// An object, a vehicle without points, a vehicle, and one that is unlikely. Vehicles have the score 1.
    fn reported(params: BoxParams, bottom_m: f32) -> DetectorOutput {
        let cloud = cloud(bottom_m);
        let all: Vec<u32> = (0..cloud.len() as u32).collect();
        let detection = |point_indices, class| Detection::new(point_indices, GIVEN, class, Some(1.0));
        let mut output = DetectorOutput::default();
        output.detections.push(detection(&all, DetectedClass::Object));
        output.detections.push(detection(&[], DetectedClass::Vehicle));
        output.detections.push(detection(&all, DetectedClass::Vehicle));
        output.unlikely.push(detection(&all, DetectedClass::Vehicle));
        let mut reported = ReportedBoxes::new(params).with_model(Some(model()));
        reported.replace(&cloud, |_| GROUND_M, &mut output);
        output
    }

    /// Their boxes.
    fn boxes(params: BoxParams, bottom_m: f32) -> [OrientedBox; 4] {
        let output = reported(params, bottom_m);
        let [object, empty, vehicle] = [0, 1, 2].map(|it| output.detections.get(it).bounding_box);
        [object, empty, vehicle, output.unlikely.get(0).bounding_box]
    }

    #[track_caller]
    fn check(it: OrientedBox, sizes_m: [f32; 3], bottom_m: f32) {
        let error_m = (0..3).map(|axis| (it.length_width_height_m[axis] - sizes_m[axis]).abs());
        assert!(error_m.fold(0.0, f32::max) < 1e-3, "{it:?}");
        let low_m = it.center_m[2] - 0.5 * it.length_width_height_m[2] - GROUND_M;
        assert!((low_m - bottom_m).abs() < 1e-3, "{it:?}");
    }

    #[test]
    fn vehicles_are_made_whole_and_other_things_stand_on_the_ground() {
        let [object, empty, vehicle, unlikely] = boxes(BoxParams { outline: true, whole: true }, 0.4);
        check(object, [3.0, 1.0, 1.4], 0.0);
        assert_eq!((empty, unlikely), (GIVEN, vehicle));
        check(vehicle, [4.0, 1.0, 1.4], 0.0);
        assert!((vehicle.center_m[0] - 8.0).abs() < 1e-3 && vehicle.yaw_rad.cos() < -0.999, "{vehicle:?}");
    }

    #[test]
    fn whole_boxes_are_ranked_by_vehicle_and_box_and_others_as_before() {
        let output = reported(BoxParams { outline: true, whole: true }, 0.4);
        let details = |it: usize| output.detections.get(it).box_details;
        assert_eq!([details(0), details(1)], [BoxDetails::default(); 2]);
        assert_eq!(details(2), output.unlikely.get(0).box_details);
        // One of a vehicle with odds of e to a right box with odds of e².
        let probability = |log_odds: f32| 1.0 / (1.0 + f64::from(-log_odds).exp());
        let found = probability(output.detections.get(2).box_score().unwrap());
        assert!((found - probability(1.0) * probability(2.0)).abs() < 1e-5);
        // Its front is the near end, which is not sure; the far end and the far side are not seen.
        let seen = details(2).seen.unwrap();
        assert!(seen.sides.front && !seen.sides.rear && !seen.is_front_sure);
        assert!(seen.sides.left != seen.sides.right);
        let of_what_is_seen = reported(BoxParams { outline: true, whole: false }, 0.4);
        assert_eq!(of_what_is_seen.detections.get(2).box_score(), Some(1.0));
    }

    #[test]
    fn what_hangs_or_reaches_below_the_ground_stays_there() {
        for bottom_m in [0.7, -0.2] {
            let [object, ..] = boxes(BoxParams { outline: true, whole: true }, bottom_m);
            check(object, [3.0, 1.0, 1.4 - bottom_m], bottom_m);
        }
    }

    #[test]
    fn without_whole_boxes_there_is_what_is_seen_or_what_was_given() {
        let [object, empty, vehicle, unlikely] = boxes(BoxParams { outline: true, whole: false }, 0.4);
        check(object, [3.0, 1.0, 1.0], 0.4);
        assert_eq!((empty, vehicle, unlikely), (GIVEN, object, object));
        assert_eq!(boxes(BoxParams { outline: false, whole: false }, 0.4), [GIVEN; 4]);
    }
}
