//! What is wrong with data, configuration or usage is said with file, position and values, with the exit code for its
//! kind, and leaves nothing behind.

use std::fs;

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Words, Workplace};

const SCAN: &str = "training/velodyne/0000/000001.bin";
const LABELS: &str = "training/label_02/0000.txt";
const N_BYTES_PER_POINT: usize = 16;

/// A run over a whole data set.
const RUN: &str = "run street -d hierarchical -o out";

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

    /// Runs the program with `arguments`; expects `exit_code`, all `parts` in one message, and nothing left behind.
    #[track_caller]
    fn check(&self, arguments: &(impl Words + ?Sized), exit_code: i32, parts: &[&str]) {
        check_once(&self.workplace.refuse(arguments, exit_code, parts), parts);
    }
}

#[track_caller]
fn check_once(ended: &Ended, parts: &[&str]) {
    assert!(ended.stderr.starts_with("error: "), "{ended:#?}");
    for part in parts {
        assert_eq!(ended.stderr.matches(part).count(), 1, "{part:?} in {ended:#?}");
    }
}

/// What is done to a sound drive, and parts of the message of a run over it.
type Damage = (fn(&DrawnDataset), &'static [&'static str]);

/// The tests of `scans` have every kind of damage, in every layout; here damage ends a run.
#[test]
fn a_damaged_drive_is_refused() {
    let cases: [Damage; 4] = [
        (
            |it| it.change(SCAN, |bytes| bytes.truncate(100 * N_BYTES_PER_POINT + 7)),
            &["0000/000001.bin\" is damaged or cut off", "1607 bytes are not a multiple of the 16"],
        ),
        // It vanishes after it was listed.
        (
            |it| {
                it.remove(SCAN);
                fs::create_dir(it.path(SCAN)).expect("the scan is removed");
            },
            &["0000/000001.bin"],
        ),
        (
            |it| {
                let labels = fs::read_to_string(it.path(LABELS)).expect("labels");
                it.write(LABELS, labels.replacen("\n1 0 Car 0", "\n1 0 Car x", 1));
            },
            &["label_02/0000.txt\", line 3: truncation \"x\" is not a number"],
        ),
        (
            |it| it.remove("training/calib/0000.txt"),
            &["calib/0000.txt\" of", "velodyne/0000\" does not exist"],
        ),
    ];
    // It is the damage that is refused.
    Spoilt::drive().workplace.succeed(RUN);
    for (spoil, parts) in cases {
        let it = Spoilt::drive();
        spoil(&it.dataset);
        it.check(RUN, 3, parts);
    }
}

#[test]
fn damage_is_met_by_every_verb_with_any_number_of_jobs_but_not_beyond_the_selected_scans() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    let verbs = ["run street -o out --jobs 1", "run street -o out --jobs 2", "run street -o out --jobs 7"];
    for arguments in verbs.into_iter().chain(["selftest street"]) {
        it.check(arguments, 3, &["0000/000001.bin\" is damaged or cut off"]);
    }
    if cfg!(feature = "viewer") {
        it.workplace.write("mine.rrd", "an earlier one");
        it.check("run street -o out --save-rrd=mine.rrd", 3, &["is damaged or cut off"]);
        assert_eq!(it.workplace.read("mine.rrd"), "an earlier one");
    }
    it.workplace.succeed("run street -d pca -o out --scans 0,2");
}

#[test]
fn a_detection_on_a_damaged_scan() {
    let it = Spoilt::drive();
    let file = format!("street/{SCAN}");
    let check = |input: &str, parts: &[&str]| {
        it.check(&("detect", input, "-o clusters.csv --boxes boxes.csv"), 3, parts);
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
fn a_detection_on_what_is_no_scan_or_whose_results_have_no_output() {
    let it = Spoilt::drive();
    it.workplace.write("scan.xyz", "");
    fs::create_dir(it.workplace.path("folder.csv")).expect("a fresh folder");
    let file = format!("street/{SCAN}");
    for (arguments, part) in [
        ("scan.xyz", "cannot read \"scan.xyz\" as a scan: give a file that ends in .bin, .pcd"),
        ("nowhere --scan 1", "there is no data set \"nowhere\": it is neither in the catalogue"),
        ("street", "choose a scan of \"street\" with --scan: it has 3 scans from 0000/000000 to 0000/000002"),
        ("street --scan 3", "\"street\" has no scan \"3\": it has 3 scans"),
        ("streets --scan 3", "\"streets\" is a group of data sets; choose one of street-main-road, "),
        ("street --scan 1 --seed 3", "--seed is only for simulated data sets"),
        (&format!("{file} --scan 1"), "--scan is only for data sets"),
        (&format!("{file} --sensor vlp-17"), "there is no sensor \"vlp-17\""),
        ("street --scan 1 -o clusters.txt", "\"clusters.txt\" must end in .csv or .u32, or be -"),
        ("street --scan 1 --boxes boxes.u32", "\"boxes.u32\" must end in .csv, or be -"),
        ("street --scan 1 -o a.csv --boxes a.csv", "--output and --boxes must be different files"),
        ("street --scan 1 -o - --boxes -", "--output and --boxes must be different files"),
        ("street --scan 1 -o gone/a.csv", "cannot write \"gone/a.csv\": No such file"),
        ("street --scan 1 -o a.csv --boxes folder.csv", "cannot write \"folder.csv\""),
        ("street --scan 1 -o a.csv -d kdtree", "there is no detector \"kdtree\""),
    ] {
        it.check(&("detect", arguments), 2, &[part]);
    }
}

#[test]
fn a_run_that_cannot_be() {
    let it = Spoilt::drive();
    fs::create_dir(it.workplace.path("empty")).expect("a fresh folder");
    it.workplace.write("file", "");
    let too_long = format!("street -o {}", "x".repeat(300));
    let nowhere = "there is no data set \"nowhere\": it is neither in the catalogue";
    for (arguments, parts) in [
        ("street --format kity -o out", &["unknown format \"kity\"", "kitti-tracking, kitti-object"][..]),
        (
            "street-narrow --format kitti-object -o out",
            &["\"street-narrow\" is simulated, so it cannot be read as kitti-object"],
        ),
        ("empty -o out", &["\"empty\" has no data set in a known format"]),
        ("nowhere -o out", &[nowhere, "(`scanbench data list`)"]),
        // The last of several costs nothing either.
        ("street nowhere -o out", &["there is no data set \"nowhere\""]),
        ("street-narow -o out", &["there is no data set \"street-narow\"; did you mean \"street-narrow\"?"]),
        ("street ./street -o out", &["two data sets are called \"street\""]),
        ("street --seed 7 -o out", &["--seed is only for simulated data sets"]),
        (
            "street -d pca,kdtree -o out",
            &[
                "there is no detector \"kdtree\" (did you mean \"kd-tree\"?)",
                "no scanbench.toml defines others",
                "detectors are hierarchical, kd-tree-trained, kd-tree-tree, paper, kd-tree-same-walls, kd-tree, pca",
            ],
        ),
        ("street -d pca,kd-tree,pca -o out", &["the detector \"pca\" is given twice"]),
        ("street --scans 1..x -o out", &["scan selection \"1..x\": \"x\" is not the number of a scan"]),
        ("street --scans 3 -o out", &["scan selection \"3\": there is no scan 3: the data set has 3"]),
        ("street -c gone.toml -o out", &["cannot read the configuration \"gone.toml\": No such file"]),
        ("street -d pca --overwrite -o street", &["\"street\" exists, but is not the directory of a run"]),
        ("street -o file/out", &["cannot write \"file", "Not a directory"]),
        ("street -o ..", &["\"..\" does not end in the name of a run"]),
        (&too_long, &["cannot write \""]),
    ] {
        it.check(&("run", arguments), 2, parts);
    }
    it.check("run no/where -o out", 3, &["cannot read \"no/where\": No such file"]);
    it.workplace.succeed("run street -d pca -o out");
    let report = it.workplace.read("out/report.json");
    it.check("run street -d pca -o out", 2, &["\"out\" exists; ", "or replace it with --overwrite"]);
    assert_eq!(it.workplace.read("out/report.json"), report);
}

#[test]
fn a_catalogued_data_set_or_split_that_is_not_there() {
    let it = Spoilt::drive();
    fs::create_dir_all(it.workplace.path("objects/training/label_2")).expect("a fresh folder");
    fs::create_dir_all(it.workplace.path("scenes")).expect("a fresh folder");
    for (name, variable, root, parts) in [
        (
            "kitti-tracking",
            "KITTI_TRACKING_ROOT",
            "gone",
            &["\"kitti-tracking\" is not at \"gone\"", "set KITTI_TRACKING_ROOT"][..],
        ),
        (
            "kitti-object-val",
            "KITTI_OBJECT_ROOT",
            "objects",
            &["\"objects/ImageSets/val.txt\"", "a line", "put the list there"],
        ),
        (
            "nuscenes-val",
            "NUSCENES_ROOT",
            "scenes",
            &["\"nuscenes-val\" is not at \"scenes/v1.0-trainval\"", "set NUSCENES_ROOT"],
        ),
        (
            "argoverse2-val",
            "ARGOVERSE2_ROOT",
            "gone",
            &["\"argoverse2-val\" is not at \"gone/sensor/val\"", "set ARGOVERSE2_ROOT"],
        ),
    ] {
        let ended = it.workplace.run_with(&[(variable, root)], &("run", name, "-o out"));
        ended.check_refusal(3, parts);
        check_once(&ended, parts);
    }
    it.check("data list --catalogue gone.toml", 2, &["cannot read \"gone.toml\": No such file"]);
    it.workplace.write("mine.toml", "\n[lidar.a]\nformat = \"kitti-object\"\n");
    it.check("data list --catalogue mine.toml", 2, &["mine.toml, line 2: unknown field `lidar`"]);
}

/// The tests of the configuration and of `-P` have every mistake; here a mistake ends a run.
#[test]
fn a_parameter_of_another_name_type_or_range() {
    let it = Spoilt::drive();
    it.workplace.write("mine.toml", "# mine\n[hierarchical.grid]\ncel_size_m = 0.5\n");
    for (arguments, parts) in [
        (
            "run street -c mine.toml -o out",
            [
                "\"mine.toml\", line 3: unknown parameter hierarchical.grid.cel_size_m",
                "; parameters are cell_size_m, ",
            ],
        ),
        (
            "run street -P tolerence_m=1 -o out",
            ["-P tolerence_m=1: unknown", "did you mean kd_tree.tolerance_m?"],
        ),
        (
            "run street -P hierarchical.terrain.low_quantile=1.1 -o out",
            ["hierarchical.terrain.low_quantile = 1.1 is", "not within 0 to 1"],
        ),
        ("ablation street -P xi=9 -o out", ["-P xi=9: hierarchical.grid.xi = 9", "is not within 1 to 8"]),
    ] {
        it.check(arguments, 2, &parts);
    }
}

/// A shell that lets no file grow beyond a few kilobytes, as if the disk were full.
#[cfg(unix)]
#[test]
fn a_disk_that_takes_no_result() {
    let it = Spoilt::drive();
    let before = it.workplace.names();
    for (arguments, parts) in [
        ("detect street --scan 1 -o a.u32 --boxes b.csv", &["cannot write \"a.u32\""][..]),
        ("run street -d pca -o out", &["cannot write \"out.unfinished/journal\": File too large"]),
        // What needs all scans at once is kept nowhere else.
        ("run street -d pca -o out --mcap", &["cannot write \"", ".out.unfinished-", "File too large"]),
    ] {
        let script =
            format!("trap '' XFSZ; ulimit -f 1; exec {} {arguments}", env!("CARGO_BIN_EXE_scanbench"));
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &script]).current_dir(it.workplace.folder()).output();
        let ended = Ended::from(output.expect("a shell"));
        ended.check_refusal(1, parts);
        check_once(&ended, parts);
        assert_eq!(it.workplace.names(), before, "{arguments} leaves something behind");
    }
}

#[test]
fn a_drive_without_an_annotation_that_counts() {
    let it = Spoilt::drive();
    it.dataset.write(LABELS, "");
    it.check("selftest street", 4, &["\"street\" has no annotation that counts"]);
    let of_all = "none of the 3 scans of \"street\" has an annotation that counts";
    it.check("ablation street -o out", 4, &[of_all]);
}

#[cfg(feature = "viewer")]
#[test]
fn a_recording_or_a_viewer_that_cannot_be() {
    let it = Spoilt::drive();
    for (arguments, part) in [
        ("--connect viewer", "\"viewer\" is not the address of a viewer"),
        ("--save-rrd=gone/a.rrd", "cannot create the recording \"gone/a.rrd\": No such file"),
        ("--save-rrd=street", "cannot create the recording \"street\""),
    ] {
        it.check(&("run street -o out", arguments), 2, &[part]);
    }
}
