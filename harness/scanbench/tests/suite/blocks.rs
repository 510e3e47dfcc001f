//! Which scans are drawn together where drives and times do not say so: KITTI's object benchmark, and `--blocks`.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write as _;

use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;
use crate::shard_folders::{check_same_but_times, make_shards, merge_whole};

const N_SCANS: u32 = 12;
const RUN: &str = "run street -d hierarchical,pca --no-rrd";

/// A workplace with twelve scans in the layout of the object benchmark.
fn objects() -> (Workplace, DrawnDataset) {
    let workplace = Workplace::new();
    let dataset = DrawnDataset::objects(workplace.folder(), N_SCANS);
    (workplace, dataset)
}

/// The kinds of blocks that the numbers of a run are drawn from, each with their number.
fn blocks(workplace: &Workplace, name: &str) -> Vec<String> {
    let table = workplace.read(&format!("{name}/table_vehicles.csv"));
    let of_row = |row: &str| {
        let cells: Vec<&str> = row.rsplitn(4, ',').collect();
        format!("{} {}, {}", cells[2], cells[1], cells[0])
    };
    let mut blocks: Vec<String> =
        table.lines().skip(1).filter(|it| it.contains(",measured,")).map(of_row).collect();
    blocks.dedup();
    blocks
}

#[test]
fn scans_picked_out_of_drives_have_no_times_and_decide_nothing() {
    let (workplace, _) = objects();
    let ended = workplace.succeed(&(RUN, "-o run"));
    assert_eq!(blocks(&workplace, "run"), ["12 scans without times, true"]);
    assert!(workplace.column("run/scans.csv", "time_s").iter().all(String::is_empty));
    ended.check_stdout(&["scans without known times, which may be neighbours, are not enough to show"]);
    assert!(!ended.stdout.contains(" leads with "), "{ended:#?}");
    for (file, part) in [
        ("table_vehicles.md", "¶ over scans that may be neighbours, because their times are not known"),
        ("table_vehicles.tex", "\\P{}"),
        ("report.json", "\"caveat\":\"interval over scans that may be neighbours\""),
        ("report.html", "over scans that may be neighbours"),
    ] {
        workplace.check_file(&format!("run/{file}"), &[part]);
    }
    workplace.succeed("data check street").check_stdout(&["12, no times known: they may be neighbours\n"]);
    // However large a loss is, it is not called sure.
    workplace.succeed(&(RUN, "-o worse -P hierarchical.cluster.min_points=5000"));
    let ended = workplace.run("gate worse -b run");
    // Nothing is found any more, so that some numbers are undefined.
    assert_eq!(ended.exit_code, Some(5), "{ended:#?}");
    ended.check_stdout(&[" 0 worse,"]);
    let said = ended.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("These scans may be neighbours, because their times are not known"), "{said}");
}

/// Scans 0 to 11 are scans of two drives, turn by turn, backwards; four to a second.
fn write_mapping(dataset: &DrawnDataset) {
    let (mut mapping, mut rand) = (String::new(), Vec::new());
    for line in 0..N_SCANS {
        let drive = line / 6;
        writeln!(mapping, "2011_09_26 2011_09_26_drive_{drive:04}_sync {:010}", 3 * (line % 6)).unwrap();
        rand.push((N_SCANS - line).to_string());
    }
    dataset.write("mapping/train_mapping.txt", mapping);
    dataset.write("mapping/train_rand.txt", rand.join(","));
}

#[test]
fn the_mapping_of_the_development_kit_has_drives_and_times() {
    let (workplace, dataset) = objects();
    workplace.succeed(&(RUN, "-o unmapped"));
    write_mapping(&dataset);
    workplace.succeed(&(RUN, "-o run"));
    assert_eq!(blocks(&workplace, "run"), ["4 seconds, true"]);
    // Names of scans stay; their order is that of drives and times.
    let column = |name: &str| {
        let mut cells = workplace.column("run/scans.csv", name);
        cells.dedup();
        cells
    };
    assert_eq!(column("scan"), ["11", "10", "9", "8", "7", "6", "5", "4", "3", "2", "1", "0"]);
    assert_eq!(column("time_s")[..6], ["0.000", "0.300", "0.600", "0.900", "1.200", "1.500"]);
    let manifest = workplace.json("run/manifest.json");
    let of_first = &manifest["datasets"][0]["blocks"]["2011_09_26_drive_0000_sync"];
    assert_eq!((&of_first[0], of_first.as_array().unwrap().len()), (&"training/000011".into(), 6));
    workplace.succeed("data check street").check_stdout(&["12 of 2 drives\n"]);
    make_shards(&workplace, RUN, 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    check_same_but_times(&workplace, "run", "merged");
    // Intervals of other blocks cannot be compared.
    workplace.refuse(
        "gate run -b unmapped",
        5,
        &["the blocks of scans of street that intervals are drawn from changed"],
    );
    // A scan that the mapping does not have is no scan of the benchmark.
    dataset.write("mapping/train_rand.txt", "1,2,3");
    workplace.refuse(
        &(RUN, "-o none"),
        3,
        &["train_rand.txt\", line 1: has 3 numbers, and none of scan 000003"],
    );
}

#[test]
fn a_file_names_the_blocks() {
    let (workplace, _) = objects();
    let file = |n_blocks: u32| {
        let lines = (0..N_SCANS).map(|scan| format!("training/{scan:06},place {}\n", scan % n_blocks));
        format!("scan,block\n{}", lines.collect::<String>())
    };
    workplace.write("three.csv", &file(3));
    workplace.write("ten.csv", &file(10));
    workplace.succeed(&(RUN, "--blocks three.csv -o three"));
    workplace.succeed(&(RUN, "--blocks ten.csv -o ten"));
    assert_eq!(blocks(&workplace, "three"), ["3 named blocks, true"]);
    assert_eq!(blocks(&workplace, "ten"), ["10 named blocks, false"]);
    workplace.check_file("ten/table_vehicles.md", &["resamples of the blocks of --blocks"]);
    // What is decided is decided again from the files.
    workplace.succeed("gate ten -b ten");
    workplace.refuse("gate ten -b three", 5, &[]);
    // Shards keep blocks whole, and have to be of the same.
    make_shards(&workplace, &(RUN, "--blocks three.csv"), 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    check_same_but_times(&workplace, "three", "merged");
    let parts = workplace.json("merged/manifest.json");
    let ends: Vec<_> = (0..3).map(|it| parts["shards"][it]["parts"][0]["end"].as_u64().unwrap()).collect();
    assert_eq!(ends, [4, 8, 12]);
    for (verb, more) in [("ablation", ""), ("sweep", "-d pca -P pca.cluster.min_points=20:30:10")] {
        workplace.succeed(&(verb, "street --blocks ten.csv -q -o", verb, more));
    }
    workplace.check_file("sweep/sweep.csv", &[",named blocks,"]);
    // What is missing or there twice is refused.
    for (content, expected) in [
        (
            file(3).replace("training/000007,place 1\n", ""),
            "blocks.csv\" has no block for scan training/000007",
        ),
        (file(3) + "7,place 2\n", "blocks.csv\", line 14: scan training/000007 is in line 9 already"),
        (file(3).replace("scan,block", "scan,place"), "expected"),
    ] {
        workplace.write("blocks.csv", &content);
        workplace.refuse(&(RUN, "--blocks blocks.csv -o none"), 2, &[expected]);
    }
    workplace.refuse(
        "run street street-narrow --blocks three.csv",
        2,
        &["--blocks is about the scans of one data set, and 2 are given"],
    );
}

#[test]
#[ignore = "needs data/kitti_object in SCANBENCH_TEST_DATA"]
fn recorded_objects_decide_nothing() {
    let root = test_data("data/kitti_object");
    let workplace = Workplace::new();
    let root = root.to_str().unwrap();
    workplace.succeed(&["boxes", root, "-o", "boxes"]).check_stdout(&["¶ over scans that may be neighbours"]);
    workplace.succeed(&("run", [root], "-d pca --protocol kitti-object --no-rrd -q -o run"));
    workplace.check_file("run/table_protocol_kitti-object.md", &["¶ over scans that may be neighbours"]);
}
