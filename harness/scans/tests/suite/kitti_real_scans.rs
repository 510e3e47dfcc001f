//! The KITTI readers against real scans.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::path::Path;

use detector::OrientedBox;
use nalgebra::Vector4;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan, PointRegion, points_inside};
use scans::dataset::Dataset;
use scans::dataset::kitti::calibration::{KittiCalibration, parse_calibration};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use test_data::test_data;

/// The scans of `kitti_object` by their numbers, with the scans of `kitti_tracking` they are.
const OBJECT_SCANS: [(u32, u32); 8] =
    [(310, 136), (685, 139), (2024, 145), (3015, 133), (4371, 127), (4558, 125), (5083, 130), (7414, 142)];

fn open(folder: &Path) -> Box<dyn Dataset> {
    open_dataset(folder.to_str().unwrap(), &OpenOptions::default(), &built_in_catalogue().unwrap()).unwrap()
}

fn scans(dataset: &dyn Dataset) -> impl Iterator<Item = LabeledScan> + '_ {
    (0..dataset.scan_ids().len()).map(|scan_idx| dataset.read_scan(scan_idx).unwrap())
}

fn box_of(annotation: &Annotation) -> OrientedBox {
    annotation.bounding_box.expect("KITTI gives boxes")
}

fn is_well_seen_vehicle(annotation: &Annotation) -> bool {
    matches!(annotation.class, AnnotationClass::Car | AnnotationClass::Van)
        && annotation.point_indices.len() >= 50
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn forty_scans_hold_the_published_number_of_objects() {
    let folder = test_data("data/kitti_tracking");
    let dataset = open(&folder);
    assert_eq!(dataset.description().format, "kitti-tracking");
    assert_eq!(dataset.description().id, "kitti_tracking");
    let indices: Vec<u32> = dataset.scan_ids().iter().map(|id| id.index).collect();
    assert!(indices.into_iter().eq(110..150));

    let mut n_by_class: BTreeMap<&str, usize> = BTreeMap::new();
    for scan in scans(dataset.as_ref()) {
        for annotation in scan.annotations.iter().filter(|it| it.point_indices.len() >= 20) {
            *n_by_class.entry(annotation.class.name()).or_default() += 1;
        }
    }
    let expected = [("car", 205), ("cyclist", 40), ("pedestrian", 12), ("van", 69)];
    assert_eq!(n_by_class, BTreeMap::from(expected));
}

#[test]
#[ignore = "needs data/kitti_tracking and data/kitti_object in SCANBENCH_TEST_DATA"]
fn the_same_scans_in_both_layouts_are_the_same() {
    let [tracking, object] =
        [test_data("data/kitti_tracking"), test_data("data/kitti_object")].map(|it| open(&it));
    assert_eq!(object.description().format, "kitti-object");
    assert_eq!(object.scan_ids().len(), OBJECT_SCANS.len());
    for (scan_idx, (object_index, tracking_index)) in OBJECT_SCANS.into_iter().enumerate() {
        let scan = object.read_scan(scan_idx).unwrap();
        assert_eq!(scan.id.index, object_index);
        let tracked = tracking.scan_ids().iter().position(|id| id.index == tracking_index).unwrap();
        let tracked = tracking.read_scan(tracked).unwrap();
        assert_eq!(scan.cloud, tracked.cloud);
        assert_eq!(scan.annotations.len(), tracked.annotations.len());
        for annotation in &scan.annotations {
            let deviation = |it: &&Annotation| box_deviation(&box_of(it), &box_of(annotation));
            let same_class = tracked.annotations.iter().filter(|it| it.class == annotation.class);
            let nearest = same_class.min_by(|a, b| deviation(a).total_cmp(&deviation(b))).unwrap();
            // The files of the object benchmark are rounded to centimetres and hundredths of a radian; half of that in
            // each of three coordinates.
            assert!(deviation(&nearest) < 0.005 * 3.0_f32.sqrt(), "{annotation:?}\n{nearest:?}");
        }
    }
}

/// The largest difference of any coordinate, side (metres) or yaw (radians).
fn box_deviation(a: &OrientedBox, b: &OrientedBox) -> f32 {
    let lengths = a.center_m.into_iter().chain(a.length_width_height_m);
    let lengths = lengths.zip(b.center_m.into_iter().chain(b.length_width_height_m));
    let turn_rad = a.yaw_rad - b.yaw_rad;
    lengths.map(|(a, b)| (a - b).abs()).fold(turn_rad.sin().abs().max(1.0 - turn_rad.cos()), f32::max)
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn a_box_moved_or_turned_either_way_holds_fewer_points_of_vehicles() {
    let folder = test_data("data/kitti_tracking");
    let changes: [fn(OrientedBox) -> OrientedBox; 8] = [
        |it| moved(it, 0.2, 0.0),
        |it| moved(it, -0.2, 0.0),
        |it| moved(it, 0.0, 0.2),
        |it| moved(it, 0.0, -0.2),
        |it| moved(it, it.length_width_height_m[0], 0.0),
        |it| moved(it, -it.length_width_height_m[0], 0.0),
        |it| OrientedBox { yaw_rad: it.yaw_rad + 0.1, ..it },
        |it| OrientedBox { yaw_rad: it.yaw_rad - 0.1, ..it },
    ];
    let (mut shares_inside, mut n_vehicles) = ([0.0; 8], 0);
    for scan in scans(open(&folder).as_ref()) {
        for annotation in scan.annotations.iter().filter(|it| is_well_seen_vehicle(it)) {
            let bounding_box = above_the_road(box_of(annotation));
            let n_points = |it: OrientedBox| points_inside(&scan.cloud, &it).len() as f64;
            let n_inside = n_points(bounding_box);
            for (share, change) in shares_inside.iter_mut().zip(changes) {
                *share += n_points(change(bounding_box)) / n_inside;
            }
            n_vehicles += 1;
        }
    }
    assert!(n_vehicles > 200, "{n_vehicles} vehicles");
    let mean_shares = shares_inside.map(|share| share / f64::from(n_vehicles));
    assert!(mean_shares.iter().all(|share| *share < 0.99), "{mean_shares:?}");
}

/// The box moved along its length and across.
fn moved(bounding_box: OrientedBox, along_m: f32, across_m: f32) -> OrientedBox {
    let (sin, cos) = bounding_box.yaw_rad.sin_cos();
    let [x, y, z] = bounding_box.center_m;
    let center_m = [x + along_m * cos - across_m * sin, y + along_m * sin + across_m * cos, z];
    OrientedBox { center_m, ..bounding_box }
}

/// The upper part of a box, without the road that lies in its lowest part.
fn above_the_road(bounding_box: OrientedBox) -> OrientedBox {
    let [x, y, z] = bounding_box.center_m;
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    OrientedBox {
        center_m: [x, y, z + 0.15],
        length_width_height_m: [length_m, width_m, height_m - 0.3],
        yaw_rad: bounding_box.yaw_rad,
    }
}

#[test]
#[ignore = "needs data/kitti_object in SCANBENCH_TEST_DATA"]
fn boxes_project_onto_the_image_boxes_of_the_labels() {
    let folder = test_data("data/kitti_object");
    let mut n_checked = 0;
    for scan in scans(open(&folder).as_ref()) {
        let file = |kind: &str| folder.join(format!("training/{kind}/{:06}.txt", scan.id.index));
        let path = file("calib");
        let calibration = parse_calibration(&path, &std::fs::read_to_string(&path).unwrap()).unwrap();
        let labels = std::fs::read_to_string(file("label_2")).unwrap();
        let lines = labels.lines().filter(|line| !line.starts_with("DontCare"));
        assert_eq!(lines.clone().count(), scan.annotations.len());
        for (line, annotation) in lines.zip(&scan.annotations) {
            let fields: Vec<f64> = line.split(' ').skip(1).map(|field| field.parse().unwrap()).collect();
            let is_cut_off = fields[0] > 0.0;
            // People were outlined by hand in the image, more closely than their boxes.
            if is_cut_off || annotation.class == AnnotationClass::Pedestrian {
                continue;
            }
            n_checked += 1;
            let projected = outline_px(&box_of(annotation), &calibration);
            for (found_px, expected_px) in projected.into_iter().zip(&fields[3..7]) {
                assert!((found_px - expected_px).abs() < 2.0, "{}: {projected:?}, label {line}", scan.id);
            }
        }
    }
    assert!(n_checked > 60, "{n_checked} boxes");
}

/// Left, top, right and bottom of the box in the image.
fn outline_px(bounding_box: &OrientedBox, calibration: &KittiCalibration) -> [f64; 4] {
    let pixels = corners_m(bounding_box).map(|[x, y, z]| {
        let pixel = calibration.image_from_velodyne * Vector4::new(x, y, z, 1.0);
        [pixel.x / pixel.z, pixel.y / pixel.z]
    });
    let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
        pixels.iter().map(|pixel| pixel[axis]).reduce(pick).expect("a box has eight corners")
    };
    [extreme(0, f64::min), extreme(1, f64::min), extreme(0, f64::max), extreme(1, f64::max)]
}

fn corners_m(bounding_box: &OrientedBox) -> [[f64; 3]; 8] {
    let z = f64::from(bounding_box.center_m[2]);
    let half_height_m = f64::from(bounding_box.length_width_height_m[2]) / 2.0;
    let footprint = bounding_box.footprint_m();
    std::array::from_fn(|corner_idx| {
        let [x, y] = footprint[corner_idx % 4].map(f64::from);
        [x, y, if corner_idx < 4 { z - half_height_m } else { z + half_height_m }]
    })
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn labeled_is_what_the_camera_sees() {
    let folder = test_data("data/kitti_tracking");
    let (mut n_whole, mut n_whole_outside) = (0, 0);
    for scan in scans(open(&folder).as_ref()) {
        assert_eq!(scan.point_regions.len(), scan.cloud.len());
        let n_outside = scan.point_regions.iter().filter(|it| **it == PointRegion::Outside).count();
        let share = n_outside as f64 / scan.cloud.len() as f64;
        // The image spans about 81 of 360 degrees.
        assert!((0.65..0.95).contains(&share), "{}: {share} outside", scan.id);
        for annotation in scan.annotations.iter().filter(|it| it.truncation == Some(0.0)) {
            let is_outside = |it: &&u32| scan.point_regions[**it as usize] == PointRegion::Outside;
            n_whole_outside += annotation.point_indices.iter().filter(is_outside).count();
            n_whole += annotation.point_indices.len();
        }
    }
    // The benchmark calls some objects whole that the edge of the image cuts.
    assert!(n_whole_outside * 50 < n_whole, "{n_whole_outside} of {n_whole}");
}
