//! What is wrong with data, configuration or usage is said with file, position and values, with the exit code for its
//! kind, and leaves nothing behind.

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

const SCAN: &str = "training/velodyne/0000/000001.bin";
const N_BYTES_PER_POINT: usize = 16;

/// A workplace with a drive of three scans, and the means to spoil it.
struct Spoilt {
    workplace: Workplace,
    dataset: DrawnDataset,
}

impl Spoilt {
    fn drive() -> Self {
        let workplace = Workplace::new();
        let dataset = DrawnDataset::tracking(workplace.folder(), 3);
        Self { workplace, dataset }
    }

    fn objects() -> Self {
        let workplace = Workplace::new();
        let dataset = DrawnDataset::objects(workplace.folder(), 2);
        Self { workplace, dataset }
    }

    /// Runs the program with `arguments`, separated by spaces; expects `exit_code` and all `parts` in one message.
    #[track_caller]
    fn check(&self, arguments: &str, exit_code: i32, parts: &[&str]) {
        let before = self.workplace.names();
        let ended = self.workplace.run(&arguments.split(' ').collect::<Vec<_>>());
        check_refusal(&ended, exit_code, parts);
        assert_eq!(self.workplace.names(), before, "something is left behind");
    }

    /// The same for a run over the whole data set.
    #[track_caller]
    fn check_run(&self, exit_code: i32, parts: &[&str]) {
        self.check("run street -d hierarchical -o out", exit_code, parts);
    }
}

#[track_caller]
fn check_refusal(ended: &Ended, exit_code: i32, parts: &[&str]) {
    assert_eq!(ended.exit_code, Some(exit_code), "{ended:#?}");
    assert_eq!(ended.stdout, "", "{ended:#?}");
    assert!(ended.stderr.starts_with("error: "), "{ended:#?}");
    assert!(!ended.stderr.contains("panicked"), "{ended:#?}");
    for part in parts {
        assert_eq!(ended.stderr.matches(part).count(), 1, "{part:?} in {ended:#?}");
    }
}

#[test]
fn a_sound_drive_is_run() {
    // What all tests below rely on: it is the damage that is refused.
    let sound = Spoilt::drive();
    let ended = sound.workplace.run(&["run", "street", "-d", "hierarchical", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
    let objects = Spoilt::objects();
    let ended = objects.workplace.run(&["run", "street", "-d", "hierarchical", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
}

#[test]
fn a_scan_cut_within_a_point() {
    let it = Spoilt::drive();
    it.dataset.change(SCAN, |bytes| bytes.truncate(100 * N_BYTES_PER_POINT + 7));
    it.check_run(3, &["0000/000001.bin\" is damaged or cut off", "1607 bytes are not a multiple of the 16"]);
}

#[test]
fn a_scan_with_bytes_too_many() {
    let it = Spoilt::drive();
    it.dataset.change(SCAN, |bytes| bytes.push(0));
    it.check_run(3, &["0000/000001.bin\" is damaged or cut off", "not a multiple of the 16"]);
}

#[test]
fn a_coordinate_that_no_sensor_sees() {
    let it = Spoilt::drive();
    let offset = 7 * N_BYTES_PER_POINT + 8;
    it.dataset.change(SCAN, |bytes| bytes[offset..offset + 4].copy_from_slice(&(-2e4_f32).to_le_bytes()));
    it.check_run(3, &["0000/000001.bin", "point 7", "-20000"]);
}

#[test]
fn an_empty_scan() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, []);
    it.check_run(3, &["0000/000001.bin\" has no points"]);
}

#[test]
fn a_scan_that_vanishes_after_it_was_listed() {
    let it = Spoilt::drive();
    it.dataset.remove(SCAN);
    std::fs::create_dir(it.dataset.path(SCAN)).expect("the scan is removed");
    it.check_run(3, &["0000/000001.bin"]);
}

#[test]
fn damage_is_met_with_any_number_of_jobs() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    for jobs in ["1", "2", "7"] {
        let arguments = format!("run street -o out --jobs {jobs}");
        it.check(&arguments, 3, &["0000/000001.bin\" is damaged or cut off"]);
    }
}

#[test]
fn damage_beyond_the_selected_scans_does_not_matter() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    it.workplace.succeed(&["run", "street", "-d", "pca", "-o", "out", "--scans", "0,2"]);
}

#[test]
fn a_detection_on_a_damaged_scan() {
    let it = Spoilt::drive();
    let file = format!("street/{SCAN}");
    let check = |input: &str, parts: &[&str]| {
        it.check(&format!("detect {input} -o clusters.csv --boxes boxes.csv"), 3, parts);
    };
    it.dataset.change(SCAN, |bytes| bytes[4..8].copy_from_slice(&1e9_f32.to_le_bytes()));
    check(&file, &["0000/000001.bin", "point 0", "1e9"]);
    it.dataset.change(SCAN, |bytes| bytes.truncate(23));
    check(&file, &["0000/000001.bin\" is damaged or cut off", "23 bytes are not a multiple of the 16"]);
    check("street --scan 1", &["0000/000001.bin\" is damaged or cut off"]);
    it.dataset.write(SCAN, []);
    check(&file, &["0000/000001.bin\" has no points"]);
    check("gone.bin", &["cannot read \"gone.bin\": No such file"]);
}

#[test]
fn a_detection_on_what_is_no_scan() {
    let it = Spoilt::drive();
    let file = format!("street/{SCAN}");
    it.workplace.write("scan.xyz", "");
    for (arguments, part) in [
        ("detect scan.xyz", "cannot read \"scan.xyz\" as a scan: give a file that ends in .bin, .pcd"),
        ("detect nowhere --scan 1", "there is no data set \"nowhere\": it is neither in the catalogue"),
        (
            "detect street",
            "choose a scan of \"street\" with --scan: it has 3 scans from 0000/000000 to 0000/000002",
        ),
        ("detect street --scan 3", "\"street\" has no scan \"3\": it has 3 scans"),
        ("detect streets --scan 3", "\"streets\" is a group of data sets; choose one of street-main-road, "),
        ("detect street --scan 1 --seed 3", "--seed is only for simulated data sets"),
        (&format!("detect {file} --scan 1"), "--scan is only for data sets"),
        (&format!("detect {file} --sensor vlp-17"), "there is no sensor \"vlp-17\""),
    ] {
        it.check(arguments, 2, &[part]);
    }
}

#[test]
fn a_detection_whose_results_have_no_place() {
    let it = Spoilt::drive();
    std::fs::create_dir(it.workplace.path("folder.csv")).expect("a fresh folder");
    for (arguments, part) in [
        ("-o clusters.txt", "\"clusters.txt\" must end in .csv or .u32, or be -"),
        ("--boxes boxes.u32", "\"boxes.u32\" must end in .csv, or be -"),
        ("-o a.csv --boxes a.csv", "--output and --boxes must be different files"),
        ("-o - --boxes -", "--output and --boxes must be different files"),
        ("-o gone/a.csv", "cannot write \"gone/a.csv\": No such file"),
        ("-o a.csv --boxes folder.csv", "cannot write \"folder.csv\""),
        ("-o a.csv -d kdtree", "there is no detector \"kdtree\""),
    ] {
        it.check(&format!("detect street --scan 1 {arguments}"), 2, &[part]);
    }
}

#[cfg(unix)]
#[test]
fn a_disk_that_takes_no_clusters() {
    check_full_disk("detect street --scan 1 -o a.u32 --boxes b.csv", &["cannot write \"a.u32\""]);
}

#[test]
fn a_selftest_on_a_damaged_scan() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    it.check("selftest street", 3, &["0000/000001.bin\" is damaged or cut off"]);
}

#[test]
fn a_label_without_scan() {
    let it = Spoilt::objects();
    it.dataset.remove("training/velodyne/000001.bin");
    it.check_run(3, &["label_2\" does not go with the scans: 1 label file has no scan: 000001.txt"]);
}

#[test]
fn a_scan_without_label() {
    let it = Spoilt::objects();
    it.dataset.remove("training/label_2/000001.txt");
    it.check_run(3, &["label_2\" does not go with the scans: 1 scan has no labels: 000001.bin"]);
}

#[test]
fn a_malformed_label_line() {
    let it = Spoilt::drive();
    let labels =
        it.workplace.read("street/training/label_02/0000.txt").replacen("\n1 0 Car 0", "\n1 0 Car x", 1);
    it.dataset.write("training/label_02/0000.txt", labels);
    it.check_run(3, &["label_02/0000.txt\", line 3: truncation \"x\" is not a number"]);
}

#[test]
fn a_label_line_that_ends_early() {
    let it = Spoilt::drive();
    it.dataset.write("training/label_02/0000.txt", "0 0 Car 0 0\n");
    it.check_run(3, &["label_02/0000.txt\", line 1: ends before its alpha"]);
}

#[test]
fn a_missing_calibration() {
    let it = Spoilt::drive();
    it.dataset.remove("training/calib/0000.txt");
    it.check_run(3, &["calib/0000.txt\" of", "velodyne/0000\" does not exist"]);
}

#[test]
fn a_calibration_without_projection() {
    let it = Spoilt::drive();
    it.dataset.write("training/calib/0000.txt", "R_rect 1 0 0 0 1 0 0 0 1\n");
    it.check_run(3, &["calib/0000.txt\" has no line P2"]);
}

#[test]
fn an_unknown_format() {
    let it = Spoilt::drive();
    let parts = ["unknown format \"kity\"", "kitti-tracking, kitti-object"];
    it.check("run street --format kity -o out", 2, &parts);
}

#[test]
fn a_format_for_what_is_simulated() {
    let it = Spoilt::drive();
    let parts = ["\"street-narrow\" is simulated, so it cannot be read as kitti-object"];
    it.check("run street-narrow --format kitti-object -o out", 2, &parts);
}

#[test]
fn a_folder_that_is_no_data_set() {
    let it = Spoilt::drive();
    std::fs::create_dir(it.workplace.path("empty")).expect("a fresh folder");
    it.check("run empty -o out", 2, &["\"empty\" has no data set in a known format"]);
}

#[test]
fn an_unknown_data_set() {
    let it = Spoilt::drive();
    it.check(
        "run nowhere -o out",
        2,
        &["there is no data set \"nowhere\": it is neither in the catalogue", "kitti-tracking"],
    );
    it.check("run no/where -o out", 3, &["cannot read \"no/where\": No such file"]);
    // The last of several costs nothing either.
    it.check("run street nowhere -o out", 2, &["there is no data set \"nowhere\""]);
}

#[test]
fn a_catalogued_data_set_that_is_not_there() {
    let it = Spoilt::drive();
    let mut command = it.workplace.command(&["run", "kitti-tracking", "-o", "out"]);
    let ended = Ended::from(command.env("KITTI_TRACKING_ROOT", "gone").output().expect("it starts"));
    check_refusal(&ended, 3, &["\"kitti-tracking\" is not at \"gone\"", "set KITTI_TRACKING_ROOT"]);
}

#[test]
fn an_official_split_that_is_not_there() {
    let it = Spoilt::drive();
    std::fs::create_dir_all(it.workplace.path("objects/training/label_2")).unwrap();
    std::fs::create_dir_all(it.workplace.path("scenes")).unwrap();
    let refused = |name: &str, variable: &str, root: &str, parts: &[&str]| {
        let mut command = it.workplace.command(&["run", name, "-o", "out"]);
        let ended = Ended::from(command.env(variable, root).output().expect("it starts"));
        check_refusal(&ended, 3, parts);
    };
    let list = ["\"objects/ImageSets/val.txt\"", "a line", "put the list there"];
    refused("kitti-object-val", "KITTI_OBJECT_ROOT", "objects", &list);
    let tables = ["\"nuscenes-val\" is not at \"scenes/v1.0-trainval\"", "set NUSCENES_ROOT"];
    refused("nuscenes-val", "NUSCENES_ROOT", "scenes", &tables);
    let logs = ["\"argoverse2-val\" is not at \"gone/sensor/val\"", "set ARGOVERSE2_ROOT"];
    refused("argoverse2-val", "ARGOVERSE2_ROOT", "gone", &logs);
}

#[test]
fn two_data_sets_of_the_same_name() {
    let it = Spoilt::drive();
    it.check("run street ./street -o out", 2, &["two data sets are called \"street\""]);
}

#[test]
fn a_seed_for_what_is_not_simulated() {
    let it = Spoilt::drive();
    it.check("run street --seed 7 -o out", 2, &["--seed is only for simulated data sets"]);
}

#[test]
fn an_unknown_detector() {
    let it = Spoilt::drive();
    let parts = [
        "there is no detector \"kdtree\"",
        "detectors are hierarchical, kd-tree-trained, kd-tree-tree, paper, kd-tree-same-walls, kd-tree, pca",
    ];
    it.check("run street -d pca,kdtree -o out", 2, &parts);
}

#[test]
fn a_detector_named_twice() {
    let it = Spoilt::drive();
    it.check("run street -d pca,kd-tree,pca -o out", 2, &["the detector \"pca\" is given twice"]);
}

#[test]
fn a_selection_that_is_none() {
    let it = Spoilt::drive();
    it.check(
        "run street --scans 1..x -o out",
        2,
        &["scan selection \"1..x\": \"x\" is not the number of a scan"],
    );
    it.check("run street --scans 2..1 -o out", 2, &["scan selection \"2..1\": the range 2..1 is empty"]);
}

#[test]
fn a_selection_beyond_the_last_scan() {
    let it = Spoilt::drive();
    it.check(
        "run street --scans 3 -o out",
        2,
        &["scan selection \"3\": there is no scan 3: the data set has 3"],
    );
}

/// Runs with a configuration of these lines.
#[track_caller]
fn check_config(lines: &str, parts: &[&str]) {
    let it = Spoilt::drive();
    it.workplace.write("mine.toml", lines);
    it.check("run street -c mine.toml -o out", 2, parts);
}

#[test]
fn a_configuration_with_an_unknown_key() {
    check_config(
        "# mine\n[hierarchical.grid]\ncel_size_m = 0.5\n",
        &[
            "\"mine.toml\", line 3: unknown parameter hierarchical.grid.cel_size_m; parameters are cell_size_m, ",
        ],
    );
}

#[test]
fn a_configuration_with_a_value_of_the_wrong_type() {
    check_config(
        "kd_tree.tolerance_m = \"far\"\n",
        &["\"mine.toml\", line 1: kd_tree.tolerance_m is of type string, but must be float"],
    );
    check_config(
        "[hierarchical.grid]\nxi = -3\n",
        &["\"mine.toml\", line 2: hierarchical.grid.xi: invalid value: integer `-3`, expected u32"],
    );
}

#[test]
fn a_configuration_with_a_value_out_of_range() {
    check_config(
        "[matching]\n\nmin_iou = 1.5\n",
        &["\"mine.toml\", line 3: matching.min_iou = 1.5 is not within 0.01 to 1"],
    );
}

#[test]
fn a_configuration_that_is_not_toml() {
    check_config("[kd_tree\n", &["\"mine.toml\", line 1: unclosed table"]);
}

#[test]
fn a_parameter_of_another_name_type_or_range() {
    let it = Spoilt::drive();
    for (arguments, parts) in [
        (
            "run street -P tolerence_m=1 -o out",
            ["-P tolerence_m=1: unknown", "did you mean kd_tree.tolerance_m?"],
        ),
        (
            "run street -P cell_size_m=1 -o out",
            ["is ambiguous; write one of hierarchical.grid.cell_size_m, ", "pca.grid.cell_size_m"],
        ),
        (
            "run street -P tolerance_m=far -o out",
            ["-P tolerance_m=far: kd_tree.tolerance_m is", "but must be float"],
        ),
        ("run street -P hierarchical.grid.xi=9 -o out", ["hierarchical.grid.xi = 9", "is not within 1 to 8"]),
        (
            "run street -P hierarchical.terrain.low_quantile=1.1 -o out",
            ["hierarchical.terrain.low_quantile = 1.1 is", "not within 0 to 1"],
        ),
        ("ablation street -P xi=9 -o out", ["-P xi=9: hierarchical.grid.xi = 9", "is not within 1 to 8"]),
    ] {
        it.check(arguments, 2, &parts);
    }
}

#[test]
fn a_configuration_that_is_not_there() {
    let it = Spoilt::drive();
    let parts = ["cannot read the configuration \"gone.toml\": No such file"];
    it.check("run street -c gone.toml -o out", 2, &parts);
}

#[test]
fn a_catalogue_that_cannot_be_used() {
    let it = Spoilt::drive();
    it.check("data list --catalogue gone.toml", 2, &["cannot read \"gone.toml\": No such file"]);
    it.workplace.write("mine.toml", "\n[lidar.a]\nformat = \"kitti-object\"\n");
    it.check("data list --catalogue mine.toml", 2, &["mine.toml, line 2: unknown field `lidar`"]);
}

#[test]
fn a_run_directory_that_exists() {
    let it = Spoilt::drive();
    it.workplace.succeed(&["run", "street", "-d", "pca", "-o", "out"]);
    let report = it.workplace.read("out/report.json");
    it.check("run street -d pca -o out", 2, &["\"out\" exists; ", "or replace it with --overwrite"]);
    assert_eq!(it.workplace.read("out/report.json"), report);
}

#[test]
fn what_is_no_run_is_not_overwritten() {
    let it = Spoilt::drive();
    it.check(
        "run street -d pca --overwrite -o street",
        2,
        &["\"street\" exists, but is not the directory of a run"],
    );
}

#[test]
fn an_output_that_cannot_be_written() {
    let it = Spoilt::drive();
    it.workplace.write("file", "");
    it.check("run street -o file/out", 2, &["cannot write \"file", "Not a directory"]);
    it.check("run street -o ..", 2, &["\"..\" does not end in the name of a run"]);
    let too_long = format!("run street -o {}", "x".repeat(300));
    it.check(&too_long, 2, &["cannot write \""]);
}

/// A shell that lets no file grow beyond a few kilobytes, as if the disk were full.
#[cfg(unix)]
#[track_caller]
fn check_full_disk(arguments: &str, parts: &[&str]) {
    let it = Spoilt::drive();
    let before = it.workplace.names();
    let script = format!("trap '' XFSZ; ulimit -f 1; exec {} {arguments}", env!("CARGO_BIN_EXE_scanbench"));
    let mut shell = std::process::Command::new("sh");
    let output = shell.args(["-c", &script]).current_dir(it.workplace.folder()).output();
    check_refusal(&Ended::from(output.expect("a shell")), 1, parts);
    assert_eq!(it.workplace.names(), before, "something is left behind");
}

#[cfg(unix)]
#[test]
fn a_disk_that_takes_no_run() {
    check_full_disk("run street -d pca -o out", &["cannot write \"out.unfinished/journal\": File too large"]);
    // What needs all scans at once is kept nowhere else.
    check_full_disk(
        "run street -d pca -o out --mcap",
        &["cannot write \"", ".out.unfinished-", "File too large"],
    );
}

#[test]
fn a_drive_without_an_annotation_that_counts() {
    let it = Spoilt::drive();
    it.dataset.write("training/label_02/0000.txt", "");
    it.check("selftest street", 4, &["\"street\" has no annotation that counts"]);
    it.check(
        "ablation street -o out",
        4,
        &["none of the 3 scans of \"street\" has an annotation that counts"],
    );
}

#[cfg(feature = "viewer")]
#[test]
fn the_address_of_a_viewer_that_is_none() {
    let it = Spoilt::drive();
    it.check("run street -o out --connect viewer", 2, &["\"viewer\" is not the address of a viewer"]);
}

#[cfg(feature = "viewer")]
#[test]
fn a_recording_where_none_can_be_written() {
    let it = Spoilt::drive();
    let parts = ["cannot create the recording \"gone/a.rrd\": No such file"];
    it.check("run street -o out --save-rrd=gone/a.rrd", 2, &parts);
    it.check("run street -o out --save-rrd=street", 2, &["cannot create the recording \"street\""]);
}

#[cfg(feature = "viewer")]
#[test]
fn a_damaged_scan_leaves_an_earlier_recording_alone() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    it.workplace.write("mine.rrd", "an earlier one");
    it.check("run street -o out --save-rrd=mine.rrd", 3, &["is damaged or cut off"]);
    assert_eq!(it.workplace.read("mine.rrd"), "an earlier one");
}
