//! Comparing the scans of two data sets.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

const STATISTICS: [&str; 8] = [
    "returns_per_scan",
    "ground_share",
    "ring_density",
    "points_per_car",
    "points_per_track",
    "clusters_per_scan",
    "height_histogram",
    "cell_classes",
];

/// A workplace with the same drive of six scans in `a/street` and in `b/street`.
fn two_drives() -> (Workplace, [DrawnDataset; 2]) {
    let workplace = Workplace::new();
    let drives = ["a", "b"].map(|name| DrawnDataset::tracking(&workplace.path(name), 6));
    (workplace, drives)
}

/// Column `name` of the rows of `statistic` in `out/realism.csv`.
fn column(workplace: &Workplace, statistic: &str, name: &str) -> Vec<String> {
    let text = workplace.read("out/realism.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = reader.headers().unwrap().iter().position(|it| it == name).expect(name);
    let rows = reader.records().map(Result::unwrap).filter(|row| &row[0] == statistic);
    rows.map(|row| row[place].to_owned()).collect()
}

/// The ratios of `statistic` that are defined.
fn ratios(workplace: &Workplace, statistic: &str) -> Vec<String> {
    let mut ratios = column(workplace, statistic, "ratio");
    ratios.retain(|ratio| !ratio.is_empty());
    ratios
}

#[test]
fn a_drive_is_like_itself_in_every_bin() {
    let (workplace, _) = two_drives();
    let ended = workplace.succeed(&["data", "realism", "a/street", "--against", "b/street", "-o", "out"]);
    // It has two cars, and every car counts once.
    assert!(ratios(&workplace, "points_per_track").is_empty());
    assert!(ended.stdout.contains("too few: points_per_track"), "{ended:#?}");
    for statistic in STATISTICS.into_iter().filter(|it| *it != "points_per_track") {
        let ratios = ratios(&workplace, statistic);
        assert!(!ratios.is_empty(), "{statistic}");
        assert!(ratios.iter().all(|ratio| ratio == "1.0000"), "{statistic}: {ratios:?}");
        let row = ended.stdout.lines().find(|line| line.starts_with(statistic)).expect(statistic);
        assert!(row.contains(" 100.0 "), "{row}");
    }
    assert!(ended.stdout.starts_with("Left:  street, 6 scans\nRight: street, 6 scans\n"), "{ended:#?}");
    assert_eq!(ended.stderr, "Curves and plots: out\n");
}

#[test]
fn twice_the_points_are_twice_the_density_and_the_points_per_car() {
    let (workplace, [twice, _]) = two_drives();
    for scan in 0..6 {
        let name = format!("training/velodyne/0000/{scan:06}.bin");
        twice.change(&name, |bytes| bytes.extend(bytes.clone()));
    }
    workplace.succeed(&["data", "realism", "a/street", "--against", "b/street", "-o", "out"]);
    for statistic in ["returns_per_scan", "ring_density", "points_per_car"] {
        let ratios = ratios(&workplace, statistic);
        assert!(!ratios.is_empty(), "{statistic}");
        assert!(ratios.iter().all(|ratio| ratio == "2.0000"), "{statistic}: {ratios:?}");
    }
    assert_eq!(ratios(&workplace, "ground_share"), ["1.0000"; 3]);
}

#[test]
fn either_side_may_take_some_of_its_scans() {
    let (workplace, _) = two_drives();
    let ended = workplace.succeed(&[
        "data",
        "realism",
        "a/street",
        "--scans",
        "0..4",
        "--against",
        "b/street",
        "--against-scans",
        "1",
        "-o",
        "out",
    ]);
    assert!(ended.stdout.starts_with("Left:  street, 4 scans\nRight: street, 1 scans\n"), "{ended:#?}");
    assert_eq!(column(&workplace, "returns_per_scan", "n_left"), ["4"; 3]);
    assert_eq!(column(&workplace, "returns_per_scan", "n_right"), ["1"; 3]);
    // One scan has two cars.
    assert!(ratios(&workplace, "points_per_car").is_empty());
}

#[test]
fn a_plot_for_each_statistic_and_the_bins_of_all_are_left_behind() {
    let (workplace, _) = two_drives();
    workplace.succeed(&["data", "realism", "a/street", "--against", "b/street", "-o", "looks/out"]);
    let figures = STATISTICS.iter().flat_map(|it| [format!("{it}.pdf"), format!("{it}.svg")]);
    let mut expected: Vec<String> = figures.collect();
    expected.extend(["manifest.json", "realism.csv"].map(str::to_owned));
    expected.sort();
    let mut found: Vec<String> = std::fs::read_dir(workplace.path("looks/out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    found.sort();
    assert_eq!(found, expected);
    assert_eq!(workplace.top_names(), ["a", "b", "looks"]);
}

#[test]
fn what_is_simulated_is_labelled_so() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 2);
    let ended = workplace.succeed(&[
        "data",
        "realism",
        "street-main-road",
        "--seed",
        "7",
        "--scans",
        "0",
        "--against",
        "street",
        "-o",
        "out",
    ]);
    let label = "street-main-road (simulated, seed 7), 1 scans";
    assert!(ended.stdout.contains(&format!("Left:  {label}\n")), "{ended:#?}");
    for statistic in STATISTICS {
        assert!(column(&workplace, statistic, "left").iter().all(|left| left == label));
        assert!(workplace.read(&format!("out/{statistic}.svg")).contains(label));
    }
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    assert_eq!(manifest["left"]["datasets"][0]["simulated"], true);
    assert_eq!(manifest["left"]["seeds"]["street-main-road"], 7);
    assert_eq!(manifest["right"]["datasets"][0]["simulated"], false);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 3);
    let run_with = |n_threads: &str| {
        let mut command = workplace.command(&[
            "data",
            "realism",
            "street-main-road",
            "--scans",
            "0..3",
            "--against",
            "street",
            "-o",
            "out",
            "--overwrite",
        ]);
        let ended = Ended::from(command.env("RAYON_NUM_THREADS", n_threads).output().unwrap());
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        (workplace.read("out/realism.csv"), workplace.read("out/ring_density.svg"), ended.stdout)
    };
    assert!(run_with("1") == run_with("3"));
}

/// Runs with `arguments` after the verb; it ends with `exit_code`, says `part`, and leaves nothing.
#[track_caller]
fn check_refused(workplace: &Workplace, arguments: &[&str], exit_code: i32, part: &str) {
    let before = workplace.names();
    let ended = workplace.run(&[&["data", "realism"], arguments].concat());
    assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(exit_code), ""), "{ended:#?}");
    assert!(ended.stderr.contains(part), "{ended:#?}");
    assert_eq!(workplace.names(), before);
}

#[test]
fn what_cannot_be_compared_leaves_nothing() {
    let (workplace, [_, damaged]) = two_drives();
    let against = |name| ["a/street", "--against", name, "-o", "out"];
    check_refused(&workplace, &["a/street"], 2, "--against <DATASET>");
    check_refused(&workplace, &against("nowhere"), 2, "nowhere");
    check_refused(&workplace, &["a/street", "--against", "b/street", "-o", "a"], 2, "--overwrite");
    check_refused(&workplace, &["a/street", "--seed", "3", "--against", "b/street"], 2, "--seed");
    damaged.change("training/velodyne/0000/000003.bin", |bytes| bytes.truncate(100));
    check_refused(&workplace, &against("b/street"), 3, "000003.bin");
}

#[test]
fn an_earlier_comparison_is_overwritten_when_asked_for() {
    let (workplace, _) = two_drives();
    let arguments = ["data", "realism", "a/street", "--against", "b/street", "-o", "out"];
    workplace.succeed(&arguments);
    assert_eq!(workplace.run(&arguments).exit_code, Some(2));
    workplace.succeed(&[&arguments[..], &["--overwrite"]].concat());
    assert_eq!(workplace.top_names(), ["a", "b", "out"]);
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn real_scans_are_compared_with_simulated_ones() {
    let root = test_data("data/kitti_tracking");
    let root = root.to_str().expect("a readable path");
    let workplace = Workplace::new();
    workplace.succeed(&[
        "data",
        "realism",
        "--scans",
        "0..2",
        "--against",
        root,
        "--against-scans",
        "0..2",
        "-o",
        "out",
    ]);
    let ratios = ratios(&workplace, "ring_density");
    let n_alike = ratios.iter().filter(|ratio| (0.5..2.0).contains(&ratio.parse::<f64>().unwrap())).count();
    assert!(2 * n_alike > ratios.len(), "{ratios:?}");
}
