//! Learning the density of points over range.

use serde_json::json;
use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// A workplace with the drive `street` of three drawn scans.
fn drive() -> (Workplace, DrawnDataset) {
    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 3);
    (workplace, drawn)
}

/// The curve of the file `name`.
fn curve(workplace: &Workplace, name: &str) -> toml::Table {
    let file: toml::Table = workplace.read(name).parse().expect("it is TOML");
    file["hierarchical"]["density_weighting"]["curve"].as_table().expect("it is a table").clone()
}

#[test]
fn a_curve_says_what_it_was_learned_from_and_figures_hold_every_ring() {
    let (workplace, _drawn) = drive();
    let ended = workplace.succeed("fit-density street --scans 0..2 --figures figures");
    assert!(ended.stdout.starts_with("Sensor hdl-64e-s2, 2 scans\nDensest ring: "), "{ended:#?}");
    assert!(ended.stderr.starts_with("Density curve: density.toml\n"), "{ended:#?}");
    assert_eq!(workplace.top_names(), ["density.toml", "figures", "street"]);
    let curve = curve(&workplace, "density.toml");
    assert_eq!(curve["command"].as_str(), Some("scanbench fit-density street --scans 0..2"));
    assert_eq!(curve["datasets"].as_array(), Some(&vec!["street".into()]));
    assert_eq!(curve["seeds"].as_array(), Some(&vec![]));
    assert_eq!(curve["n_scans"].as_integer(), Some(2));
    // The road of the drawn scans lies forward, 16 points a square metre: less than half of the rings beyond 10 m.
    let rings = curve["ring_points_per_m2"].as_array().expect("an array");
    assert_eq!((rings.len(), rings[60].as_float()), (79, Some(0.0)));
    assert!(rings[30].as_float().is_some_and(|it| it > 0.1 && it < 8.0), "{rings:?}");
    for statistic in ["ring_density", "weight"] {
        let rows = workplace.column("figures/density.csv", "statistic");
        assert_eq!(rows.iter().filter(|it| *it == statistic).count(), 79, "{statistic}");
        let figure = format!("figures/{statistic}.svg");
        workplace.check_file(&figure, &["range (m)", "measured, street, 2 scans"]);
    }
    workplace.check_file("figures/ring_density.svg", &["(points/m²)"]);
}

#[test]
fn twice_the_points_are_twice_the_density_and_the_same_weight() {
    let (workplace, drawn) = drive();
    workplace.succeed("fit-density street -o once.toml");
    for scan in 0..3 {
        let name = format!("training/velodyne/0000/{scan:06}.bin");
        drawn.change(&name, |bytes| bytes.extend(bytes.clone()));
    }
    workplace.succeed("fit-density street -o twice.toml");
    let [once, twice] = ["once.toml", "twice.toml"].map(|it| curve(&workplace, it));
    let peak = |it: &toml::Table| it["peak_points_per_m2"].as_float().expect("a number");
    assert!((peak(&twice) / peak(&once) - 2.0).abs() < 1e-4);
    assert_eq!(once["command"], twice["command"]);
}

#[test]
fn a_run_takes_the_file() {
    let (workplace, _drawn) = drive();
    workplace.succeed("fit-density street");
    let run = ["run", "street", "-d", "hierarchical", "-o", "out", "-c", "density.toml"];
    workplace.succeed(&run);
    let manifest = workplace.json("out/manifest.json");
    let of_run = &manifest["config"]["hierarchical"]["density_weighting"]["curve"]["peak_points_per_m2"];
    assert_eq!(of_run.as_f64(), curve(&workplace, "density.toml")["peak_points_per_m2"].as_float());

    let damaged = workplace.read("density.toml").replace("version = 1", "version = 2");
    workplace.write("density.toml", &damaged);
    let ended = workplace.refuse(&(&run, "--overwrite"), 2, &[]);
    let said = "hierarchical.density_weighting.curve.version = 2 is not within what this program reads";
    ended.check_stderr(&[said]);
    let cut = damaged.split_once("coefficients").expect("it is there").0;
    workplace.write("density.toml", &format!("{cut}coefficients = [0.0, 1.0]\n"));
    workplace.refuse(&(&run, "--overwrite"), 2, &[]);
}

#[test]
fn a_simulated_curve_names_its_sensor_and_seed() {
    let workplace = Workplace::new();
    workplace.succeed("fit-density street-narrow --seed 7 --scans 0 --sensor vlp-16 -o one.toml");
    workplace.check_file("one.toml", &["\nsensor = \"vlp-16\"\n", "\nseeds = [7]\n"]);
}

#[test]
fn what_cannot_be_fitted_leaves_nothing() {
    let (workplace, drawn) = drive();
    let other =
        "street = \"street-narrow\"\nseed = 1\nn_scans = 1\nturns_per_scan = 1\nsensor = \"vlp-16\"\n";
    workplace.write("catalogue.toml", &format!("[simulated.other]\n{other}"));
    let several = "fit-density street other --catalogue catalogue.toml";
    workplace.refuse(several, 2, &["of several sensors (hdl-64e-s2, vlp-16)"]);
    drawn.change("training/velodyne/0000/000001.bin", |bytes| bytes.truncate(100));
    workplace.refuse("fit-density street --figures out", 3, &["000001.bin"]);
    for scan in 0..3 {
        let five_metres_ahead = [5.0_f32, 0.0, 0.0, 0.5].map(f32::to_le_bytes).concat();
        drawn.write(&format!("training/velodyne/0000/{scan:06}.bin"), five_metres_ahead.repeat(30));
    }
    workplace.refuse("fit-density street --figures out", 4, &["only 1 of 79 rings have 20 points"]);
}

#[test]
fn the_density_of_a_simulated_sensor_is_taken_from_its_scans_unless_a_curve_is_given() {
    let (workplace, _drawn) = drive();
    let text = include_str!("../../../simulator/src/sensors/vlp-16.toml");
    workplace.write("mine.toml", text);
    let drives = ["street-narrow", "--sensor", "mine.toml", "--scans", "0..2"];
    let detector = ["-d", "hierarchical", "-o", "out", "--overwrite"];
    let run = [&["run"], &drives[..], &detector].concat();
    let said = "street-narrow: density of the sensor mine.toml taken from the scans";
    let ended = workplace.succeed(&run);
    assert!(ended.stderr.contains(said) && !ended.stderr.contains("warning"), "{ended:#?}");
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["datasets"][0]["seen"]["taken"], json!(["density"]));
    let scan = ["--scan", "narrow-803595/000000", "-d", "hierarchical"];
    let detect = [&["detect"], &drives[..3], &scan].concat();
    workplace.succeed(&detect).check_stderr(&[said]);
    let ended = workplace.succeed(&("fit-density", &drives));
    assert!(!ended.stderr.contains("taken from the scans"), "{ended:#?}");
    let ended = workplace.succeed(&(&run, "-c density.toml"));
    assert!(!ended.stderr.contains("density of the sensor"), "{ended:#?}");
}

#[test]
fn training_takes_the_density_of_a_sensor_without_a_curve_from_its_scans() {
    let workplace = Workplace::new();
    let drives = ["train", "pca", "training-narrow", "--sensor", "xt32", "--scans", "0..81:40"];
    let ended = workplace.run(&drives);
    ended.check_stderr(&["training-narrow: density of the sensor xt32 taken from the scans"]);
}

#[test]
fn every_data_set_has_its_own_curve_whatever_runs_beside_it() {
    let workplace = Workplace::new();
    let results_of = |datasets: &[&str], output: &str| {
        let options = ["--sensor", "xt32", "--scans", "0", "-d", "hierarchical", "-o", output];
        workplace.succeed(&("run", datasets, &options));
        let rows = workplace.read(&format!("{output}/matches.csv"));
        rows.lines().filter(|it| it.starts_with("street-narrow")).map(str::to_owned).collect::<Vec<_>>()
    };
    let alone = results_of(&["street-narrow"], "alone");
    assert!(!alone.is_empty());
    assert_eq!(results_of(&["street-main-road", "street-narrow"], "together"), alone);
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn the_density_of_real_scans_is_near_the_shipped_one() {
    let root = test_data("data/kitti_tracking");
    let workplace = Workplace::new();
    let root = root.to_str().expect("a readable path");
    workplace.succeed(&["fit-density", root, "--scans", "0..4", "-o", "real.toml"]);
    let real = curve(&workplace, "real.toml");
    let shipped = detector::grid::density_curve::DensityCurve::shipped("hdl-64e-s2").expect("it is shipped");
    let real: detector::grid::density_curve::DensityCurve = real.try_into().expect("it is a curve");
    for range_m in [10.0, 20.0, 40.0] {
        let ratio = real.weight(range_m) / shipped.weight(range_m);
        assert!((1.0 / 3.0..3.0).contains(&ratio), "{ratio} at {range_m} m");
    }
}
