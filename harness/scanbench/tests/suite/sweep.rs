//! `scanbench sweep`: every combination of values, ended and gone on with.

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

/// Some scans of a simulated street as seen by a small sensor.
const STREET: [&str; 6] = ["sweep", "street-narrow", "--simulated-scans", "3", "--sensor", "vlp-16"];
const CELLS: [&str; 2] = ["-P", "cell_size_m=0.4:0.8:0.2"];
/// What is the same whenever the sweep is.
const SAME_FILES: [&str; 5] = [
    "sweep.csv",
    "f_rate_street-narrow.svg",
    "fitness_street-narrow.svg",
    "cell_fitness.csv",
    "cell_fitness.md",
];

fn with<'a>(common: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    common.iter().chain(more).copied().collect()
}

/// The rows of a CSV file of the directory `out`, each as its cells, after the head.
fn rows(workplace: &Workplace, file: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = workplace.read(&format!("out/{file}"));
    let mut rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (rows.next().expect("a head"), rows.collect())
}

fn column<'a>(head: &[String], row: &'a [String], name: &str) -> &'a str {
    let column = head.iter().position(|it| it == name).unwrap_or_else(|| panic!("no {name} in {head:?}"));
    &row[column]
}

#[test]
fn a_sweep_leaves_rows_with_what_they_are_made_of() {
    let workplace = Workplace::new();
    let data = ["street-narrow", "street-intersection", "--simulated-scans", "2", "--sensor", "vlp-16"];
    let ended = workplace.succeed(&with(
        &with(&["sweep"], &data),
        &["-P", "cell_size_m=0.4:0.8:0.2", "-L", "xi=2,3", "--timed-scans", "1", "-o", "out"],
    ));
    assert!(ended.stderr.ends_with("--seed 9001\nSweep: out\nPage: out/report.html\n"), "{}", ended.stderr);
    assert!(
        ended.stdout.contains("street-narrow (simulated)") && ended.stdout.contains("knuth"),
        "{}",
        ended.stdout
    );
    let (head, rows_of_sweep) = rows(&workplace, "sweep.csv");
    // Six points, two data sets and both together, two tasks.
    assert_eq!(rows_of_sweep.len(), 6 * 3 * 2);
    for row in &rows_of_sweep {
        let number = |name: &str| {
            column(&head, row, name).parse::<f64>().unwrap_or_else(|_| panic!("{name} of {row:?}"))
        };
        assert_eq!(column(&head, row, "origin"), "simulated");
        let f_rate = 2.0 * number("tp") / (number("no") + number("nd"));
        assert!((number("f_rate") - f_rate).abs() < 1e-6, "{row:?}");
        assert!(number("f_rate_low") <= f_rate + 1e-6 && f_rate <= number("f_rate_high") + 1e-6, "{row:?}");
        let [d, s, e] = ["n_dense", "n_sparse", "n_empty"].map(number);
        assert!((number("fitness_printed") - d / (d + s - e)).abs() < 1e-6, "{row:?}");
        assert!((number("fitness_dense_share") - d / (d + s)).abs() < 1e-6, "{row:?}");
        let is_in_range = (0.0..=1.0).contains(&(d / (d + s - e)));
        let state = if is_in_range { "in range" } else { "out of range" };
        assert_eq!(column(&head, row, "fitness_printed_state"), state, "{row:?}");
        assert_eq!(number("fitness_cell_size_m"), number("hierarchical.grid.cell_size_m"));
    }
    let (head, timed) = rows(&workplace, "times.csv");
    assert_eq!(timed.len(), 6 * 3);
    assert!(timed.iter().all(|row| column(&head, row, "p50_ms").parse::<f64>().is_ok_and(|it| it > 0.0)));
    for extent in ["street-narrow", "street-intersection", "overall"] {
        for plot in ["f_rate", "fitness", "pareto"] {
            let svg = workplace.read(&format!("out/{plot}_{extent}.svg"));
            assert!(svg.contains("(simulated)") && svg.contains("</svg>"), "{plot} of {extent}");
        }
    }
    let manifest: serde_json::Value =
        serde_json::from_str(&workplace.read("out/manifest.json")).expect("a manifest");
    assert_eq!(manifest["sweep"]["points"].as_array().map(Vec::len), Some(6));
    assert_eq!(workplace.path("out/sweep.rrd").is_file(), cfg!(feature = "viewer"));
    assert_eq!(workplace.top_names(), ["out"]);
}

#[test]
fn a_point_is_what_run_runs() {
    let workplace = Workplace::new();
    let data = ["street-narrow", "--simulated-scans", "2", "-d", "hierarchical,pca"];
    workplace.succeed(&with(
        &with(&["sweep"], &data),
        &["-P", "hierarchical.grid.cell_size_m=0.6:0.8:0.2", "--timed-scans", "0", "-o", "out"],
    ));
    workplace
        .succeed(&with(&with(&["run"], &data), &["-P", "hierarchical.grid.cell_size_m=0.8", "-o", "run"]));
    let report = workplace.read("run/table_objects.csv");
    let (head, rows) = rows(&workplace, "sweep.csv");
    let swept = |detector: &str, size: &str| -> Vec<String> {
        let is_meant = |row: &&Vec<String>| {
            column(&head, row, "detector") == detector
                && column(&head, row, "hierarchical.grid.cell_size_m") == size
                && column(&head, row, "task") == "objects"
        };
        let row = rows.iter().find(is_meant).expect("a row");
        ["no", "tp", "mo", "fo"].map(|it| column(&head, row, it).to_owned()).to_vec()
    };
    for detector in ["hierarchical", "pca"] {
        let of_run = report.lines().find(|it| it.contains(&format!(",{detector},"))).expect("a line");
        let of_run: Vec<&str> = of_run.split(',').collect();
        assert!(
            of_run.windows(4).any(|it| it == swept(detector, "0.8")),
            "{report} {:?}",
            swept(detector, "0.8")
        );
    }
    assert_ne!(swept("hierarchical", "0.6"), swept("hierarchical", "0.8"));
    // Of another's grid nothing depends on this one.
    assert_eq!(swept("pca", "0.6"), swept("pca", "0.8"));
    assert!(!workplace.path("out/times.csv").exists());
}

/// Waits until the journal has this many lines.
#[track_caller]
fn wait_for_lines(journal: &Path, n_lines: usize) {
    let started = Instant::now();
    let has_lines = || std::fs::read_to_string(journal).is_ok_and(|it| it.lines().count() >= n_lines);
    while !has_lines() {
        assert!(started.elapsed() < Duration::from_mins(2), "no {n_lines} lines in {}", journal.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A sweep that takes a while, one result after the other.
fn start_long(workplace: &Workplace, data: &[&str], n_lines: usize) -> Child {
    let child =
        workplace.start(&with(data, &with(&CELLS, &["--jobs", "1", "--timed-scans", "1", "-o", "out"])));
    wait_for_lines(&workplace.path("out.unfinished/journal"), n_lines);
    child
}

const LONG: [&str; 6] = ["sweep", "street-narrow", "--simulated-scans", "8", "--protocol", "nuscenes"];

#[track_caller]
fn check_same_files(left: &Workplace, right: &Workplace) {
    let of_protocols = ["sweep_protocols.csv", "sweep_protocols.json", "protocol_nuscenes_street-narrow.svg"];
    for file in SAME_FILES.into_iter().chain(of_protocols) {
        let file = format!("out/{file}");
        assert!(left.read(&file) == right.read(&file), "{file} is not the same");
    }
}

#[test]
fn a_sweep_that_was_killed_goes_on_and_gives_the_same_bytes() {
    let (whole, broken) = (Workplace::new(), Workplace::new());
    let arguments = with(&LONG, &with(&CELLS, &["--timed-scans", "1", "-o", "out"]));
    whole.succeed(&arguments);
    let mut child = start_long(&broken, &LONG, 8);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert!(!broken.path("out").exists());
    let ended = broken.succeed(&arguments);
    let n_done = ended
        .stderr
        .split_once("\nContinuing with ")
        .and_then(|it| it.1.split(' ').next()?.parse::<usize>().ok());
    assert!(n_done.is_some_and(|it| (7..24).contains(&it)), "{}", ended.stderr);
    check_same_files(&whole, &broken);
    assert_eq!(broken.top_names(), ["out"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done_and_says_so() {
    let (whole, broken) = (Workplace::new(), Workplace::new());
    let arguments = with(&LONG, &with(&CELLS, &["--timed-scans", "1", "-o", "out"]));
    let child = start_long(&broken, &LONG, 5);
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|it| it.success()));
    let ended = Ended::from(child.wait_with_output().expect("it ends"));
    assert_eq!(ended.exit_code, Some(130), "{ended:?}");
    assert!(
        ended
            .stderr
            .contains("What is done of the 8 scans is kept in out.unfinished: to go on with the others"),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains("error: interrupted after ") && ended.stderr.contains(" of 24 results"));
    assert_eq!(broken.top_names(), ["out.unfinished"]);
    whole.succeed(&arguments);
    assert!(broken.succeed(&arguments).stderr.contains("\nContinuing with "));
    check_same_files(&whole, &broken);
}

#[test]
fn going_on_with_something_else_is_refused() {
    let workplace = Workplace::new();
    let mut child = start_long(&workplace, &LONG, 3);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    let journal = workplace.read("out.unfinished/journal");
    let common = ["--timed-scans", "1", "-o", "out"];
    let refused = |more: &[&str], difference: &str| {
        let ended = workplace.run(&with(&with(&LONG, &common), more));
        assert_eq!(ended.exit_code, Some(2), "{more:?}: {ended:?}");
        let says = format!("belongs to another sweep: {difference} differ;");
        assert!(ended.stderr.contains(&says), "{more:?}: {}", ended.stderr);
    };
    refused(&["-P", "cell_size_m=0.4:0.8:0.4"], "sweep.points, sweep.swept");
    refused(&with(&CELLS, &["--seed", "2"]), "datasets, seeds.street-narrow, shard.parts");
    refused(&with(&CELLS, &["--scans", "0..4"]), "datasets, shard.parts");
    let support = "config.hierarchical.walls.min_support, detectors";
    refused(&with(&CELLS, &["-P", "walls.min_support=0.7"]), support);
    refused(&with(&CELLS, &["-d", "simple-grid"]), "detectors");
    refused(&with(&CELLS, &["--protocol", "argoverse2"]), "protocols");
    refused(&with(&CELLS, &["--criterion", "centre"]), "config.matching.criterion, matching_criterion");
    assert_eq!(workplace.read("out.unfinished/journal"), journal);
    // Unless what is there is to go.
    let ended = workplace.succeed(&[
        "sweep",
        "street-narrow",
        "--simulated-scans",
        "1",
        "-L",
        "xi=2,3",
        "-o",
        "out",
        "--overwrite",
    ]);
    assert!(ended.stderr.ends_with("--seed 9001\nSweep: out\nPage: out/report.html\n"), "{}", ended.stderr);
    assert_eq!(workplace.top_names(), ["out"]);
}

#[test]
fn another_detector_of_scanbench_toml_is_none_of_its_business() {
    let workplace = Workplace::new();
    let table = |parameters: &str| format!("[detector.other]\ncommand = [\"true\"]\n{parameters}\n");
    workplace.write("scanbench.toml", &table("parameters = { b = 1 }"));
    let mut child = start_long(&workplace, &LONG, 3);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    workplace.write("scanbench.toml", &table("parameters = { b = 2, c = 3 }"));
    let went_on = workplace.run(&with(&with(&LONG, &CELLS), &["--timed-scans", "1", "-o", "out"]));
    assert!(went_on.stderr.contains("\nContinuing with "), "{}", went_on.stderr);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let (alone, together) = (Workplace::new(), Workplace::new());
    let arguments = with(&STREET, &with(&CELLS, &["--timed-scans", "0", "--protocol", "nuscenes"]));
    let arguments = with(&arguments, &["-o", "out", "--jobs"]);
    alone.succeed(&with(&arguments, &["1"]));
    together.succeed(&with(&arguments, &["5"]));
    check_same_files(&alone, &together);
}

#[track_caller]
fn check_refused(workplace: &Workplace, more: &[&str], exit_code: i32, message: &str) {
    let ended = workplace.run(&with(&["sweep"], more));
    assert_eq!(ended.exit_code, Some(exit_code), "{more:?}: {ended:?}");
    assert!(ended.stderr.contains(message), "{more:?}: {}", ended.stderr);
}

#[test]
fn sweeps_that_cannot_be_are_refused_with_their_codes() {
    let workplace = Workplace::new();
    check_refused(&workplace, &["street-narrow"], 2, "no parameter is swept");
    check_refused(
        &workplace,
        &["street-narrow", "-P", "cell_size_m=0.2:2.0"],
        2,
        "0.2:2.0 is not START:STOP:STEP",
    );
    check_refused(
        &workplace,
        &["street-narrow", "-P", "cel_size_m=0.2:2.0:0.1"],
        2,
        "unknown parameter cel_size_m",
    );
    check_refused(
        &workplace,
        &["street-narrow", "-P", "cell_size_m=0:2:1"],
        2,
        "cell_size_m = 0 is not within 0.05 to 10 m",
    );
    check_refused(
        &workplace,
        &["street-narrow", "-d", "pac", "-L", "xi=2,3"],
        2,
        "there is no detector \"pac\"",
    );
    check_refused(&workplace, &["./nowhere", "-L", "xi=2,3"], 3, "nowhere");
    assert!(workplace.names().is_empty(), "{:?}", workplace.names());
    workplace.write("full", "");
    check_refused(&workplace, &["street-narrow", "-L", "xi=2,3", "-o", "full"], 2, "with --overwrite");
    assert_eq!(workplace.top_names(), ["full"]);
}

#[test]
fn where_false_objects_are_unknown_recall_is_swept() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 2);
    workplace.succeed(&[
        "sweep",
        "street",
        "-P",
        "cell_size_m=0.6:0.8:0.2",
        "--timed-scans",
        "0",
        "-o",
        "out",
    ]);
    let (head, rows) = rows(&workplace, "sweep.csv");
    for row in rows.iter().filter(|it| column(&head, it, "task") == "objects") {
        let cells = ["fo", "nd", "f_rate", "f_rate_low"].map(|it| column(&head, row, it));
        assert_eq!(cells, [""; 4], "{row:?}");
        assert!(!column(&head, row, "recall").is_empty(), "{row:?}");
    }
    assert!(workplace.read("out/f_rate_street.svg").contains("recall (%)"));
}
