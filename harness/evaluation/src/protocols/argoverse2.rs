//! Argoverse 2's detection challenge: each detection picks the nearest annotation, and of the detections that pick the same
//! one only the best may find it.
//!
//! Wilson et al.: Argoverse 2, `NeurIPS` 2021, section 4.1; av2 0.3.6, which differs from it.

use std::f64::consts::PI;

use reports::rows::ranked_box_row::{BoxState, PairErrors};
use reports::vocabulary::protocol::{PAIR_DISTANCES_M, Protocol};
use scans::dataset::official::OfficialObject;

use super::ranked_boxes::{Pairs, RankedRules};

/// The protocol, without regard to the region of interest of maps.
pub struct Argoverse2;

/// Only objects nearer than this to the origin of the car are evaluated, in metres.
const RANGE_M: f64 = 150.0;

impl RankedRules for Argoverse2 {
    const PROTOCOL: Protocol = Protocol::Argoverse2;

    const MOST_DETECTIONS: usize = 100;

    fn class_of(name: &str) -> Option<&'static str> {
        let class = match name {
            "car" | "van" => "REGULAR_VEHICLE",
            "truck" => "TRUCK",
            "bus" => "BUS",
            "trailer" => "VEHICULAR_TRAILER",
            "pedestrian" => "PEDESTRIAN",
            "cyclist" => "BICYCLIST",
            "parked-cycle" | "bicycle" => "BICYCLE",
            "motorcycle" => "MOTORCYCLE",
            "traffic_cone" => "CONSTRUCTION_CONE",
            other => other,
        };
        Self::PROTOCOL.class_named(class)
    }

    fn is_own_name(name: &str) -> bool {
        name.chars().all(|it| it.is_ascii_uppercase() || it == '_')
    }

    fn state(_class: &'static str, object: &OfficialObject, _labels: &[OfficialObject]) -> BoxState {
        if length_m(object.center_m) >= RANGE_M {
            BoxState::BeyondRange
        } else if object.n_points == Some(0) {
            BoxState::WithoutPoints
        } else {
            BoxState::Counts
        }
    }

    fn pairs(detections: &[&OfficialObject], annotations: &[&OfficialObject]) -> Vec<Pairs> {
        let mut is_picked = vec![false; annotations.len()];
        let pair_of = |detection: &&OfficialObject| {
            let apart_m: Vec<f64> = annotations.iter().map(|it| apart_m(detection, it)).collect();
            // Of equally near annotations the first.
            let nearest = (0..annotations.len()).min_by(|a, b| apart_m[*a].total_cmp(&apart_m[*b]));
            let picked = nearest.filter(|it| !std::mem::replace(&mut is_picked[*it], true));
            PAIR_DISTANCES_M.map(|distance_m| picked.filter(|it| apart_m[*it] < distance_m))
        };
        detections.iter().map(pair_of).collect()
    }

    fn errors(_class: &'static str, detection: &OfficialObject, annotation: &OfficialObject) -> PairErrors {
        let sides = || detection.length_width_height_m.into_iter().zip(annotation.length_width_height_m);
        let [least, most]: [f64; 2] =
            [sides().map(|(a, b)| a.min(b)).product(), sides().map(|(a, b)| a.max(b)).product()];
        PairErrors {
            translation_m: apart_m(detection, annotation),
            scale: 1.0 - least / most,
            orientation_rad: turned_rad(detection.yaw_rad - annotation.yaw_rad),
            velocity_m_per_s: None,
            attribute: None,
        }
    }
}

fn length_m(it: [f64; 3]) -> f64 {
    it.iter().map(|it| it * it).sum::<f64>().sqrt()
}

fn apart_m(a: &OfficialObject, b: &OfficialObject) -> f64 {
    length_m(std::array::from_fn(|axis| a.center_m[axis] - b.center_m[axis]))
}

/// The angle between headings that differ by `difference_rad`. A difference of a whole turn gives half a turn, as in the
/// program of the makers.
fn turned_rad(difference_rad: f64) -> f64 {
    let angle_rad = difference_rad.abs();
    if angle_rad < PI { angle_rad } else { PI - angle_rad % PI }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;

    fn at(x_m: f64, z_m: f64) -> OfficialObject {
        OfficialObject::new("BUS", &Isometry3::translation(x_m, 0.0, z_m), [4.0, 2.0, 1.0])
    }

    #[test]
    fn only_the_best_of_those_that_pick_an_annotation_may_find_it() {
        let annotations = [at(0.0, 0.0), at(3.0, 0.0)];
        let detections = [at(0.9, 0.0), at(0.1, 0.0), at(3.0, 0.0)];
        let pairs = Argoverse2::pairs(&detections.each_ref(), &annotations.each_ref());
        // The second is nearer, but comes later, and does not get the other annotation either.
        assert_eq!(pairs, [[None, Some(0), Some(0), Some(0)], [None; 4], [Some(1); 4]]);
    }

    #[test]
    fn distances_are_in_space() {
        let pairs = Argoverse2::pairs(&[&at(3.0, 0.0)], &[&at(3.0, 1.5)]);
        assert_eq!(pairs, [[None, None, Some(0), Some(0)]]);
        assert_eq!(Argoverse2::state("BUS", &at(149.9, 0.0), &[]), BoxState::Counts);
        assert_eq!(Argoverse2::state("BUS", &at(120.0, 90.0), &[]), BoxState::BeyondRange);
    }

    #[test]
    fn angles_are_as_the_makers_wrap_them() {
        for (difference_rad, expected) in
            [(0.5, 0.5), (-0.5, 0.5), (PI, PI), (2.0 * PI - 0.5, 0.5), (2.0 * PI, PI)]
        {
            let turned = turned_rad(difference_rad);
            assert!((turned - expected).abs() < 1e-12, "{difference_rad} becomes {turned}");
        }
    }
}
