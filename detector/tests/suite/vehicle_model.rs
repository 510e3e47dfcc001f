//! The vehicle model inside the detector of the papers.

use detector::classify::paper_model::PaperModel;
use detector::params::HierarchicalParams;
use detector::pipeline::frame::Blobs;
use detector::pipeline::paper_detector::paper;
use detector::pipeline::stage_list::Pipeline;
use detector::stage_product::{Shape, StageProduct};
use detector::{DetectedClass, Detector, DetectorOutput, PointCloud, stage};

use crate::drawn_street::{DrawnStreet, SENSOR_HEIGHT_M};
use crate::same_as_reference::beyond_papers;
use crate::trained_on_drawings::{HATCHBACK_M, vehicle_model};

/// A hatchback ahead, and a box of its size to the right.
fn street() -> PointCloud {
    DrawnStreet::road().vehicle([7.0, 3.0], &HATCHBACK_M).block([5.0, 9.0], [-5.0, -3.2], 1.5).cloud()
}

fn detector_by(model: Option<PaperModel>) -> Pipeline<Blobs> {
    paper(&beyond_papers(), &HierarchicalParams::shipped(), model, SENSOR_HEIGHT_M)
}

#[test]
fn a_car_and_a_box_of_its_size_are_distinguished() {
    let mut found = Vec::new();
    for mut detector in [None, Some(vehicle_model())].map(detector_by) {
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

/// The street with the products of the detector with a model, and what it found.
fn products_of_street() -> (PointCloud, Vec<StageProduct>, DetectorOutput) {
    let mut detector = detector_by(Some(vehicle_model()));
    let mut output = DetectorOutput::default();
    detector.detect(&street(), &mut output);
    (street(), detector.stage_products(&street()), output)
}

fn shape<'a>(products: &'a [StageProduct], stage: &str, name: &str) -> &'a Shape {
    let product = products.iter().find(|it| it.stage == stage && it.name == name);
    &product.unwrap_or_else(|| panic!("no {stage}/{name}")).shape
}

#[test]
fn what_the_model_looked_at_is_drawn_where_the_object_is() {
    let (cloud, products, output) = products_of_street();
    let Shape::Spheres(spheres) = shape(&products, stage::FEATURES, "corner_spheres") else {
        panic!("no spheres")
    };
    assert_eq!(spheres.len(), 4 * output.detections.len());
    for (sphere, detection) in spheres.iter().zip(output.detections.iter().flat_map(|it| [it; 4])) {
        let to_center_m = |&point_idx: &u32| {
            let at_m = cloud.position_m(point_idx as usize);
            (0..3).map(|axis| (at_m[axis] - sphere.center_m[axis]).powi(2)).sum::<f32>().sqrt()
        };
        let nearest_m = detection.point_indices.iter().map(to_center_m).fold(f32::INFINITY, f32::min);
        assert!((nearest_m - sphere.radius_m).abs() < 1e-3, "{nearest_m} against {}", sphere.radius_m);
    }
    for name in ["convex_profiles", "concave_profiles", "nearest_prototypes"] {
        let Shape::Contours(contours) = shape(&products, stage::FEATURES, name) else {
            panic!("{name} are no contours")
        };
        assert_eq!(contours.len(), output.detections.len(), "{name}");
        for (contour_m, detection) in contours.iter().zip(output.detections.iter()) {
            assert!(contour_m.len() > 3, "{name}");
            let mut around = detection.bounding_box;
            // Prototypes are as long around as the profile, not as long and as high.
            around.length_width_height_m = around.length_width_height_m.map(|side_m| side_m + 1.0);
            assert!(contour_m.iter().all(|&at_m| around.contains(at_m)), "{name}: {contour_m:?}");
        }
    }
}

#[test]
fn every_stage_has_one_name_for_its_time_and_its_products() {
    let mut detector = detector_by(Some(vehicle_model()));
    let mut output = DetectorOutput::default();
    detector.detect(&street(), &mut output);
    let timed: Vec<&str> = output.stage_times.iter().map(|it| it.stage).collect();
    // Tables of runs have these names.
    let expected = [
        "grid",
        "ground",
        "walls",
        "foreground",
        "dense_level",
        "merge",
        "separation",
        "boxes",
        "features",
        "classification",
    ];
    assert_eq!(timed, expected);
    let mut drawn: Vec<&str> = detector.stage_products(&street()).iter().map(|it| it.stage).collect();
    drawn.dedup();
    let in_order: Vec<&str> = timed.into_iter().filter(|it| drawn.contains(it)).collect();
    assert_eq!(drawn, in_order);
}
