//! nuScenes, made of a simulated drive: there is no real one here.

use reports::vocabulary::class::{AnnotationClass, Occlusion};
use scans::dataset::earlier_scans::EarlierScans;

use super::made::{boxed, nuscenes, scans, street, write};
use super::{check_damaged, open, try_open};
use crate::program::{Workplace, copy_folder};

#[test]
fn a_scene_is_read_as_it_was_made() {
    let workplace = Workplace::new();
    let street = street(3);
    nuscenes(workplace.folder(), &*street);
    for folder in [workplace.folder().to_path_buf(), workplace.path("v1.0-mini")] {
        let dataset = open(&folder);
        assert_eq!(dataset.description().format, "nuscenes");
        assert_eq!(dataset.description().sensor, "hdl-32e");
        assert_eq!(dataset.scan_ids()[2].to_string(), "scene-0061/000002");
        assert_eq!(dataset.scan_time_ns(1), Some(1_532_402_928_147_951_000));
        let position_m = dataset.world_from_sensor(1).unwrap().unwrap().translation.vector;
        assert!((position_m.z - 3.84).abs() < 1e-9, "{position_m}");
        let classes = [
            AnnotationClass::Car,
            AnnotationClass::Truck,
            AnnotationClass::Pedestrian,
            AnnotationClass::Cyclist,
            AnnotationClass::Animal,
        ];
        for (found, expected) in scans(&*dataset).iter().zip(scans(&*street).iter().map(boxed)) {
            assert!(found.cloud.positions_m().eq(expected.cloud.positions_m()));
            assert_eq!(found.cloud.ring().unwrap(), vec![7; found.cloud.len()]);
            assert!(found.annotations.len() == expected.annotations.len());
            for (index, (found, expected)) in found.annotations.iter().zip(&expected.annotations).enumerate()
            {
                assert_eq!(found.class, classes[index % 5]);
                let occlusion =
                    [Occlusion::Largely, Occlusion::Partly, Occlusion::Partly, Occlusion::None][index % 4];
                assert_eq!(found.occlusion, Some(occlusion));
                let (a, b) = (found.bounding_box.unwrap(), expected.bounding_box.unwrap());
                assert!((0..3).all(|axis| (a.center_m[axis] - b.center_m[axis]).abs() < 1e-4), "{a:?} {b:?}");
                assert_eq!(a.length_width_height_m, b.length_width_height_m);
                assert!((a.yaw_rad - b.yaw_rad).sin().abs() < 1e-6 && (a.yaw_rad - b.yaw_rad).cos() > 0.0);
            }
        }
    }
    workplace.succeed("selftest .");
    workplace.succeed("run v1.0-mini -d pca --no-rrd");
}

#[test]
fn sweeps_between_keyframes_are_in_the_frame_of_a_scan_that_comes_later() {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(2));
    let dataset = open(workplace.folder());
    let [before, scan] = [0, 1].map(|it| dataset.read_scan(it).unwrap());
    let earlier = |n| EarlierScans::default().before(&*dataset, (1, &scan), n).unwrap().unwrap();
    let [sweep, keyframe] = &earlier(9)[..] else { panic!("{:?}", earlier(9).len()) };
    assert_eq!(earlier(1), std::slice::from_ref(sweep));
    assert_eq!((sweep.name.as_str(), keyframe.name.as_str()), ("scene-0061/0", "scene-0061/0"));
    assert!((sweep.before_s - 0.3).abs() < 1e-9 && (keyframe.before_s - 0.5).abs() < 1e-9, "{sweep:?}");
    let [world_from_first, world_from_second] =
        [0, 1].map(|it| dataset.world_from_sensor(it).unwrap().unwrap());
    for cloud in [&sweep.cloud, &keyframe.cloud] {
        assert_eq!(cloud.ring(), before.cloud.ring());
        for (moved_m, position_m) in cloud.positions_m().zip(before.cloud.positions_m()) {
            let expected = world_from_second.inverse()
                * world_from_first
                * nalgebra::Point3::from(position_m.map(f64::from));
            let off_m = expected - nalgebra::Point3::from(moved_m.map(f64::from));
            assert!(off_m.norm() < 1e-4, "{off_m}");
        }
    }
    // Without the files of the sweeps, detectors that look back are told which one is missing.
    std::fs::remove_file(workplace.path("sweeps/LIDAR_TOP/0.pcd.bin")).unwrap();
    let error = EarlierScans::default().before(&*dataset, (1, &scan), 1).unwrap_err();
    assert!(error.to_string().contains("sweeps/LIDAR_TOP/0.pcd.bin"), "{error}");
}

#[test]
fn several_versions_have_to_be_named() {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(1));
    copy_folder(&workplace.path("v1.0-mini"), &workplace.path("v1.0-test"));
    let error = try_open(workplace.folder()).err().unwrap();
    assert!(error.is_usage_error() && error.to_string().contains("v1.0-test"), "{error}");
    assert_eq!(open(&workplace.path("v1.0-mini")).scan_ids().len(), 1);
}

#[test]
fn damage_and_files_elsewhere_are_named() {
    let check = |table: &str, from: &str, to: &str, parts: &[&str]| {
        let workplace = Workplace::new();
        nuscenes(workplace.folder(), &*street(1));
        let path = workplace.path(&format!("v1.0-mini/{table}.json"));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{text}");
        write(&path, text.replace(from, to));
        check_damaged(workplace.folder(), parts);
    };
    check("sample_data", "samples/LIDAR_TOP", "../LIDAR_TOP", &["sample_data.json", "not below its folder"]);
    check("sample_data", "samples/LIDAR_TOP", "/etc", &["\"/etc/0.pcd.bin\"", "not below its folder"]);
    check("ego_pose", "\"00000008", "\"00000009", &["sample_data.json", "not in ego_pose.json"]);
    check("instance", "\"0000000a", "\"0000000b", &["sample_annotation.json", "has the unknown instance"]);
    check("category", "\"token\"", "\"tokens\"", &["category.json", "missing field `token`"]);
    check("scene", "[", "{", &["scene.json", "is not a table"]);
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(1));
    std::fs::remove_file(workplace.path("v1.0-mini/visibility.json")).unwrap();
    check_damaged(workplace.folder(), &["visibility.json"]);
    nuscenes(workplace.folder(), &*street(1));
    workplace.write("samples/LIDAR_TOP/0.pcd.bin", &[0; 41]);
    check_damaged(workplace.folder(), &["0.pcd.bin", "41 bytes", "20 of a point"]);
}

/// `table` with the number behind each `from` written as `to`, which the program refuses with all of `parts`.
#[track_caller]
fn check_nan(table: &str, from: &str, to: &str, parts: &[&str]) {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(1));
    let path = workplace.path(&format!("v1.0-mini/{table}.json"));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut pieces = text.split(from);
    let mut damaged = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let end = piece.find([',', '\n', ']']).unwrap();
        damaged.extend([from, to, &piece[end..]]);
    }
    assert_ne!(damaged, text);
    std::fs::write(&path, damaged).unwrap();
    check_damaged(workplace.folder(), parts);
}

#[test]
fn numbers_of_python_that_are_none_are_named_with_their_record() {
    let size = "\"size\": [\n      ";
    check_nan(
        "sample_annotation",
        size,
        "NaN",
        &["sample_annotation.json", "has a box of the instance", "in the sample", "that has NaN in its size"],
    );
    let translation = "\"translation\": [\n      ";
    check_nan("sample_annotation", translation, "-Infinity", &["that has -Infinity in its translation"]);
    check_nan(
        "ego_pose",
        translation,
        "NaN",
        &["ego_pose.json", "has a record \"", "that has NaN in its translation"],
    );
    check_nan("calibrated_sensor", translation, "NaN", &["has NaN in its translation"]);
}
