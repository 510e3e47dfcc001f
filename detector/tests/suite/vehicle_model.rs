//! The vehicle model inside the hierarchical detector.

use detector::describe::prototype_library::PrototypeLibrary;
use detector::params::HierarchicalParams;
use detector::pipeline::hierarchical_detector::HierarchicalDetector;
use detector::stage_product::Shape;
use detector::{DetectedClass, Detector, DetectorOutput, PointCloud};

use crate::drawn_street::{DrawnStreet, SENSOR_HEIGHT_M};
use crate::trained_on_drawings::vehicle_model;

/// A hatchback ahead, and a box of its size to the right.
fn street() -> PointCloud {
    let hatchback = &PrototypeLibrary::drawn().prototypes()[0].contour_m.clone();
    DrawnStreet::road().vehicle([7.0, 3.0], hatchback).block([5.0, 9.0], [-5.0, -3.2], 1.5).cloud()
}

#[test]
fn a_car_is_told_from_a_box_of_its_size() {
    let by_size = HierarchicalDetector::new(HierarchicalParams::paper(), SENSOR_HEIGHT_M);
    let by_model = by_size.clone().with_vehicle_model(vehicle_model());
    let mut found = Vec::new();
    for mut detector in [by_size, by_model] {
        let mut output = DetectorOutput::default();
        detector.detect(&street(), &mut output);
        let mut objects: Vec<_> =
            output.detections.iter().map(|it| (it.bounding_box, it.class, it.score)).collect();
        objects.sort_by(|a, b| b.0.center_m[1].total_cmp(&a.0.center_m[1]));
        assert_eq!(objects.len(), 2);
        found.push(objects);
    }
    let [by_size, by_model] = &found[..] else { unreachable!("two detectors") };
    for (object, _) in by_size.iter().zip(by_model) {
        assert_eq!((object.1, object.2), (DetectedClass::Vehicle, None));
    }
    for ((_, class, score), expected) in by_model.iter().zip([DetectedClass::Vehicle, DetectedClass::Object])
    {
        let score = score.unwrap();
        assert_eq!(*class, expected, "score {score}");
        assert_eq!(score > 0.0, expected == DetectedClass::Vehicle);
    }
}

#[test]
fn what_is_small_for_an_object_is_kept_if_the_model_takes_it_for_a_vehicle() {
    let mut params = HierarchicalParams::paper();
    params.cluster.min_points = 1_000_000;
    let by_size = HierarchicalDetector::new(params, SENSOR_HEIGHT_M);
    let by_model = by_size.clone().with_vehicle_model(vehicle_model());
    for (mut detector, n_vehicles) in [(by_size, 0), (by_model, 1)] {
        let mut output = DetectorOutput::default();
        detector.detect(&street(), &mut output);
        let classes: Vec<_> = output.detections.iter().map(|it| it.class).collect();
        assert_eq!(classes, vec![DetectedClass::Vehicle; n_vehicles]);
        assert_eq!(output.dropped_clusters.len(), 2 - n_vehicles);
    }
}

#[test]
fn what_the_model_looked_at_can_be_drawn() {
    let mut detector = HierarchicalDetector::new(HierarchicalParams::paper(), SENSOR_HEIGHT_M)
        .with_vehicle_model(vehicle_model());
    let mut output = DetectorOutput::default();
    detector.detect(&street(), &mut output);
    let products = detector.stage_products(&street());
    let shape = |name: &str| {
        let product = products.iter().find(|it| it.stage == "classify" && it.name == name);
        &product.unwrap_or_else(|| panic!("no {name}")).shape
    };
    let Shape::Spheres(spheres) = shape("corner_spheres") else { panic!("no spheres") };
    assert_eq!(spheres.len(), 4 * output.detections.len());
    for name in ["convex_profiles", "concave_profiles", "nearest_prototypes"] {
        let Shape::Contours(contours) = shape(name) else { panic!("{name} are no contours") };
        assert_eq!(contours.len(), output.detections.len(), "{name}");
        assert!(contours.iter().all(|contour| contour.len() > 3), "{name}");
    }
}
