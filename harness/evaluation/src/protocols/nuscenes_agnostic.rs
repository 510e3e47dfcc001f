//! nuScenes' detection task with one class for all that moves, by which detectors without classes are compared.
//!
//! Lentsch et al.: UNION, `NeurIPS` 2024, and its program: annotations of the eight mobile classes, each within the range of
//! its class, are one class; every detection within 50 m is of it; its attribute is wrong.

use reports::rows::ranked_box_row::{BoxState, PairErrors};
use reports::vocabulary::protocol::{MOBILE, Protocol};
use scans::dataset::official::OfficialObject;

use super::nuscenes::Nuscenes;
use super::official_objects::DETECTED_OBJECT;
use super::ranked_boxes::{Pairs, RankedRules, class_evaluated};

/// The protocol.
pub struct NuscenesAgnostic;

/// The class whose rules detections are judged by.
const OF_DETECTIONS: &str = "car";

impl RankedRules for NuscenesAgnostic {
    const PROTOCOL: Protocol = Protocol::NuscenesAgnostic;
    const MOST_DETECTIONS: usize = Nuscenes::MOST_DETECTIONS;

    fn class_of(name: &str) -> Option<&'static str> {
        if name == DETECTED_OBJECT {
            return Some(MOBILE);
        }
        Nuscenes::class_of(name).filter(|it| !matches!(*it, "traffic_cone" | "barrier")).map(|_| MOBILE)
    }

    fn is_own_name(name: &str) -> bool {
        Nuscenes::is_own_name(name)
    }

    fn state(_: &'static str, object: &OfficialObject, labels: &[OfficialObject]) -> BoxState {
        let is_detection = object.score.is_some();
        let of_label = || class_evaluated::<Nuscenes>(&object.name);
        let class = if is_detection { Some(OF_DETECTIONS) } else { of_label() };
        Nuscenes::state(class.unwrap_or(OF_DETECTIONS), object, labels)
    }

    fn pairs(detections: &[&OfficialObject], annotations: &[&OfficialObject]) -> Vec<Pairs> {
        Nuscenes::pairs(detections, annotations)
    }

    fn errors(_: &'static str, detection: &OfficialObject, annotation: &OfficialObject) -> PairErrors {
        let errors = Nuscenes::errors(OF_DETECTIONS, detection, annotation);
        PairErrors { attribute: None, ..errors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;

    fn at(name: &str, x_m: f64, score: Option<f64>) -> OfficialObject {
        let object = OfficialObject::new(name, &Isometry3::translation(x_m, 0.0, 0.0), [1.0, 1.0, 1.0]);
        OfficialObject { score, ..object }
    }

    #[test]
    fn labels_have_the_range_of_their_class_and_detections_that_of_vehicles() {
        for (name, x_m, score, expected) in [
            ("human.pedestrian.adult", 39.0, None, BoxState::Counts),
            ("human.pedestrian.adult", 41.0, None, BoxState::BeyondRange),
            ("vehicle.car", 49.0, None, BoxState::Counts),
            ("pedestrian", 49.0, Some(0.5), BoxState::Counts),
            ("object", 51.0, Some(0.5), BoxState::BeyondRange),
        ] {
            assert_eq!(NuscenesAgnostic::state(MOBILE, &at(name, x_m, score), &[]), expected, "{name} {x_m}");
        }
    }

    #[test]
    fn all_that_moves_is_one_class_and_cones_and_barriers_are_none() {
        for (name, expected) in [
            ("vehicle.bus.rigid", Some(MOBILE)),
            ("REGULAR_VEHICLE", Some(MOBILE)),
            ("pedestrian", Some(MOBILE)),
            ("object", Some(MOBILE)),
            ("movable_object.barrier", None),
            ("traffic_cone", None),
            ("pole", None),
        ] {
            assert_eq!(class_evaluated::<NuscenesAgnostic>(name), expected, "{name}");
        }
        assert_eq!(class_evaluated::<Nuscenes>(DETECTED_OBJECT), None);
    }
}
