//! `scanbench data convert` and `scanbench data simulate`, and runs on what they leave.

use std::path::Path;

use test_data::test_data;

use crate::program::Workplace;

/// The first scans in `folder` and a recording of them have the same counts by each detector.
#[track_caller]
fn check_same_counts(folder: &Path) {
    let folder = folder.to_str().unwrap();
    let workplace = Workplace::new();
    workplace.succeed(&("data convert", [folder], "-o made.mcap --scans 0..3"));
    let counts = |data: &str, name: &str| -> Vec<[String; 7]> {
        workplace.succeed(&("run", [data], "-d hierarchical,pca --scans 0..3 --no-rrd -o", name));
        let rows = workplace.table(&format!("{name}/scans.csv")).into_iter();
        let columns = ["detector", "task", "no", "tp", "mo", "fo", "ignored_detections"];
        rows.map(|row| columns.map(|it| row[it].clone())).collect()
    };
    let expected = counts(folder, "original");
    assert!(expected.len() >= 4, "{expected:?}");
    assert_eq!(counts("made.mcap", "recording"), expected);
}

#[test]
#[ignore = "needs kitti_tracking, kitti_object, semantic_kitti and argoverse2 of data/ in SCANBENCH_TEST_DATA"]
fn a_recording_of_recorded_scans_scores_the_same() {
    for name in ["kitti_tracking", "kitti_object", "semantic_kitti", "argoverse2"] {
        check_same_counts(&test_data(&format!("data/{name}")));
    }
}

#[test]
fn simulated_streets_are_written_and_stay_simulated() {
    let workplace = Workplace::new();
    let small = ["--simulated-scans", "2", "--sensor", "vlp-16"];
    let simulate = |arguments: &[&str]| workplace.succeed(&("data simulate", arguments, &small));
    simulate(&["street-narrow", "-o", "narrow.mcap"]);
    let all = simulate(&["streets", "-o", "streets", "--to", "kitti-tracking"]);
    assert_eq!(
        all.stdout.lines().filter(|line| line.ends_with("2 scans  kitti-tracking, simulated")).count(),
        3
    );
    workplace
        .succeed("run narrow.mcap streets/street-narrow -d pca --no-rrd")
        .check_stdout(&["Task objects on 2 simulated data sets, 4 scans."]);
    workplace.succeed("selftest narrow.mcap");
}

#[test]
#[ignore = "needs data/kitti_tracking, data/kitti_object and data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn sound_data_are_checked_without_a_warning() {
    let workplace = Workplace::new();
    for (folder, expected) in [
        (test_data("data/kitti_tracking"), "40 of 1 drive"),
        (test_data("data/kitti_object"), "8, no times known"),
        (test_data("data/semantic_kitti"), "103.7 ms; 0 gaps"),
    ] {
        let ended = workplace.succeed(&["data", "check", folder.to_str().unwrap()]);
        ended.check_stdout(&[expected]);
        // A part of a drive has labels of the other scans.
        let mut warnings = ended.stdout.lines().filter(|it| it.starts_with("WARNING"));
        assert!(warnings.all(|it| it.contains("labels of 114 missing scans")), "{}", ended.stdout);
    }
}

#[test]
fn what_is_wrong_with_data_is_said() {
    let workplace = Workplace::new();
    let drawn = crate::drawn_dataset::DrawnDataset::tracking(workplace.folder(), 3);
    let check = || workplace.run("data check street");
    let sound = check();
    assert_eq!(sound.exit_code, Some(0), "{sound:#?}");
    assert!(sound.stdout.contains("6: 6 car") && !sound.stdout.contains("WARNING"), "{}", sound.stdout);

    // Labels as if the camera were turned to the left.
    let calibration = "training/calib/0000.txt";
    let turned = workplace.read(&format!("street/{calibration}"));
    let turned = turned.replace("0 -1 0 0 0 0 -1 0 1 0 0 0", "1 0 0 0 0 0 -1 0 0 1 0 0");
    let original = workplace.read(&format!("street/{calibration}"));
    drawn.write(calibration, &turned);
    let ended = check();
    ended.check_stdout(&["contain no point: the labels and scans may differ in frame or time"]);
    drawn.write(calibration, &original);

    drawn.remove("training/velodyne/0000/000001.bin");
    drawn.repeat_first_scan(2);
    drawn.change("training/velodyne/0000/000002.bin", |bytes| bytes.truncate(1001));
    let ended = check();
    assert_eq!(ended.exit_code, Some(3));
    ended.check_stdout(&["1 scan repeated: 0000/000001", "1 scan cannot be read, the first is 0000/000002"]);
    ended.check_stderr(&["000002.bin", "1001 bytes"]);
}

#[test]
fn a_checksum_in_the_catalogue_refuses_other_files() {
    let workplace = Workplace::new();
    let drawn = crate::drawn_dataset::DrawnDataset::tracking(workplace.folder(), 1);
    workplace.write(
        "my.toml",
        "[recorded.mine]\nformat = \"kitti-tracking\"\nroot = \"street\"\nannotated_classes = [\"car\"]\n\
         sensor_height_m = 1.73\nlicence = \"mine\"\nurl = \"https://example.org\"\n",
    );
    let printed = workplace.succeed("data hash mine --catalogue my.toml --write").stdout;
    let checksum = printed.trim().strip_prefix("mine  ").unwrap();
    assert!(workplace.read("my.toml").ends_with(&format!("checksum = \"{checksum}\"\n")));
    workplace.succeed("data check mine --catalogue my.toml");
    drawn.change("training/velodyne/0000/000000.bin", |bytes| bytes.truncate(160));
    workplace.refuse("data check mine --catalogue my.toml", 3, &["the catalogue says"]);
    workplace.succeed("data hash mine --catalogue my.toml --write");
    workplace.succeed("data check mine --catalogue my.toml");
}

#[test]
fn a_damaged_scan_ends_a_run_unless_it_is_to_be_skipped() {
    let workplace = Workplace::new();
    let drawn = crate::drawn_dataset::DrawnDataset::tracking(workplace.folder(), 4);
    drawn.change("training/velodyne/0000/000001.bin", |bytes| bytes.truncate(1001));
    let run = |more: &[&str]| {
        let arguments = ["run", "street", "-d", "pca", "--no-rrd", "-o", "out", "--overwrite"];
        workplace.run(&(&arguments, more))
    };
    let refused = run(&[]);
    assert_eq!(refused.exit_code, Some(3), "{refused:#?}");
    refused.check_stderr(&["000001.bin"]);
    let skipped = run(&["--skip-damaged"]);
    assert_eq!(skipped.exit_code, Some(0), "{skipped:#?}");
    skipped.check_stderr(&["warning: skipped scan 0000/000001: "]);
    let manifest = workplace.json("out/manifest.json");
    let entry = &manifest["datasets"][0];
    assert_eq!((&entry["n_scans"], &entry["skipped_scans"][0]["scan"]), (&4.into(), &"0000/000001".into()));
    assert_eq!(entry["skipped_scans"].as_array().unwrap().len(), 1);
    assert_eq!(workplace.read("out/scans.csv").lines().count(), 1 + 3 * 2);
    let converted = workplace.succeed("data convert street -o a.mcap --skip-damaged");
    assert_eq!(converted.stdout, "a.mcap  3 scans  mcap\n");
}

#[test]
fn a_recording_that_was_cut_off_is_read_to_the_cut() {
    let workplace = Workplace::with_drive(30);
    workplace.succeed("data convert street -o a.mcap --compression none");
    let path = workplace.path("a.mcap");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() * 2 / 3]).unwrap();
    workplace.refuse("data check a.mcap", 3, &["\"a.mcap\" is cut off"]);
    let rescued = workplace.succeed("data convert a.mcap -o b.mcap --skip-damaged");
    rescued.check_stderr(&["skipped the end of \"a\": it is cut off"]);
    let checked = workplace.succeed("data check b.mcap");
    let n_scans = rescued.stdout.strip_prefix("b.mcap  ").and_then(|it| it.split(' ').next()).unwrap();
    assert!(
        n_scans != "30" && checked.stdout.contains(&format!(" {n_scans} of 1 drive")),
        "{rescued:#?} {checked:#?}"
    );
}

#[test]
fn objects_are_written_a_folder_for_each_class_and_stay_simulated() {
    let workplace = Workplace::new();
    let objects = ["data", "objects", "objects-vlp-16", "--per-class", "2", "-o"];
    let ended = workplace.succeed(&(&objects, "first"));
    assert_eq!(ended.stdout, "first  2 tree, 2 car, 2 pole, 2 pedestrian, 2 other, simulated\n");
    workplace.succeed(&(&objects, "again"));
    let names = |folder: &str| {
        let class = std::fs::read_dir(workplace.path(folder)).unwrap();
        let mut names: Vec<_> = class.map(|it| it.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names("first"), ["car", "objects.json", "other", "pedestrian", "pole", "tree"]);
    for name in names("first/car") {
        let bytes = |folder: &str| std::fs::read(workplace.path(&format!("{folder}/car/{name}"))).unwrap();
        assert_eq!(bytes("first"), bytes("again"), "{name}");
    }
    let judged = [&objects[..5], &["--part", "judging", "-o", "judged"]].concat();
    workplace.succeed(&judged);
    assert_ne!(workplace.read("first/objects.json"), workplace.read("judged/objects.json"));
    let written = workplace.succeed("data objects first -o copy");
    assert!(
        written.stdout.contains("2 car") && written.stdout.ends_with("simulated\n"),
        "{}",
        written.stdout
    );
    assert_eq!(workplace.run(&(&objects, "first")).exit_code, Some(2));
}
