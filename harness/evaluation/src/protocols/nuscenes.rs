//! nuScenes' detection task: each detection, best first, finds the nearest annotation that no better one has found.
//!
//! Caesar et al.: nuScenes, CVPR 2020, section 3.1; nuscenes-devkit 1.2.0.

use std::f64::consts::PI;

use reports::rows::ranked_box_row::{BoxState, PairErrors};
use reports::vocabulary::protocol::{PAIR_DISTANCES_M, Protocol};
use scans::dataset::official::OfficialObject;

use super::ranked_boxes::{Pairs, RankedRules};

/// The protocol.
pub struct Nuscenes;

/// Class name of bicycle racks.
const BIKE_RACK: &str = "static_object.bicycle_rack";

impl RankedRules for Nuscenes {
    const PROTOCOL: Protocol = Protocol::Nuscenes;

    // The makers refuse results with more than 500 boxes in a scan.
    const MOST_DETECTIONS: usize = usize::MAX;

    fn class_of(name: &str) -> Option<&'static str> {
        let class = match name {
            "vehicle.car" | "van" => "car",
            "vehicle.truck" => "truck",
            "vehicle.bus.bendy" | "vehicle.bus.rigid" => "bus",
            "vehicle.trailer" => "trailer",
            "vehicle.construction" => "construction_vehicle",
            "human.pedestrian.adult"
            | "human.pedestrian.child"
            | "human.pedestrian.construction_worker"
            | "human.pedestrian.police_officer" => "pedestrian",
            "vehicle.motorcycle" => "motorcycle",
            "vehicle.bicycle" | "cyclist" | "parked-cycle" => "bicycle",
            "movable_object.trafficcone" => "traffic_cone",
            "movable_object.barrier" => "barrier",
            other => other,
        };
        Self::PROTOCOL.class_named(class)
    }

    fn is_own_name(name: &str) -> bool {
        name.contains('.') || name == "animal"
    }

    fn state(class: &'static str, object: &OfficialObject, labels: &[OfficialObject]) -> BoxState {
        let [x_m, y_m, _] = object.center_m;
        let is_cycle = matches!(class, "bicycle" | "motorcycle");
        if x_m.hypot(y_m) >= range_m(class) {
            BoxState::BeyondRange
        } else if object.n_points == Some(0) {
            BoxState::WithoutPoints
        } else if is_cycle && labels.iter().any(|it| it.name == BIKE_RACK && holds(it, object.center_m)) {
            BoxState::InBikeRack
        } else {
            BoxState::Counts
        }
    }

    fn pairs(detections: &[&OfficialObject], annotations: &[&OfficialObject]) -> Vec<Pairs> {
        let mut is_taken = vec![[false; PAIR_DISTANCES_M.len()]; annotations.len()];
        let pair_of = |detection: &&OfficialObject| {
            let apart_m: Vec<f64> = annotations.iter().map(|it| apart_on_plan_m(detection, it)).collect();
            std::array::from_fn(|distance| {
                let free = (0..annotations.len()).filter(|it| !is_taken[*it][distance]);
                // Of equally near annotations the first.
                let nearest = free.min_by(|a, b| apart_m[*a].total_cmp(&apart_m[*b]));
                let found = nearest.filter(|it| apart_m[*it] < PAIR_DISTANCES_M[distance])?;
                is_taken[found][distance] = true;
                Some(found)
            })
        };
        detections.iter().map(pair_of).collect()
    }

    fn errors(class: &'static str, detection: &OfficialObject, annotation: &OfficialObject) -> PairErrors {
        let volume = |sides_m: [f64; 3]| sides_m.into_iter().product::<f64>();
        let [found_m, labelled_m] = [detection, annotation].map(|it| it.length_width_height_m);
        let common = volume(std::array::from_fn(|side| found_m[side].min(labelled_m[side])));
        // Front and back of a barrier are the same.
        let period_rad = if class == "barrier" { PI } else { 2.0 * PI };
        let velocity = annotation.velocity_m_per_s.map(|labelled| {
            // Without velocities of a detector all its objects count as standing still.
            let found = detection.velocity_m_per_s.unwrap_or_default();
            (found[0] - labelled[0]).hypot(found[1] - labelled[1])
        });
        // A velocity that the detector reports as unknown (NaN) has no error.
        let velocity = velocity.filter(|it| !it.is_nan());
        let attribute = annotation
            .attribute
            .as_ref()
            .map(|it| if detection.attribute.as_ref() == Some(it) { 0.0 } else { 1.0 });
        PairErrors {
            translation_m: apart_on_plan_m(detection, annotation),
            scale: 1.0 - common / (volume(found_m) + volume(labelled_m) - common),
            orientation_rad: turned_rad(annotation.yaw_rad - detection.yaw_rad, period_rad),
            velocity_m_per_s: velocity,
            attribute,
        }
    }
}

/// Objects of a class are evaluated only if they are nearer than this, in metres.
fn range_m(class: &str) -> f64 {
    match class {
        "car" | "truck" | "bus" | "trailer" | "construction_vehicle" => 50.0,
        "pedestrian" | "motorcycle" | "bicycle" => 40.0,
        _ => 30.0,
    }
}

fn apart_on_plan_m(a: &OfficialObject, b: &OfficialObject) -> f64 {
    (a.center_m[0] - b.center_m[0]).hypot(a.center_m[1] - b.center_m[1])
}

/// The least angle between headings that differ by `difference_rad` and mean the same every `period_rad`.
fn turned_rad(difference_rad: f64, period_rad: f64) -> f64 {
    ((difference_rad + period_rad / 2.0).rem_euclid(period_rad) - period_rad / 2.0).abs()
}

/// Whether the position lies in or on the box.
fn holds(rack: &OfficialObject, position_m: [f64; 3]) -> bool {
    let [x_m, y_m, z_m] = std::array::from_fn(|axis| position_m[axis] - rack.center_m[axis]);
    let (sin, cos) = rack.yaw_rad.sin_cos();
    let inside = [cos * x_m + sin * y_m, cos * y_m - sin * x_m, z_m];
    inside.iter().zip(rack.length_width_height_m).all(|(at_m, side_m)| at_m.abs() <= side_m / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector3};

    fn at(x_m: f64, y_m: f64) -> OfficialObject {
        OfficialObject::new("car", &Isometry3::translation(x_m, y_m, 0.0), [4.0, 2.0, 1.0])
    }

    #[test]
    fn a_detection_finds_the_nearest_that_is_still_free() {
        let annotations = [at(0.0, 0.0), at(3.0, 0.0)];
        let detections = [at(0.4, 0.0), at(0.1, 0.0), at(9.0, 0.0)];
        let pairs = Nuscenes::pairs(&detections.each_ref(), &annotations.each_ref());
        // The second is nearer to the first annotation, but comes later: it gets the other, 2.9 m away.
        assert_eq!(pairs, [[Some(0); 4], [None, None, None, Some(1)], [None; 4]]);
    }

    #[test]
    fn a_pair_is_closer_than_the_distance() {
        let pairs = Nuscenes::pairs(&[&at(0.0, 2.0)], &[&at(0.0, 0.0)]);
        assert_eq!(pairs, [[None, None, None, Some(0)]]);
    }

    #[test]
    fn what_is_far_or_empty_or_in_a_rack_is_left_out() {
        let rack = OfficialObject { name: BIKE_RACK.to_owned(), ..at(20.0, 0.0) };
        let state =
            |class, object: &OfficialObject| Nuscenes::state(class, object, std::slice::from_ref(&rack));
        assert_eq!(state("car", &at(30.0, 39.9)), BoxState::Counts);
        assert_eq!(state("car", &at(30.0, 40.0)), BoxState::BeyondRange);
        assert_eq!(state("barrier", &at(30.0, 0.0)), BoxState::BeyondRange);
        assert_eq!(
            state("car", &OfficialObject { n_points: Some(0), ..at(9.0, 0.0) }),
            BoxState::WithoutPoints
        );
        assert_eq!(state("bicycle", &at(22.0, 1.0)), BoxState::InBikeRack);
        assert_eq!(state("bicycle", &at(22.0, 1.1)), BoxState::Counts);
        assert_eq!(state("car", &at(20.0, 0.0)), BoxState::Counts);
    }

    #[test]
    fn errors_can_be_done_in_the_head() {
        let turned = |yaw_rad: f64| {
            OfficialObject::new(
                "car",
                &Isometry3::new(Vector3::new(3.0, 4.0, 9.0), Vector3::z() * yaw_rad),
                [4.0, 1.0, 2.0],
            )
        };
        let labelled = OfficialObject {
            velocity_m_per_s: Some([0.0, 2.0]),
            attribute: Some("a".to_owned()),
            ..at(0.0, 0.0)
        };
        let errors = Nuscenes::errors("car", &turned(3.0), &labelled);
        assert_eq!(
            (errors.translation_m, errors.velocity_m_per_s, errors.attribute),
            (5.0, Some(2.0), Some(1.0))
        );
        // 4 in common of 8 and 8.
        assert!(
            (errors.scale - (1.0 - 4.0 / 12.0)).abs() < 1e-12 && (errors.orientation_rad - 3.0).abs() < 1e-12
        );
        let of_barrier = Nuscenes::errors("barrier", &turned(3.0), &labelled).orientation_rad;
        assert!((of_barrier - (PI - 3.0)).abs() < 1e-12);
    }
}
