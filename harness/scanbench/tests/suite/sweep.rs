//! `scanbench sweep`: every combination of values, ended and gone on with.

use std::process::Child;

use crate::program::{Ended, Row, Workplace, send};

/// Some scans of a simulated street as seen by a small sensor.
const STREET: &str = "sweep street-narrow --simulated-scans 3 --sensor vlp-16";
const CELLS: &str = "-P cell_size_m=0.4:0.8:0.2";
/// What is the same whenever the sweep is.
const SAME_FILES: [&str; 5] = [
    "sweep.csv",
    "f_rate_street-narrow.svg",
    "fitness_street-narrow.svg",
    "cell_fitness.csv",
    "cell_fitness.md",
];

#[test]
fn a_sweep_leaves_rows_with_what_they_are_made_of() {
    let workplace = Workplace::new();
    let sweep = "sweep street-narrow street-intersection --simulated-scans 2 --sensor vlp-16";
    let ended = workplace.succeed(&(sweep, CELLS, "-L xi=2,3 --timed-scans 1 -o out"));
    assert!(ended.stderr.ends_with("--seed 9001\nSweep: out\nPage: out/report.html\n"), "{}", ended.stderr);
    ended.check_stdout(&["street-narrow (simulated)", "knuth"]);
    let rows = workplace.table("out/sweep.csv");
    // Six points, two data sets and both together, two tasks.
    assert_eq!(rows.len(), 6 * 3 * 2);
    for row in &rows {
        let number = |name: &str| row[name].parse::<f64>().unwrap_or_else(|_| panic!("{name} of {row:?}"));
        assert_eq!(row["origin"], "simulated");
        let f_rate = 2.0 * number("tp") / (number("no") + number("nd"));
        assert!((number("f_rate") - f_rate).abs() < 1e-6, "{row:?}");
        assert!(number("f_rate_low") <= f_rate + 1e-6 && f_rate <= number("f_rate_high") + 1e-6, "{row:?}");
        let [d, s, e] = ["n_dense", "n_sparse", "n_empty"].map(number);
        assert!((number("fitness_printed") - d / (d + s - e)).abs() < 1e-6, "{row:?}");
        assert!((number("fitness_dense_share") - d / (d + s)).abs() < 1e-6, "{row:?}");
        let is_in_range = (0.0..=1.0).contains(&(d / (d + s - e)));
        let state = if is_in_range { "in range" } else { "out of range" };
        assert_eq!(row["fitness_printed_state"], state, "{row:?}");
        assert_eq!(number("fitness_cell_size_m"), number("hierarchical.grid.cell_size_m"));
    }
    let timed = workplace.column("out/times.csv", "p50_ms");
    assert_eq!(timed.len(), 6 * 3);
    assert!(timed.iter().all(|it| it.parse::<f64>().is_ok_and(|it| it > 0.0)));
    for extent in ["street-narrow", "street-intersection", "overall"] {
        for plot in ["f_rate", "fitness", "pareto"] {
            workplace.check_file(&format!("out/{plot}_{extent}.svg"), &["(simulated)", "</svg>"]);
        }
    }
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["sweep"]["points"].as_array().map(Vec::len), Some(6));
    assert_eq!(workplace.path("out/sweep.rrd").is_file(), cfg!(feature = "viewer"));
    assert_eq!(workplace.top_names(), ["out"]);
}

#[test]
fn a_point_is_what_run_runs() {
    let workplace = Workplace::new();
    let data = "street-narrow --simulated-scans 2 -d hierarchical,pca -P";
    let sizes = "hierarchical.grid.cell_size_m=0.6:0.8:0.2 --timed-scans 0 -o out";
    workplace.succeed(&("sweep", data, sizes));
    workplace.succeed(&("run", data, "hierarchical.grid.cell_size_m=0.8 -o run"));
    let report = workplace.read("run/table_objects.csv");
    let rows = workplace.table("out/sweep.csv");
    let swept = |detector: &str, size: &str| -> Vec<String> {
        let is_meant = |row: &&Row| {
            row["detector"] == detector
                && row["hierarchical.grid.cell_size_m"] == size
                && row["task"] == "objects"
        };
        let row = rows.iter().find(is_meant).expect("a row");
        ["no", "tp", "mo", "fo"].map(|it| row[it].clone()).to_vec()
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

/// A sweep that takes a while, one result after the other.
const LONG: &str = "sweep street-narrow --simulated-scans 8 --protocol nuscenes";
const REST: &str = "--timed-scans 1 -o out";

/// Starts it, and returns once its journal has so many lines.
fn start_long(workplace: &Workplace, n_lines: usize) -> Child {
    let has_lines = |it: &Workplace| it.n_lines("out.unfinished/journal") >= n_lines;
    workplace.start_until(&(LONG, CELLS, REST, "--jobs 1"), has_lines)
}

/// Starts it, and ends it by force once its journal has so many lines.
fn kill_long(workplace: &Workplace, n_lines: usize) {
    let mut child = start_long(workplace, n_lines);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
}

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
    let arguments = (LONG, CELLS, REST);
    whole.succeed(&arguments);
    kill_long(&broken, 8);
    assert!(!broken.path("out").exists());
    let ended = broken.succeed(&arguments);
    let went_on = ended.stderr.split_once("\nContinuing with ");
    let n_done = went_on.and_then(|it| it.1.split(' ').next()?.parse::<usize>().ok());
    assert!(n_done.is_some_and(|it| (7..24).contains(&it)), "{}", ended.stderr);
    check_same_files(&whole, &broken);
    assert_eq!(broken.top_names(), ["out"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done_and_says_so() {
    let (whole, broken) = (Workplace::new(), Workplace::new());
    let arguments = (LONG, CELLS, REST);
    let child = start_long(&broken, 5);
    send(&child, "-INT");
    let ended = Ended::from(child.wait_with_output().expect("it ends"));
    assert_eq!(ended.exit_code, Some(130), "{ended:?}");
    let kept = "What is finished of the 8 scans is kept in out.unfinished; to continue";
    ended.check_stderr(&[kept, "error: interrupted after ", " of 24 results"]);
    assert_eq!(broken.top_names(), ["out.unfinished"]);
    whole.succeed(&arguments);
    broken.succeed(&arguments).check_stderr(&["\nContinuing with "]);
    check_same_files(&whole, &broken);
}

#[test]
fn going_on_with_something_else_is_refused() {
    let workplace = Workplace::new();
    kill_long(&workplace, 3);
    let journal = workplace.read("out.unfinished/journal");
    for (swept, more, difference) in [
        ("-P cell_size_m=0.4:0.8:0.4", "", "sweep.points, sweep.swept"),
        (CELLS, "--seed 2", "datasets, seeds.street-narrow, shard.parts"),
        (CELLS, "--scans 0..4", "datasets, shard.parts"),
        (CELLS, "-P walls.min_support=0.7", "config.hierarchical.walls.min_support, detectors"),
        (CELLS, "-d simple-grid", "detectors"),
        (CELLS, "--protocol argoverse2", "protocols"),
        (CELLS, "--criterion centre", "config.matching.criterion, matching_criterion"),
    ] {
        let says = format!("belongs to another sweep: {difference} differ;");
        workplace.end_with(&(LONG, REST, swept, more), 2, &[&says]);
    }
    assert_eq!(workplace.read("out.unfinished/journal"), journal);
    // Unless what is there is to go.
    let other = "sweep street-narrow --simulated-scans 1 -L xi=2,3 -o out --overwrite";
    let ended = workplace.succeed(other);
    assert!(ended.stderr.ends_with("--seed 9001\nSweep: out\nPage: out/report.html\n"), "{}", ended.stderr);
    assert_eq!(workplace.top_names(), ["out"]);
}

#[test]
fn another_detector_of_scanbench_toml_is_none_of_its_business() {
    let workplace = Workplace::new();
    let table = |parameters: &str| format!("[detector.other]\ncommand = [\"true\"]\n{parameters}\n");
    workplace.write("scanbench.toml", &table("parameters = { b = 1 }"));
    kill_long(&workplace, 3);
    workplace.write("scanbench.toml", &table("parameters = { b = 2, c = 3 }"));
    workplace.run(&(LONG, CELLS, REST)).check_stderr(&["\nContinuing with "]);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let (alone, together) = (Workplace::new(), Workplace::new());
    let rest = "--timed-scans 0 --protocol nuscenes -o out --jobs";
    alone.succeed(&(STREET, CELLS, rest, "1"));
    together.succeed(&(STREET, CELLS, rest, "5"));
    check_same_files(&alone, &together);
}

#[test]
fn sweeps_that_cannot_be_are_refused_with_their_codes() {
    let workplace = Workplace::new();
    for (arguments, exit_code, message) in [
        ("street-narrow", 2, "no parameter is swept"),
        ("street-narrow -P cell_size_m=0.2:2.0", 2, "0.2:2.0 is not START:STOP:STEP"),
        ("street-narrow -P cel_size_m=0.2:2.0:0.1", 2, "unknown parameter cel_size_m"),
        ("street-narrow -P cell_size_m=0:2:1", 2, "cell_size_m = 0 is not within 0.05 to 10 m"),
        ("street-narrow -d pac -L xi=2,3", 2, "there is no detector \"pac\""),
        ("./nowhere -L xi=2,3", 3, "nowhere"),
    ] {
        workplace.end_with(&("sweep", arguments), exit_code, &[message]);
    }
    assert!(workplace.names().is_empty(), "{:?}", workplace.names());
    workplace.write("full", "");
    workplace.end_with("sweep street-narrow -L xi=2,3 -o full", 2, &["with --overwrite"]);
    assert_eq!(workplace.top_names(), ["full"]);
}

#[test]
fn where_false_objects_are_unknown_recall_is_swept() {
    let workplace = Workplace::with_drive(2);
    workplace.succeed("sweep street -P cell_size_m=0.6:0.8:0.2 --timed-scans 0 -o out");
    for row in workplace.table("out/sweep.csv").iter().filter(|it| it["task"] == "objects") {
        let cells = ["fo", "nd", "f_rate", "f_rate_low"].map(|it| row[it].as_str());
        assert_eq!(cells, [""; 4], "{row:?}");
        assert!(!row["recall"].is_empty(), "{row:?}");
    }
    workplace.check_file("out/f_rate_street.svg", &["recall (%)"]);
}
