//! `SemanticKITTI`.

use std::path::Path;

use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;
use test_data::test_data;

use super::{check_damaged, open};
use crate::program::Workplace;

/// Points of the instances of scan 0, counted from the file by another program: label, instance, points.
const INSTANCES_OF_SCAN_0: [(u32, u32, usize); 14] = [
    (10, 208, 108),
    (10, 209, 63),
    (10, 210, 103),
    (10, 211, 469),
    (10, 212, 1737),
    (10, 213, 1103),
    (10, 214, 189),
    (10, 215, 31),
    (10, 216, 75),
    (10, 217, 5),
    (10, 218, 20),
    (10, 219, 60),
    (10, 504, 271),
    (255, 1, 88),
];

#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn instances_are_objects_and_poles_what_hangs_together() {
    let folder = test_data("data/semantic_kitti");
    let dataset = open(&folder);
    assert_eq!((dataset.description().format.as_str(), dataset.scan_ids().len()), ("semantic-kitti", 3));
    let scan = dataset.read_scan(0).unwrap();
    assert_eq!(scan.cloud.len(), 124_668);
    let mut instances: Vec<(u32, u32, usize)> = scan
        .annotations
        .iter()
        .filter_map(|it| it.track.map(|track| (track & 0xffff, track >> 16, it.point_indices.len())))
        .collect();
    instances.sort_unstable();
    assert_eq!(instances, INSTANCES_OF_SCAN_0);
    let poles = scan.annotations.iter().filter(|it| it.class == AnnotationClass::Pole);
    // All points of labels 80 and 81, on some things of their own.
    assert_eq!(poles.clone().map(|it| it.point_indices.len()).sum::<usize>(), 532 + 102);
    assert!((5..40).contains(&poles.clone().count()), "{}", poles.count());
    let n_unscorable = scan.point_regions.iter().filter(|it| **it == PointRegion::Unscorable).count();
    assert_eq!(n_unscorable, 2184 + 4 + 370 + 1471 + 27_123 + 1192 + 1227);
}

#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn the_sensor_moves_as_the_poses_say() {
    let folder = test_data("data/semantic_kitti");
    let dataset = open(&folder);
    let position = |scan_idx: usize| dataset.world_from_sensor(scan_idx).unwrap().unwrap().translation.vector;
    // The second pose of the file is 0.86 m ahead of the first: along x for a sensor.
    assert!(position(0).norm() < 1e-6, "{}", position(0));
    assert!((position(1).x - 0.858).abs() < 0.01 && position(1).yz().norm() < 0.08, "{}", position(1));
    assert_eq!(dataset.scan_time_ns(1), Some(103_735_900));
}

/// A drive of two scans of two points, in a folder of its own.
struct Drawn(Workplace);

impl Drawn {
    fn new() -> Self {
        let drawn = Self(Workplace::new());
        for number in 0..2 {
            drawn.write(&format!("velodyne/{number:06}.bin"), &[0; 32]);
            drawn.write(&format!("labels/{number:06}.label"), &[10, 0, 1, 0, 40, 0, 0, 0]);
        }
        drawn
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path("drive/sequences/00").join(name)
    }

    fn write(&self, name: &str, content: &[u8]) {
        self.0.write(&format!("drive/sequences/00/{name}"), content);
    }

    fn root(&self) -> std::path::PathBuf {
        self.0.path("drive")
    }
}

#[test]
fn a_drive_without_poses_is_read() {
    let drawn = Drawn::new();
    let dataset = open(&drawn.root());
    assert_eq!(dataset.scan_ids().len(), 2);
    assert_eq!(dataset.read_scan(1).unwrap().annotations.len(), 1);
    assert_eq!((dataset.scan_time_ns(0), dataset.world_from_sensor(0).unwrap()), (None, None));
}

#[track_caller]
fn check(damage: impl FnOnce(&Drawn), parts: &[&str]) {
    let drawn = Drawn::new();
    damage(&drawn);
    check_damaged(&drawn.root(), parts);
}

fn remove(path: &Path) {
    std::fs::remove_file(path).unwrap();
}

#[test]
fn what_is_missing_or_damaged_is_named() {
    check(|it| remove(&it.path("labels/000001.label")), &["labels", "1 scan has no labels: 000001.bin"]);
    check(
        |it| remove(&it.path("velodyne/000001.bin")),
        &["labels", "1 label file has no scan: 000001.label"],
    );
    check(|it| it.write("labels/000001.label", &[0; 4]), &["000001.label", "1 labels", "2 points"]);
    check(|it| it.write("labels/000001.label", &[0; 7]), &["000001.label", "7 bytes"]);

    check(|it| it.write("times.txt", b"0\n"), &["times.txt", "has 1 lines, but the last scan is 1"]);
    check(|it| it.write("times.txt", b"0\nx\n"), &["times.txt", "line 2"]);
    check(|it| it.write("poses.txt", b"1 0 0 0 0 1 0 0 0 0 1 0\n"), &["calib.txt", "does not exist"]);
    let without_labels = |it: &Drawn| std::fs::remove_dir_all(it.path("labels")).unwrap();
    check(without_labels, &["test split"]);
}
