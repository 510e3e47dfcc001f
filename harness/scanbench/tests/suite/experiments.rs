//! `scanbench gaps` and `scanbench robustness`, from outside.

use crate::program::Workplace;
use crate::shard_folders::{check_same_but_times, check_study};

#[test]
fn gaps_leave_curves_plots_and_a_pair_behind() {
    let workplace = Workplace::new();
    let command = "gaps --pairs 1 -d simple-grid,hierarchical --sensor vlp-16 --no-rrd";
    let ended = check_study(&workplace, command, &[], |workplace, whole, again| {
        check_same_but_times(workplace, whole, again);
        for name in ["gaps.csv", "gaps.svg"] {
            let [one, other] = [whole, again].map(|it| workplace.read(&format!("{it}/{name}")));
            assert!(one == other, "{name}");
        }
    });
    for name in ["bin", "pedestrian", "sign"].map(|it| format!("gaps_car-{it}.svg")) {
        assert!(workplace.path("in-one").join(&name).is_file(), "{name}");
    }
    for name in ["gaps_cars.svg", "gaps_pedestrians.svg", "gaps.svg", "report.html"] {
        assert!(workplace.path("in-one").join(name).is_file(), "{name}");
    }
    // Two detectors, five kinds, two layouts, three ranges, eleven gaps.
    assert_eq!(workplace.column("in-one/gaps.csv", "n_pairs"), vec!["1"; 2 * 5 * 2 * 3 * 11]);
    assert!(workplace.column("in-one/gaps.csv", "data").iter().all(|it| it == "simulated"));
    ended.check_stderr(&["--no-rrd changes nothing: `gaps` never writes a Rerun recording\n"]);
    ended.check_stdout(&["Pairs at 5 to 10 m (simulated)", "Separated: each"]);
    assert!(ended.stderr.ends_with("Curves and plots: in-one\nPage: in-one/report.html\n"), "{ended:#?}");
    workplace.check_file("in-one/gaps.svg", &["(simulated"]);
    let manifest = workplace.json("in-one/manifest.json");
    let (simulated, seed) = (&manifest["datasets"][0]["simulated"], &manifest["seeds"]["pairs"]);
    assert_eq!((simulated, seed), (&true.into(), &1.into()));
    // Every scan of the pairs is one of a run.
    let rows = workplace.table("in-one/scans.csv");
    let of_tasks = rows.iter().filter(|it| ["objects", "vehicles"].contains(&it["task"].as_str()));
    assert_eq!(of_tasks.count(), 5 * 2 * 11 * 2 * 2);
    workplace
        .succeed("compare in-one --detectors simple-grid,hierarchical")
        .check_stdout(&["hierarchical − simple-grid"]);
}

/// Simulating all conditions takes long: it is done once, in two shards. That the whole is the same is tested with
/// `ablation`.
#[test]
fn robustness_in_shards_leaves_its_table_in_three_forms() {
    let workplace = Workplace::new();
    let densities = ["xt32", "pandar64", "os0-128"]
        .map(|it| format!("new sensor: {it}: density of the sensor {it} taken from the scans\n"));
    for shard in ["1/2", "2/2"] {
        let command = ("robustness --scans 1 -d simple-grid -o shards --shard", shard);
        let ended = workplace.succeed(&command);
        assert!(ended.stderr.starts_with(&densities.concat()), "{ended:#?}");
    }
    workplace.write("earlier/manifest.json", "{}");
    workplace.refuse("robustness -o earlier", 2, &["\"earlier\" exists", "--overwrite"]);
    let ended = workplace.succeed("merge shards -o out");
    assert_eq!(ended.stderr, "Tables: out\nPage: out/report.html\n");
    for name in ["robustness.md", "stages.csv"] {
        assert!(workplace.path("out").join(name).is_file(), "{name}");
    }
    let conditions = workplace.column("out/robustness.csv", "condition");
    let f_rates = workplace.column("out/robustness.csv", "f_rate");
    assert!(conditions.len() >= 2 * 15 && f_rates.len() == conditions.len());
    for condition in ["10 % even", "25 cm", "3.0 m", "2.5 m", "vlp-16", "rain, 10 mm/h", "rolling"] {
        assert_eq!(conditions.iter().filter(|it| *it == condition).count(), 2, "{condition}");
        ended.check_stdout(&[condition]);
        workplace.check_file("out/robustness.md", &[condition]);
    }
    ended.check_stdout(&["(all simulated)"]);
    // The rates are those of a run whose data sets are the conditions.
    let datasets = workplace.column("out/table_vehicles.csv", "dataset");
    assert!(datasets.iter().any(|it| it == "sensor: vlp-16"), "{datasets:?}");
    let lows = workplace.column("out/robustness.csv", "f_rate_low");
    assert!(lows.iter().any(|it| !it.is_empty()), "{lows:?}");
    workplace.succeed("compare out out").check_stdout(&["No result of a scan changed."]);
    let page = workplace.read("out/report.html");
    workplace.succeed("report out");
    assert_eq!(workplace.read("out/report.html"), page);
    let manifest = workplace.json("out/manifest.json");
    let drives = &manifest["experiment"][0]["drives"];
    assert_eq!(drives.as_array().map(Vec::len), Some(3));
    assert_eq!(manifest["seeds"]["streets"], 1);
}
