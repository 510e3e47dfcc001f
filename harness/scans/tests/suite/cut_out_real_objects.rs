//! Objects that are cut out of real scans.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use reports::vocabulary::partial_class::PartialClass;
use scans::object_cloud::cut_out::CutOutParams;
use scans::object_cloud::cut_out_objects::{Registration, cut_out_objects};
use scans::object_cloud::growing_cloud::GrowingCloud;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use test_data::test_data;

fn objects(folder: &Path, registration: Registration) -> Vec<GrowingCloud> {
    let catalogue = built_in_catalogue().unwrap();
    let dataset = open_dataset(folder.to_str().unwrap(), &OpenOptions::default(), &catalogue).unwrap();
    let all: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let objects = cut_out_objects(dataset.as_ref(), &all, registration, &CutOutParams::USUAL).unwrap();
    (0..objects.classes().len()).map(|it| objects.read(it).unwrap()).collect()
}

/// Objects of each of tree, car, pole, pedestrian and none of these.
#[track_caller]
fn check_counts(objects: &[GrowingCloud], expected: [usize; 5]) {
    let n_of = |class| objects.iter().filter(|it| it.whole.class == class).count();
    assert_eq!(PartialClass::ALL.map(n_of), expected);
}

/// Objects stand on the ground: their lowest points are near it, and cars and people are as high as such.
#[track_caller]
fn check_heights(objects: &[GrowingCloud]) {
    for object in objects {
        let z_m = object.whole.cloud.z_m();
        let lowest_m = z_m.iter().copied().fold(f32::INFINITY, f32::min);
        let highest_m = z_m.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let highest_allowed_m = match object.whole.class {
            PartialClass::Car => 3.2,
            PartialClass::Pedestrian => 2.3,
            _ => 25.0,
        };
        assert!((-0.1..2.5).contains(&lowest_m), "{}: {lowest_m}", object.whole.id);
        assert!((0.2..highest_allowed_m).contains(&highest_m), "{}: {highest_m}", object.whole.id);
    }
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn tracks_of_kitti_are_registered_by_their_boxes() {
    let folder = test_data("data/kitti_tracking");
    let each = objects(&folder, Registration::EachScan);
    check_counts(&each, [0, 271, 0, 12, 40]);
    check_heights(&each);
    let over = objects(&folder, Registration::OverScans);
    check_counts(&over, [0, 12, 0, 1, 1]);
    check_heights(&over);
}

#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn instances_of_semantic_kitti_are_registered_by_poses() {
    let folder = test_data("data/semantic_kitti");
    let each = objects(&folder, Registration::EachScan);
    check_counts(&each, [0, 36, 21, 0, 3]);
    check_heights(&each);
    let over = objects(&folder, Registration::OverScans);
    check_counts(&over, [0, 13, 9, 0, 1]);
    check_heights(&over);
}

#[test]
#[ignore = "needs data/argoverse2 in SCANBENCH_TEST_DATA"]
fn boxes_of_argoverse_are_cut_out() {
    let each = objects(&test_data("data/argoverse2/sensor/val"), Registration::EachScan);
    check_counts(&each, [0, 15, 0, 4, 5]);
    check_heights(&each);
}
