//! Names and labels that do not fit the scans: found, said, and never mixed up.

use std::path::PathBuf;

use mcap::WriteOptions;
use scans::dataset::Dataset;

use super::recordings::{Logged, SECOND, category, cloud_at, foxglove_messages, write, write_named};
use super::{check_damaged, made, open, try_open};
use crate::drawn_dataset::DrawnDataset;
use crate::program::{Workplace, copy_folder};

/// Two clouds, and the names that the recording gives them.
fn named(workplace: &Workplace, scan_ids: &str) -> PathBuf {
    let clouds = [1, 2].map(|it| cloud_at(it * SECOND));
    write_named(workplace, WriteOptions::new(), &clouds, Some(scan_ids))
}

#[test]
fn two_scans_of_one_name_are_refused() {
    let workplace = Workplace::new();
    check_damaged(
        &named(&workplace, r#"[["a", 1], ["a", 1]]"#),
        &["drive.mcap", "several scans are called \"a/000001\""],
    );
    let ids = |scan_ids: &str| -> Vec<String> {
        open(&named(&workplace, scan_ids)).scan_ids().iter().map(ToString::to_string).collect()
    };
    assert_eq!(ids(r#"[["a", 1], ["b", 1]]"#), ["a/000001", "b/000001"]);
    assert_eq!(workplace.run("data check drive.mcap").exit_code, Some(0));
    named(&workplace, r#"[["a", 1], ["a", 1]]"#);
    assert_eq!(workplace.run("data check drive.mcap").exit_code, Some(3));
}

#[test]
fn names_that_cannot_be_taken_are_said() {
    let workplace = Workplace::new();
    for scan_ids in [r#"[["a", 1]]"#, "no list"] {
        named(&workplace, scan_ids);
        let ended = workplace.succeed("data check drive.mcap");
        let said = "but 2 scans: they are numbered instead";
        ended.check_stdout(&["WARNING", said]);
    }
    named(&workplace, r#"[["a", 1], ["a", 2]]"#);
    let ended = workplace.succeed("data check drive.mcap");
    assert!(!ended.stdout.contains("names for"), "{ended:#?}");
}

#[test]
fn drives_that_differ_by_a_slash_stay_apart() {
    let workplace = Workplace::new();
    named(&workplace, r#"[["a/b", 0], ["a_b", 0]]"#);
    for format in ["semantic-kitti", "kitti-tracking"] {
        workplace.succeed(&["data", "convert", "drive.mcap", "--to", format, "-o", format]);
        let ids: Vec<String> =
            open(&workplace.path(format)).scan_ids().iter().map(ToString::to_string).collect();
        assert_eq!(ids, ["a%2Fb/000000", "a_b/000000"], "{format}");
    }
    workplace.succeed("data prelabel drive.mcap --to labelcloud -o project");
    assert_eq!(open(&workplace.path("project")).scan_ids().len(), 2);
}

#[test]
fn two_drives_of_one_name_are_refused() {
    let workplace = Workplace::new();
    made::kitti_raw(workplace.folder(), &*made::street(1));
    let (day, drive) = made::DRIVE.split_once('/').unwrap();
    copy_folder(&workplace.path(day), &workplace.path("2011_09_27"));
    check_damaged(workplace.folder(), &["several drives are called", drive, "2011_09_27"]);

    let workplace = Workplace::new();
    for split in ["train", "val"] {
        let log = super::argoverse2::drawn().join("sensor/val/drawn-log");
        copy_folder(&log, &workplace.path(&format!("{split}/drawn-log")));
    }
    check_damaged(workplace.folder(), &["several scans are called \"drawn-log/000000\""]);

    let workplace = Workplace::new();
    made::nuscenes(workplace.folder(), &*made::street(1));
    let scene = r#"{"token": "b", "log_token": "c", "name": "scene-0061", "nbr_samples": 3}"#;
    let path = workplace.path("v1.0-mini/scene.json");
    let text = std::fs::read_to_string(&path).unwrap().trim_end().trim_end_matches(']').to_owned();
    std::fs::write(path, format!("{text}, {scene}]")).unwrap();
    check_damaged(workplace.folder(), &["scene.json", "several scenes that are called \"scene-0061\""]);
}

#[test]
fn scans_that_would_share_their_labels_are_refused() {
    let workplace = super::scan_folder::drawn();
    std::fs::copy(workplace.path("drive/a.bin"), workplace.path("drive/b.bin")).unwrap();
    check_damaged(&workplace.path("drive"), &["several scans are called \"b\"", "b.bin", "b.npy"]);
}

#[cfg(unix)]
#[test]
fn names_with_control_characters_are_refused_and_never_shown_as_they_are() {
    const RED: &str = "\u{1b}[31m";
    let check = |workplace: &Workplace, input: &str, kind: &str| {
        for arguments in
            [&["data", "check", input][..], &["run", input, "-d", "pca", "--no-rrd", "-o", "run"]]
        {
            let ended = workplace.refuse(arguments, 3, &[kind, "\\u{1b}[31m"]);
            assert!(!ended.stderr.contains('\u{1b}') && !ended.stdout.contains('\u{1b}'), "{ended:#?}");
        }
        assert!(!workplace.path("run").exists());
    };
    let workplace = Workplace::new();
    let ids = serde_json::json!([[format!("a{RED}"), 0], ["b", 0]]);
    named(&workplace, &ids.to_string());
    check(&workplace, "drive.mcap", "the drive \"a");

    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 1);
    for (folder, ending) in [("velodyne", ""), ("label_02", ".txt"), ("calib", ".txt")] {
        let name = |drive: &str| drawn.path(&format!("training/{folder}/{drive}{ending}"));
        std::fs::rename(name("0000"), name(&format!("00{RED}"))).unwrap();
    }
    check(&workplace, "street", "the drive \"00");

    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 1);
    let red = workplace.path(&format!("street{RED}"));
    std::fs::rename(&drawn.root, &red).unwrap();
    check(&workplace, &format!("street{RED}"), "the data set \"street");
}

#[test]
fn topics_and_frames_are_shown_escaped() {
    let workplace = Workplace::new();
    let (_, schema, encoding, time_ns, data) = cloud_at(SECOND);
    let messages: [Logged; 2] =
        [("/a\u{1b}[31m", schema, encoding, time_ns, data.clone()), ("/b", schema, encoding, time_ns, data)];
    let error =
        try_open(&write(&workplace, WriteOptions::new(), &messages)).err().expect("two topics").to_string();
    assert!(error.contains("/a\\u{1b}[31m (sensor_msgs") && !error.contains('\u{1b}'), "{error}");
    // Boxes in a frame that nothing connects with the cloud's.
    let workplace = Workplace::new();
    let boxes = super::recordings::detections(SECOND, "map\u{1b}[31m", [5.0, 0.0, 0.0], 0.0);
    let boxes = ("/labels", "vision_msgs/msg/Detection3DArray", "cdr", SECOND, boxes);
    let path = write(&workplace, WriteOptions::new(), &[cloud_at(SECOND), boxes]);
    let error = open(&path).read_scan(0).expect_err("another frame").to_string();
    assert!(error.contains("map\\u{1b}[31m") && !error.contains('\u{1b}'), "{error}");
}

/// The only warning of `data check` is about this many labels.
#[track_caller]
fn check_labels_without_scan(dataset: &dyn Dataset, n: usize, such_as: &str) {
    let oddities = dataset.oddities().unwrap();
    let [only] = &oddities[..] else { panic!("{oddities:?}") };
    let begins = format!("labels of {n} missing scans: ");
    assert!(only.starts_with(&begins) && only.contains(such_as), "{only}");
}

#[test]
fn labels_of_scans_that_are_not_there_are_said() {
    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 4);
    assert_eq!(open(&drawn.root).oddities().unwrap(), [""; 0]);
    drawn.remove("training/velodyne/0000/000001.bin");
    drawn.remove("training/velodyne/0000/000003.bin");
    check_labels_without_scan(&*open(&drawn.root), 2, "0000/000001");
    workplace.succeed("data check street").check_stdout(&["WARNING", "labels of 2 missing scans"]);
    // Of a part of the scans, the others' labels are none that are missing.
    let ended = workplace.succeed("data check street --scans 0");
    assert!(!ended.stdout.contains("labels of"), "{ended:#?}");

    let workplace = super::scan_folder::drawn();
    workplace.write("drive/labels/_classes.json", "{}");
    assert_eq!(open(&workplace.path("drive")).oddities().unwrap(), [""; 0]);
    std::fs::remove_file(workplace.path("drive/c.pcd")).unwrap();
    check_damaged(&workplace.path("drive"), &["1 label file has no scan: c.json"]);

    let workplace = Workplace::new();
    made::kitti_raw(workplace.folder(), &*made::street(2));
    let scan = workplace.path(&format!("{}/velodyne_points/data/0000000000.bin", made::DRIVE));
    std::fs::remove_file(scan).unwrap();
    check_labels_without_scan(&*open(workplace.folder()), 1, "/0000000000");

    let workplace = Workplace::new();
    made::nuscenes(workplace.folder(), &*made::street(2));
    let path = workplace.path("v1.0-mini/sample_data.json");
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let second: Vec<_> = rows.into_iter().skip(3).collect();
    std::fs::write(path, serde_json::to_string(&second).unwrap()).unwrap();
    check_labels_without_scan(&*open(workplace.folder()), 1, "the sample");

    let workplace = Workplace::new();
    copy_folder(&super::argoverse2::drawn(), &workplace.path("log"));
    std::fs::remove_file(workplace.path("log/sensor/val/drawn-log/sensors/lidar/1000.feather")).unwrap();
    check_labels_without_scan(&*open(&workplace.path("log")), 1, "1000");
}

#[test]
fn annotations_of_a_recording_that_no_cloud_takes_are_said() {
    let workplace = Workplace::new();
    let [cloud, scene] = foxglove_messages(SECOND, &category("car"));
    // A second too late for any cloud, and so near that the first is nearer.
    let [_, late] = foxglove_messages(2 * SECOND, &category("car"));
    let [_, second] = foxglove_messages(SECOND + SECOND / 100, &category("car"));
    let path = write(&workplace, WriteOptions::new(), &[cloud.clone(), scene.clone()]);
    assert_eq!(open(&path).oddities().unwrap(), [""; 0]);
    let path = write(&workplace, WriteOptions::new(), &[cloud, scene, late, second]);
    check_labels_without_scan(&*open(&path), 2, "logged at 1010000000 ns");
}
