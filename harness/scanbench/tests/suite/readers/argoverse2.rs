//! Argoverse 2.

use std::path::{Path, PathBuf};

use reports::vocabulary::class::AnnotationClass;
use test_data::test_data;

use super::{check_damaged, open};
use crate::program::{Workplace, copy_folder};

/// A log of drawn points, written by `pyarrow`.
pub fn drawn() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scans/tests/data/argoverse2")
}

#[test]
fn sweeps_are_read_in_the_frame_of_the_sensor() {
    let dataset = open(&drawn());
    let ids: Vec<String> = dataset.scan_ids().iter().map(ToString::to_string).collect();
    assert_eq!(ids, ["drawn-log/000000", "drawn-log/000001"]);
    assert_eq!((dataset.description().format.as_str(), dataset.scan_time_ns(1)), ("argoverse2", Some(2000)));
    assert_eq!([0, 1].map(|it| dataset.file_name(it)), [Some("1000"), Some("2000")]);
    // One sweep is compressed by LZ4, the other by Zstandard; the points are the same.
    let [first, second] = [0, 1].map(|scan_idx| dataset.read_scan(scan_idx).unwrap());
    assert_eq!(first.cloud, second.cloud);
    assert_eq!((first.cloud.len(), first.cloud.position_m(0)), (204, [9.5, 0.5, -1.0]));
    assert_eq!(first.cloud.intensity()[0], 0.2);
    let (rings, times_s) = (first.cloud.ring().unwrap(), first.cloud.time_offset_s().unwrap());
    assert_eq!(rings, (0..204).collect::<Vec<u16>>());
    assert!((times_s[203] - 203e-9).abs() < 1e-12, "{times_s:?}");
    let [car] = &first.annotations[..] else { panic!("{:?}", first.annotations) };
    assert_eq!(
        (car.class, car.track, &car.point_indices[..]),
        (AnnotationClass::Car, Some(1), &[0, 1, 2, 3][..])
    );
    assert_eq!(car.bounding_box.unwrap().center_m, [10.0, 0.0, -1.1]);
    let classes: Vec<_> = second.annotations.iter().map(|it| (it.class, it.track)).collect();
    assert_eq!(classes, [(AnnotationClass::Car, Some(1)), (AnnotationClass::Pedestrian, Some(0))]);
    let at = dataset.world_from_sensor(1).unwrap().unwrap().translation.vector;
    assert_eq!((at.x, at.z), (111.0, 1.5));
    for folder in ["sensor", "sensor/val", "sensor/val/drawn-log"] {
        assert_eq!(open(&drawn().join(folder)).scan_ids().len(), 2, "{folder}");
    }
}

#[test]
fn results_are_found_by_numbers_and_by_the_names_of_sweeps() {
    let boxes =
        "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\n10.0,0.0,-1.1,4.0,2.0,1.5,0.0\n";
    for (names, is_found) in
        [(["000000", "000001"], true), (["1000", "2000"], true), (["1000", "000003"], false)]
    {
        let workplace = Workplace::new();
        copy_folder(&drawn(), &workplace.path("log"));
        for name in names {
            workplace.write(&format!("found/{name}.csv"), boxes);
        }
        let run = "run log -d simple-grid --detections deep=found -P matching.min_points=1 --no-rrd -o out";
        let ended = workplace.run(run);
        assert_eq!(ended.exit_code == Some(0), is_found, "{names:?} {ended:#?}");
    }
}

#[test]
#[ignore = "needs data/argoverse2 in SCANBENCH_TEST_DATA"]
fn boxes_hold_as_many_points_as_the_makers_counted() {
    let folder = test_data("data/argoverse2");
    let scan = open(&folder).read_scan(0).unwrap();
    assert_eq!(scan.cloud.len(), 100_660);
    // Two lidars of 32 lasers, and a tenth of a second.
    assert_eq!(scan.cloud.ring().unwrap().iter().max(), Some(&63));
    let times_s = scan.cloud.time_offset_s().unwrap();
    assert!(times_s.iter().all(|it| it.abs() < 0.11) && times_s.iter().any(|it| it.abs() > 0.09));
    // num_interior_pts of the 47 rows of this sweep adds up to this; points are rounded to sixteen bits there and here.
    let counted: usize = scan.annotations.iter().map(|it| it.point_indices.len()).sum();
    assert_eq!(scan.annotations.len(), 47);
    assert!(counted.abs_diff(N_INTERIOR_POINTS) * 50 < N_INTERIOR_POINTS, "{counted}");
    let n_class = |class: AnnotationClass| scan.annotations.iter().filter(|it| it.class == class).count();
    assert_eq!((n_class(AnnotationClass::Car), n_class(AnnotationClass::Bus)), (19, 3));
    assert_eq!((n_class(AnnotationClass::Pedestrian), n_class(AnnotationClass::Truck)), (16, 3));
}

const N_INTERIOR_POINTS: usize = 17_972;

/// Changes the file `name` in a copy of the drawn log, or removes it if no bytes are left; the message has all `parts`.
#[track_caller]
fn check(name: &str, change: impl Fn(&mut Vec<u8>), parts: &[&str]) {
    let workplace = Workplace::new();
    copy_folder(&drawn().join("sensor/val/drawn-log"), &workplace.path("log"));
    let file = workplace.path("log").join(name);
    let mut bytes = std::fs::read(&file).unwrap();
    change(&mut bytes);
    std::fs::remove_file(&file).unwrap();
    if !bytes.is_empty() {
        std::fs::write(file, bytes).unwrap();
    }
    check_damaged(&workplace.path("log"), parts);
}

#[test]
fn what_is_missing_or_damaged_is_named() {
    let sweep = "sensors/lidar/1000.feather";
    check(sweep, |bytes| bytes.truncate(500), &["1000.feather", "is cut off"]);
    check(sweep, |bytes| bytes.truncate(1), &["1000.feather", "is not a Feather file"]);
    let length = |bytes: &mut Vec<u8>| {
        let at = bytes.len() - 10;
        bytes[at..at + 4].copy_from_slice(&i32::MAX.to_le_bytes());
    };
    check(sweep, length, &["1000.feather", "footer that is longer than the file"]);
    check("annotations.feather", Vec::clear, &["annotations.feather", "does not exist"]);
    check(
        "annotations.feather",
        |bytes| bytes.truncate(9),
        &["annotations.feather", "is not a Feather file"],
    );
    check("calibration/egovehicle_SE3_sensor.feather", |bytes| bytes.truncate(9), &["SE3_sensor.feather"]);
}
