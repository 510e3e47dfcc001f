//! What is wrong with data, or with the disk, is said with file, position and values, with the exit code for its kind, and
//! leaves nothing behind.

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
fn damage_is_met_by_every_verb_unless_it_is_to_be_skipped_or_beyond_the_selected_scans() {
    let it = Spoilt::drive();
    it.dataset.write(SCAN, [1, 2, 3]);
    let damaged = "0000/000001.bin\" is damaged or cut off";
    let realism = "data realism street --against street -o out";
    for arguments in
        ["run street -o out --jobs 1", "run street -o out --jobs 2", "run street -o out --jobs 7", realism]
    {
        it.check(arguments, 3, &[damaged]);
    }
    for verb in [
        "selftest street",
        "data check street",
        // A sweep that was ended by damage is not gone on with, but begun again.
        "sweep street -L cell_size_m=0.5,0.6 -d hierarchical -o swept --overwrite",
        "data prelabel street --to kitti -o project",
    ] {
        it.workplace.end_with(verb, 3, &[damaged]);
        it.workplace.succeed(&(verb, "--skip-damaged"));
    }
    it.workplace.check_file("swept/manifest.json", &["0000/000001"]);
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
        ended.check_refusal(7, parts);
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
