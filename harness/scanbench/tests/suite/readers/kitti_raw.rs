//! KITTI's raw recordings, made of a simulated drive: there are no real ones here.

use scans::annotation::PointRegion;

use super::made::{DRIVE, boxed, kitti_raw, scans, street, write_sheet};
use super::{check_damaged, open};
use crate::program::Workplace;

#[test]
fn a_drive_is_read_as_it_was_made() {
    let workplace = Workplace::new();
    let street = street(3);
    kitti_raw(workplace.folder(), &*street);
    write_sheet(workplace.folder(), &*street);
    let dataset = open(workplace.folder());
    assert_eq!(dataset.description().format, "kitti-raw");
    assert!(dataset.description().is_simulated());
    assert_eq!(dataset.scan_ids()[1].to_string(), "2011_09_26_drive_0001_sync/000001");
    assert_eq!(dataset.scan_time_ns(1).unwrap() - dataset.scan_time_ns(0).unwrap(), 100_000_000);
    for (found, expected) in scans(&*dataset).iter().zip(scans(&*street).iter().map(boxed)) {
        super::conversion::check_same_points(&found.cloud, &expected.cloud);
        assert!(expected.annotations.len() > 5 && found.annotations.len() == expected.annotations.len());
        for (found, expected) in found.annotations.iter().zip(&expected.annotations) {
            assert_eq!((found.class, found.occlusion), (expected.class, expected.occlusion));
            let (a, b) = (found.bounding_box.unwrap(), expected.bounding_box.unwrap());
            assert!((0..3).all(|axis| (a.center_m[axis] - b.center_m[axis]).abs() < 1e-4), "{a:?} {b:?}");
            assert_eq!((a.length_width_height_m, a.yaw_rad), (b.length_width_height_m, b.yaw_rad));
        }
    }
    // A hundred-thousandth of a degree of latitude, along y, and the sensor before the unit.
    let poses: Vec<_> = (0..2).map(|it| dataset.world_from_sensor(it).unwrap().unwrap()).collect();
    let way_m = poses[1].translation.vector - poses[0].translation.vector;
    assert!((way_m.y - 1.1132).abs() < 1e-3 && way_m.x.abs() < 1e-6, "{way_m}");
    assert!((poses[0].translation.vector.norm() - (0.8_f64 * 0.8 * 2.0 + 0.09).sqrt()).abs() < 1e-9);
    workplace.succeed("selftest .");
    workplace.succeed(&["run", DRIVE.split('/').next().unwrap(), "-d", "pca", "--no-rrd"]);
    // A single drive, a day, and the folder of all days.
    assert_eq!(open(&workplace.path(DRIVE)).scan_ids().len(), 3);
    assert_eq!(open(&workplace.path("2011_09_26")).scan_ids().len(), 3);
}

#[test]
fn what_the_camera_sees_is_labelled_and_drives_without_tracklets_are_not() {
    let workplace = Workplace::new();
    kitti_raw(workplace.folder(), &*street(1));
    let scan = open(workplace.folder()).read_scan(0).unwrap();
    for region in [PointRegion::Labeled, PointRegion::Outside] {
        assert!(scan.point_regions.contains(&region), "{region:?}");
    }
    std::fs::remove_file(workplace.path(&format!("{DRIVE}/tracklet_labels.xml"))).unwrap();
    let scan = open(workplace.folder()).read_scan(0).unwrap();
    assert!(scan.annotations.is_empty() && scan.point_regions.iter().all(|it| *it == PointRegion::Outside));
    let ended = workplace.run("run . -d pca --no-rrd");
    assert!(ended.exit_code == Some(0) && ended.stderr.contains("has no labels"), "{ended:#?}");
}

#[test]
fn damage_is_named() {
    let check = |file: &str, content: &str, parts: &[&str]| {
        let workplace = Workplace::new();
        kitti_raw(workplace.folder(), &*street(2));
        workplace.write(file, content);
        check_damaged(workplace.folder(), parts);
    };
    let drive = |file: &str| format!("{DRIVE}/{file}");
    check(
        &drive("velodyne_points/timestamps.txt"),
        "2011-09-26 13:02:25.9\n",
        &["timestamps.txt", "has 1 lines"],
    );
    check(&drive("velodyne_points/timestamps.txt"), "soon\n", &["line 1", "\"soon\" is not a time"]);
    check(&drive("velodyne_points/data/0000000001.bin"), "12345", &["0000000001.bin", "5 bytes"]);
    check(&drive("velodyne_points/data/1.bin"), "", &["1.bin", "ten digits"]);
    check(
        &drive("tracklet_labels.xml"),
        "<boost_serialization>",
        &["tracklet_labels.xml", "is no file of tracklets"],
    );
    check("2011_09_26/calib_velo_to_cam.txt", "R: 1 0 0\n", &["calib_velo_to_cam.txt", "no line R"]);
    check(
        &drive("oxts/data/0000000000.txt"),
        "91 0 0 0 0 0",
        &["0000000000.txt", "latitude 91 and longitude 0 do not exist"],
    );
    let workplace = Workplace::new();
    kitti_raw(workplace.folder(), &*street(1));
    std::fs::remove_file(workplace.path("2011_09_26/calib_cam_to_cam.txt")).unwrap();
    check_damaged(workplace.folder(), &["calib_cam_to_cam.txt", "does not exist"]);
}
