//! `scanbench gaps` and `scanbench robustness`, from outside.

use crate::program::Workplace;
use crate::shard_folders::check_study_in_shards;

#[test]
fn gaps_leave_curves_plots_and_a_pair_behind() {
    let workplace = Workplace::new();
    let arguments = "gaps --pairs 1 -d simple-grid,hierarchical --sensor vlp-16 -o out";
    let ended = workplace.succeed(arguments);
    for name in ["bin", "pedestrian", "sign"].map(|it| format!("gaps_car-{it}.svg")) {
        assert!(workplace.path("out").join(&name).is_file(), "{name}");
    }
    for name in ["gaps_cars.svg", "gaps_pedestrians.svg", "gaps.svg", "report.html"] {
        assert!(workplace.path("out").join(name).is_file(), "{name}");
    }
    // Two detectors, five kinds, two layouts, three ranges, eleven gaps.
    assert_eq!(workplace.column("out/gaps.csv", "n_pairs"), vec!["1"; 2 * 5 * 2 * 3 * 11]);
    assert!(workplace.column("out/gaps.csv", "data").iter().all(|it| it == "simulated"));
    ended.check_stdout(&["Pairs at 5 to 10 m (simulated)", "Separated: each"]);
    assert!(ended.stderr.ends_with("Curves and plots: out\nPage: out/report.html\n"), "{ended:#?}");
    workplace.check_file("out/gaps.svg", &["(simulated"]);
    let manifest = workplace.json("out/manifest.json");
    let (simulated, seed) = (&manifest["datasets"][0]["simulated"], &manifest["seeds"]["pairs"]);
    assert_eq!((simulated, seed), (&true.into(), &1.into()));
    // Every scan of the pairs is one of a run.
    assert_eq!(workplace.column("out/scans.csv", "scan").len(), 5 * 2 * 11 * 2 * 2);
    workplace
        .succeed("compare out --detectors simple-grid,hierarchical")
        .check_stdout(&["hierarchical − simple-grid"]);
    workplace.refuse(arguments, 2, &[]);
}

#[test]
fn robustness_leaves_its_table_in_three_forms_also_in_shards() {
    let workplace = Workplace::new();
    let ended = workplace.succeed("robustness --scans 1 -d simple-grid -o whole");
    for name in ["robustness.md", "stages.csv"] {
        assert!(workplace.path("whole").join(name).is_file(), "{name}");
    }
    let conditions = workplace.column("whole/robustness.csv", "condition");
    let f_rates = workplace.column("whole/robustness.csv", "f_rate");
    assert!(conditions.len() >= 2 * 15 && f_rates.len() == conditions.len());
    for condition in ["10 % even", "25 cm", "3.0 m", "2.5 m", "vlp-16", "rain, 10 mm/h", "rolling"] {
        assert_eq!(conditions.iter().filter(|it| *it == condition).count(), 2, "{condition}");
        assert!(
            ended.stdout.contains(condition) && workplace.read("whole/robustness.md").contains(condition)
        );
    }
    ended.check_stdout(&["(all simulated)"]);
    let density = |it: &str| format!("new sensor: {it}: density of the sensor {it} taken from the scans\n");
    let densities = ["xt32", "pandar64", "os0-128"].map(density).concat();
    assert_eq!(ended.stderr, format!("{densities}Tables: whole\nPage: whole/report.html\n"));

    // The rates are those of a run whose data sets are the conditions.
    let datasets = workplace.column("whole/table_vehicles.csv", "dataset");
    assert!(datasets.iter().any(|it| it == "sensor: vlp-16"), "{datasets:?}");
    let lows = workplace.column("whole/robustness.csv", "f_rate_low");
    assert!(lows.iter().any(|it| !it.is_empty()), "{lows:?}");
    workplace.succeed("compare whole whole").check_stdout(&["No result of a scan changed."]);
    let page = workplace.read("whole/report.html");
    workplace.succeed("report whole");
    assert_eq!(workplace.read("whole/report.html"), page);
    let manifest = workplace.json("whole/manifest.json");
    let drives = &manifest["experiment"][0]["drives"];
    assert_eq!((drives.as_array().unwrap().len(), &manifest["seeds"]["streets"]), (3, &1.into()));

    let command = ["robustness", "--scans", "1", "-d", "simple-grid", "-q"];
    check_study_in_shards(&workplace, &command, 2, "robustness.csv");
}

#[test]
fn what_cannot_be_put_up_leaves_nothing() {
    for (arguments, part) in [
        ("gaps --pairs 0", "0 is not in 1..=10000"),
        ("gaps -d nobody", "there is no detector \"nobody\""),
        ("gaps --sensor hdl-65e", "hdl-64e-s2"),
        ("gaps -c nowhere.toml", "nowhere.toml"),
        ("robustness --scans 0", "0 is not in 1..=10000"),
        ("robustness -d pca,pca", "the detector \"pca\" is given twice"),
    ] {
        Workplace::new().refuse(arguments, 2, &[part]);
    }
}
