//! The boxes of a published detector on real scans: if frames were wrong, they would lie beside the cars.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;

use detector::{DetectedClass, Detection, DetectorOutput};
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{LabeledScan, points_inside};
use scans::conversion::results::result_folder::{ResultFolder, ResultOutput};
use scans::dataset::Dataset;
use scans::dataset::class_table::ClassTable;
use scans::foreign::detections::{ForeignBox, ForeignDetections};
use scans::foreign::foreign_results::{ForeignResults, MissingResults, ResultRequest, open_results};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use test_data::test_data;

fn open(folder: &std::path::Path) -> Box<dyn Dataset> {
    open_dataset(folder.to_str().unwrap(), &OpenOptions::default(), &built_in_catalogue().unwrap()).unwrap()
}

fn results(path: &std::path::Path, dataset: &dyn Dataset) -> ForeignResults {
    let scan_indices: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let (classes, missing) = (&ClassTable::default(), MissingResults::Refuse);
    open_results(path, dataset, &ResultRequest { scan_indices: &scan_indices, classes, missing }).unwrap()
}

fn read(results: &mut ForeignResults, scan: &LabeledScan) -> ForeignDetections {
    results.read(scan).unwrap().expect("it has all scans")
}

/// Points that both have, of those that either has.
fn jaccard(one: &[u32], other: &[u32]) -> f64 {
    let one: BTreeSet<u32> = one.iter().copied().collect();
    let n_both = other.iter().filter(|it| one.contains(it)).count();
    n_both as f64 / (one.len() + other.len() - n_both).max(1) as f64
}

/// Counted with `grep` and `cut` in the file: 681 lines, of which 443 are of cars.
#[test]
#[ignore = "needs data/kitti_tracking and data/kitti_tracking_results/pointrcnn in SCANBENCH_TEST_DATA"]
fn boxes_of_pointrcnn_lie_on_cars() {
    let dataset = open(&test_data("data/kitti_tracking"));
    let mut results = results(&test_data("data/kitti_tracking_results/pointrcnn"), &*dataset);
    let (mut n_boxes, mut n_sure, mut n_sure_full) = (0, 0, 0);
    let (mut n_cars, mut n_on_cars) = (0, 0);
    let mut overlaps = Vec::new();
    for scan_idx in 0..dataset.scan_ids().len() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let found = read(&mut results, &scan);
        assert_eq!((&found.clusters, found.boxes.iter().filter(|it| it.score.is_none()).count()), (&None, 0));
        n_boxes += found.boxes.len();
        let points: Vec<Vec<u32>> =
            found.boxes.iter().map(|it| points_inside(&scan.cloud, &it.bounding_box)).collect();
        for (it, points) in found.boxes.iter().zip(&points) {
            if it.score > Some(5.0) {
                n_sure += 1;
                n_sure_full += usize::from(points.len() >= 20);
            }
        }
        let is_car = |it: AnnotationClass| matches!(it, AnnotationClass::Car | AnnotationClass::Van);
        for car in scan.annotations.iter().filter(|it| is_car(it.class) && it.point_indices.len() >= 100) {
            let best = points.iter().map(|it| jaccard(it, &car.point_indices)).fold(0.0, f64::max);
            n_cars += 1;
            n_on_cars += usize::from(best >= 0.5);
            overlaps.push(best);
        }
    }
    overlaps.sort_unstable_by(f64::total_cmp);
    let median = overlaps[overlaps.len() / 2];
    eprintln!(
        "{n_boxes} boxes, {n_sure} sure ones, {n_sure_full} of these with points; {n_on_cars} of {n_cars} cars found, median \
         overlap {median:.3}"
    );
    assert_eq!(n_boxes, 681);
    assert!(n_sure > 100 && n_sure_full * 100 >= n_sure * 97, "{n_sure_full} of {n_sure}");
    assert!(n_on_cars * 10 >= n_cars * 8, "{n_on_cars} of {n_cars}");
    assert!(median > 0.85, "{median}");
    assert_eq!(results.warnings(), Vec::<String>::new());
}

/// What is written is read back, on the calibration of real cars.
fn check_round_trip(output: ResultOutput, dataset: &dyn Dataset, folder: &std::path::Path) {
    let path = folder.join("written");
    let mut writer = ResultFolder::create(&path, output, false).unwrap();
    writer.begin_dataset(dataset.description());
    let mut expected: Vec<Vec<ForeignBox>> = Vec::new();
    for scan_idx in 0..dataset.scan_ids().len().min(3) {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let mut found = DetectorOutput::default();
        let mut boxes = Vec::new();
        for (number, annotation) in (0_u8..).zip(&scan.annotations) {
            let (bounding_box, score) = (annotation.bounding_box.unwrap(), Some(f32::from(number) / 8.0));
            let (class, point_indices) = (DetectedClass::Vehicle, &annotation.point_indices[..]);
            found.detections.push(Detection::new(point_indices, bounding_box, class, score));
            boxes.push(ForeignBox {
                bounding_box,
                class: Some(AnnotationClass::Car.into()),
                score,
                box_score: None,
                velocity_m_per_s: None,
                is_unlikely: false,
            });
        }
        let frame = dataset.foreign_frame(scan_idx).unwrap();
        writer.add("echo", &scan, &frame, &found).unwrap();
        expected.push(boxes);
    }
    writer.end_dataset().unwrap();
    assert_eq!(writer.finish().unwrap(), 0);

    let scan_indices: Vec<usize> = (0..expected.len()).collect();
    let (classes, missing) = (&ClassTable::default(), MissingResults::Refuse);
    let request = ResultRequest { scan_indices: &scan_indices, classes, missing };
    let mut results = open_results(&path.join("echo"), dataset, &request).unwrap();
    for (scan_idx, expected) in expected.iter().enumerate() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let found = read(&mut results, &scan);
        assert_eq!(found.boxes.len(), expected.len());
        for (found, expected) in found.boxes.iter().zip(expected) {
            let (a, b) = (found.bounding_box, expected.bounding_box);
            assert_eq!(found.class.map(|it| it.class), expected.class.map(|it| it.class));
            assert_eq!(found.score, expected.score);
            assert!((0..3).all(|axis| (a.center_m[axis] - b.center_m[axis]).abs() < 1e-4), "{a:?} {b:?}");
            let sides = a.length_width_height_m.into_iter().zip(b.length_width_height_m);
            assert!(sides.into_iter().all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
            let turn_rad = a.yaw_rad - b.yaw_rad;
            assert!(turn_rad.sin().abs() < 1e-4 && turn_rad.cos() > 0.0, "{a:?} {b:?}");
        }
        if output == ResultOutput::Csv {
            let mut expected = vec![0; scan.cloud.len()];
            for (number, annotation) in (1..).zip(&scan.annotations) {
                annotation.point_indices.iter().for_each(|it| expected[*it as usize] = number);
            }
            assert_eq!(found.clusters.as_ref(), Some(&expected));
        }
    }
    assert_eq!(results.warnings(), Vec::<String>::new());
}

#[test]
#[ignore = "needs data/kitti_tracking, data/kitti_object and data/argoverse2 in SCANBENCH_TEST_DATA"]
fn boxes_come_back_from_every_format() {
    let folders =
        [test_data("data/kitti_tracking"), test_data("data/kitti_object"), test_data("data/argoverse2")];
    for (folder, outputs) in folders.iter().zip([
        &[ResultOutput::Kitti, ResultOutput::Csv][..],
        &[ResultOutput::Kitti],
        &[ResultOutput::Argoverse2, ResultOutput::Csv],
    ]) {
        let dataset = open(folder);
        for &output in outputs {
            let directory = tempfile::tempdir().unwrap();
            check_round_trip(output, &*dataset, directory.path());
        }
    }
}
