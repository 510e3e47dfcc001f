//! `scanbench gaps` and `scanbench robustness`, from outside.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::program::Workplace;

/// The rows of the CSV file `name`, by column.
fn column(workplace: &Workplace, name: &str, column: &str) -> Vec<String> {
    let text = workplace.read(name);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = reader.headers().unwrap().iter().position(|it| it == column).expect(column);
    reader.records().map(|row| row.unwrap()[place].to_owned()).collect()
}

fn names_in(workplace: &Workplace, folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(workplace.path(folder)).unwrap();
    let mut names: Vec<String> = entries.map(|it| it.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn gaps_leave_curves_plots_and_a_pair_behind() {
    let workplace = Workplace::new();
    let arguments = ["gaps", "--pairs", "1", "-d", "simple-grid,hierarchical", "-o", "out"];
    let ended = workplace.succeed(&arguments);
    let names = names_in(&workplace, "out");
    let kinds = ["car-bin", "car-pedestrian", "car-sign", "cars", "pedestrians"];
    let mut expected: Vec<String> = kinds.iter().map(|kind| format!("gaps_{kind}.svg")).collect();
    expected.extend(["gaps.csv", "gaps.svg", "manifest.json", "report.html"].map(str::to_owned));
    assert!(expected.iter().all(|it| names.contains(it)), "{names:?}");
    // Two detectors, five kinds, two layouts, three ranges, eleven gaps.
    assert_eq!(column(&workplace, "out/gaps.csv", "n_pairs"), vec!["1"; 2 * 5 * 2 * 3 * 11]);
    assert!(column(&workplace, "out/gaps.csv", "data").iter().all(|it| it == "simulated"));
    assert!(
        ended.stdout.contains("Pairs at 5 to 10 m (simulated)") && ended.stdout.contains("Separated: each")
    );
    assert!(ended.stderr.ends_with("Curves and plots: out\n"), "{ended:#?}");
    assert!(workplace.read("out/gaps.svg").contains("(simulated"));
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    assert_eq!(
        (&manifest["datasets"][0]["simulated"], &manifest["seeds"]["pairs"]),
        (&true.into(), &1.into())
    );
    // Every scan of the pairs is one of a run.
    assert_eq!(column(&workplace, "out/scans.csv", "scan").len(), 5 * 2 * 11 * 2 * 2);
    let compared = workplace.succeed(&["compare", "out", "--detectors", "simple-grid,hierarchical"]);
    assert!(compared.stdout.contains("hierarchical − simple-grid"), "{compared:#?}");
    assert_eq!(workplace.run(&arguments).exit_code, Some(2), "it is there already");
}

#[test]
fn the_number_of_threads_changes_no_gap() {
    let run_with = |n_threads: &str| {
        let workplace = Workplace::new();
        let arguments = ["gaps", "--pairs", "1", "-d", "simple-grid", "--sensor", "vlp-16", "-o", "out"];
        let ended = workplace.command(&arguments).env("RAYON_NUM_THREADS", n_threads).output().unwrap();
        assert!(ended.status.success());
        (workplace.read("out/gaps.csv"), workplace.read("out/gaps.svg"), ended.stdout)
    };
    assert!(run_with("1") == run_with("3"));
}

#[test]
fn robustness_leaves_its_table_in_three_forms() {
    let workplace = Workplace::new();
    let ended =
        workplace.succeed(&["robustness", "--scans", "1", "-d", "hierarchical,simple-grid", "-o", "out"]);
    let names = names_in(&workplace, "out");
    for name in ["manifest.json", "robustness.csv", "robustness.md", "report.html", "scans.csv", "stages.csv"]
    {
        assert!(names.iter().any(|it| it == name), "{name}: {names:?}");
    }
    let conditions = column(&workplace, "out/robustness.csv", "condition");
    let f_rates = column(&workplace, "out/robustness.csv", "f_rate");
    assert!(conditions.len() >= 4 * 15 && f_rates.len() == conditions.len());
    for condition in ["10 % even", "25 cm", "3.0 m", "2.5 m", "vlp-16", "rain, 10 mm/h", "rolling"] {
        assert_eq!(conditions.iter().filter(|it| *it == condition).count(), 4, "{condition}");
        assert!(ended.stdout.contains(condition) && workplace.read("out/robustness.md").contains(condition));
    }
    assert!(ended.stdout.contains("(all simulated)"), "{ended:#?}");
    let density = |it: &str| format!("new sensor: {it}: density of the sensor {it} taken from the scans\n");
    let densities = ["xt32", "pandar64", "os0-128"].map(density).concat();
    assert_eq!(ended.stderr, format!("{densities}Tables: out\n"));

    // The rates are those of a run whose data sets are the conditions.
    let datasets = column(&workplace, "out/table_vehicles.csv", "dataset");
    assert!(datasets.iter().any(|it| it == "sensor: vlp-16"), "{datasets:?}");
    let lows = column(&workplace, "out/robustness.csv", "f_rate_low");
    assert!(lows.iter().any(|it| !it.is_empty()), "{lows:?}");
    let compared = workplace.succeed(&["compare", "out", "out"]);
    assert!(compared.stdout.contains("No result of a scan changed."), "{compared:#?}");
    let page = workplace.read("out/report.html");
    workplace.succeed(&["report", "out"]);
    assert_eq!(workplace.read("out/report.html"), page);
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    let drives = &manifest["experiment"][0]["drives"];
    assert_eq!((drives.as_array().unwrap().len(), &manifest["seeds"]["streets"]), (3, &1.into()));
}

/// Runs with `arguments`, which ends with wrong usage, says `part`, and leaves nothing.
#[track_caller]
fn check_refused(arguments: &str, part: &str) {
    let workplace = Workplace::new();
    let ended = workplace.run(&arguments.split(' ').collect::<Vec<_>>());
    assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(2), ""), "{ended:#?}");
    assert!(ended.stderr.contains(part), "{ended:#?}");
    assert!(workplace.names().is_empty());
}

#[test]
fn what_cannot_be_put_up_leaves_nothing() {
    check_refused("gaps --pairs 0", "0 is not in 1..=10000");
    check_refused("gaps -d nobody", "there is no detector \"nobody\"");
    check_refused("gaps --sensor hdl-65e", "hdl-64e-s2");
    check_refused("gaps -c nowhere.toml", "nowhere.toml");
    check_refused("robustness --scans 0", "0 is not in 1..=10000");
    check_refused("robustness -d pca,pca", "the detector \"pca\" is given twice");
}
