//! Comparing the scans of two data sets.

use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

const STATISTICS: [&str; 11] = [
    "returns_per_scan",
    "ground_share",
    "ring_density",
    "points_per_car",
    "points_on_sides",
    "rough_points",
    "points_per_track",
    "clusters_per_scan",
    "clusters_by_range",
    "height_histogram",
    "cell_classes",
];

/// What a drive of two small cars and of few clusters at any range has none of.
const OF_FEW: [&str; 4] = ["points_per_track", "points_on_sides", "rough_points", "clusters_by_range"];

/// A workplace with the same drive of six scans in `a/street` and in `b/street`.
fn two_drives() -> (Workplace, [DrawnDataset; 2]) {
    let workplace = Workplace::new();
    let drives = ["a", "b"].map(|name| DrawnDataset::tracking(&workplace.path(name), 6));
    (workplace, drives)
}

/// Column `name` of the rows of `statistic` in `out/realism.csv`.
fn column(workplace: &Workplace, statistic: &str, name: &str) -> Vec<String> {
    let rows = workplace.table("out/realism.csv").into_iter().filter(|it| it["statistic"] == statistic);
    rows.map(|mut it| it.remove(name).expect("a column")).collect()
}

/// The ratios of `statistic` that are defined.
fn ratios(workplace: &Workplace, statistic: &str) -> Vec<String> {
    let mut ratios = column(workplace, statistic, "ratio");
    ratios.retain(|ratio| !ratio.is_empty());
    ratios
}

#[test]
fn a_drive_is_like_itself_in_every_bin_and_each_statistic_has_a_plot() {
    let (workplace, _) = two_drives();
    let ended = workplace.succeed("data realism a/street --against b/street -o looks/out");
    std::fs::rename(workplace.path("looks/out"), workplace.path("out")).unwrap();
    // It has two cars, and every car counts once.
    assert!(ratios(&workplace, "points_per_track").is_empty());
    ended.check_stdout(&["too few: points_per_track"]);
    for statistic in STATISTICS.into_iter().filter(|it| !OF_FEW.contains(it)) {
        let ratios = ratios(&workplace, statistic);
        assert!(!ratios.is_empty(), "{statistic}");
        assert!(ratios.iter().all(|ratio| ratio == "1.0000"), "{statistic}: {ratios:?}");
        let row = ended.stdout.lines().find(|line| line.starts_with(statistic)).expect(statistic);
        assert!(row.contains(" 100.0 "), "{row}");
    }
    assert!(ended.stdout.starts_with("Left:  street, 6 scans\nRight: street, 6 scans\n"), "{ended:#?}");
    assert_eq!(ended.stderr, "Curves and plots: looks/out\n");
    let figures = STATISTICS.iter().flat_map(|it| [format!("{it}.pdf"), format!("{it}.svg")]);
    let mut expected: Vec<String> = figures.collect();
    expected.extend(["manifest.json", "realism.csv"].map(str::to_owned));
    expected.sort();
    let names = workplace.names().into_iter();
    let found = names.filter_map(|it| Some(it.strip_prefix("out").ok()?.to_str().unwrap().to_owned()));
    assert_eq!(found.filter(|it| !it.is_empty()).collect::<Vec<_>>(), expected);
}

#[test]
fn twice_the_points_are_twice_the_density_and_the_points_per_car() {
    let (workplace, [twice, _]) = two_drives();
    for scan in 0..6 {
        let name = format!("training/velodyne/0000/{scan:06}.bin");
        twice.change(&name, |bytes| bytes.extend(bytes.clone()));
    }
    workplace.succeed("data realism a/street --against b/street -o out");
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
    let ended =
        workplace.succeed("data realism a/street --scans 0..4 --against b/street --against-scans 1 -o out");
    assert!(ended.stdout.starts_with("Left:  street, 4 scans\nRight: street, 1 scans\n"), "{ended:#?}");
    assert_eq!(column(&workplace, "returns_per_scan", "n_left"), ["4"; 3]);
    assert_eq!(column(&workplace, "returns_per_scan", "n_right"), ["1"; 3]);
    // One scan has two cars.
    assert!(ratios(&workplace, "points_per_car").is_empty());
}

#[test]
fn what_is_simulated_is_labelled_so() {
    let workplace = Workplace::with_drive(2);
    let ended = workplace.succeed("data realism street-main-road --seed 7 --scans 0 --against street -o out");
    let label = "street-main-road (simulated, seed 7), 1 scans";
    ended.check_stdout(&[&format!("Left:  {label}\n")]);
    for statistic in STATISTICS {
        assert!(column(&workplace, statistic, "left").iter().all(|left| left == label));
        workplace.check_file(&format!("out/{statistic}.svg"), &[label]);
    }
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["left"]["datasets"][0]["simulated"], true);
    assert_eq!(manifest["left"]["seeds"]["street-main-road"], 7);
    assert_eq!(manifest["right"]["datasets"][0]["simulated"], false);
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn real_scans_are_compared_with_simulated_ones() {
    let root = test_data("data/kitti_tracking");
    let root = root.to_str().expect("a readable path");
    let workplace = Workplace::new();
    workplace.succeed(&("data realism --scans 0..2 --against", [root], "--against-scans 0..2 -o out"));
    let ratios = ratios(&workplace, "ring_density");
    let n_alike = ratios.iter().filter(|ratio| (0.5..2.0).contains(&ratio.parse::<f64>().unwrap())).count();
    assert!(2 * n_alike > ratios.len(), "{ratios:?}");
}
