//! `scanbench sweep`: every combination of values, ended and gone on with.

use std::process::Child;

use crate::program::{Ended, Row, Workplace, send};
use crate::shard_folders::{check_in_shards, check_same_bytes, check_study, files_of, merge_whole};

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
    let data = "street-narrow --simulated-scans 3 --sensor vlp-16 -d hierarchical,pca -P";
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
const LONG: &str = "sweep street-narrow --simulated-scans 12 --sensor vlp-16 --protocol nuscenes";
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

#[cfg(unix)]
#[test]
fn a_sweep_that_was_ended_goes_on_with_itself_alone_and_any_number_of_threads_gives_the_same_bytes() {
    let (whole, broken) = (Workplace::new(), Workplace::new());
    let table = |parameters: &str| format!("[detector.other]\ncommand = [\"true\"]\n{parameters}\n");
    broken.write("scanbench.toml", &table("parameters = { b = 1 }"));
    kill_long(&broken, 5);
    assert!(!broken.path("out").exists());
    let journal = broken.read("out.unfinished/journal");
    for (swept, more, difference) in [
        ("-P cell_size_m=0.4:0.8:0.4", "", "sweep.points, sweep.swept"),
        (CELLS, "--seed 2", "datasets, seeds.street-narrow, shard.parts"),
        (CELLS, "--scans 0..4", "datasets, shard.parts"),
        (CELLS, "-P walls.min_support=0.7", "config.hierarchical.walls.min_support, detectors"),
        (CELLS, "-d simple-grid", "detectors"),
        (CELLS, "--protocol argoverse2", "protocols"),
        (
            CELLS,
            "--criterion centre",
            "config.matching.criterion, detectors, matching_criterion, scoring_version",
        ),
    ] {
        let says = format!("belongs to another sweep: {difference} differ;");
        broken.end_with(&(LONG, REST, swept, more), 2, &[&says]);
    }
    assert_eq!(broken.read("out.unfinished/journal"), journal);
    // Another detector of the file is none of its business.
    broken.write("scanbench.toml", &table("parameters = { b = 2, c = 3 }"));
    let child = start_long(&broken, journal.lines().count() + 3);
    send(&child, "-INT");
    let ended = Ended::from(child.wait_with_output().expect("it ends"));
    assert_eq!(ended.exit_code, Some(130), "{ended:?}");
    let kept = "What is finished of the 12 scans is kept in out.unfinished; to continue";
    ended.check_stderr(&["\nContinuing with ", kept, "error: interrupted after ", " of 36 results"]);
    let ended = broken.succeed(&(LONG, CELLS, REST, "--jobs 5"));
    let went_on = ended.stderr.split_once("\nContinuing with ");
    let n_done = went_on.and_then(|it| it.1.split(' ').next()?.parse::<usize>().ok());
    assert!(n_done.is_some_and(|it| (7..36).contains(&it)), "{}", ended.stderr);
    assert_eq!(broken.top_names(), ["out", "scanbench.toml"]);
    whole.succeed(&(LONG, CELLS, REST, "--jobs 1"));
    check_same_files(&whole, &broken);
}

/// Two streets of a few seconds, at two points, by two detectors.
const SHARED: &str = "sweep street-narrow street-main-road --simulated-scans 4 --sensor vlp-16 -d hierarchical,pca \
                      -P hierarchical.grid.cell_size_m=0.6:0.8:0.2 --no-rrd -q --timed-scans";

#[test]
fn a_sweep_in_shards_is_the_sweep_in_one_piece() {
    check_study(&Workplace::new(), &format!("{SHARED} 0"), &[1, 5], check_same_bytes);
    // Skipped scans, a selection, values that go with others.
    let tied =
        "0 -P hierarchical.cluster.min_points=12/hierarchical.grid.cell_size_m --scans 0..4:2 --skip-damaged";
    check_in_shards(&Workplace::new(), &(SHARED, tied), &[2], check_same_bytes);
}

#[test]
fn scans_of_a_sweep_are_timed_in_the_shards_that_have_them() {
    let workplace = Workplace::new();
    check_in_shards(&workplace, &(SHARED, "2"), &[3], |workplace, whole, merged| {
        for name in files_of(workplace, whole).union(&files_of(workplace, merged)) {
            let file = name.display().to_string();
            let hangs_on_times =
                ["times.csv", "sweep.md", "sweep.tex", "report.html"].contains(&file.as_str());
            if hangs_on_times || file.starts_with("pareto_") {
                for folder in [whole, merged] {
                    std::fs::remove_file(workplace.path(folder).join(name)).expect("both have it");
                }
            }
        }
        check_same_bytes(workplace, whole, merged);
    });
    let log = |index: u32| workplace.read(&format!("shards-3/shard-{index}-of-3/shard.log"));
    let n_timed = |index: u32| log(index).matches("{\"times\":{").count();
    assert_eq!((1..=3).map(n_timed).sum::<usize>(), 4);
    merge_whole(&workplace, "shards-3", "merged");
    // Two of each data set, and four of both, for two detectors at two points.
    assert_eq!(workplace.column("merged/times.csv", "n_scans"), [["2"; 4], ["2"; 4], ["4"; 4]].concat());
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

#[test]
fn sweeps_are_compared_and_gated_point_by_point() {
    let workplace = Workplace::new();
    let sweep = "sweep street-narrow --simulated-scans 12 --sensor vlp-16 -P hierarchical.grid.cell_size_m=0.6:0.8:0.2";
    let rest = "--timed-scans 0 --no-rrd -q";
    workplace.succeed(&(sweep, rest, "-o before"));
    workplace.succeed(&(sweep, rest, "-P walls.enabled=false -o after"));
    workplace.succeed(
        "run street-narrow --simulated-scans 12 --sensor vlp-16 -d hierarchical -P \
                       hierarchical.grid.cell_size_m=0.8 --no-rrd -q -o run",
    );
    let f_rate = |run: &str, detector: &str| {
        let report = workplace.json(&format!("{run}/report.json"));
        let rows = report["rows"].as_array().expect("rows").clone();
        let is_asked = |it: &serde_json::Value| {
            it["detector"] == detector
                && it["task"] == "objects"
                && it["slice"] == "all"
                && it["metric"] == "f_rate"
        };
        let row = rows.into_iter().find(is_asked).expect("a row");
        (row["value"].clone(), row["interval_95"].clone(), row["n"].clone())
    };
    let at = "hierarchical@cell_size_m=0.8";
    assert_eq!(f_rate("before", at), f_rate("run", "hierarchical"));
    let ended = workplace.end_with("gate after --baseline before", 100, &["FAILED: worse"]);
    ended.check_stdout(&["walls.enabled: true → false", at]);
    workplace.succeed("gate before --baseline before").check_stdout(&["PASSED"]);
    let pair = format!("compare before --detectors hierarchical@cell_size_m=0.6,{at}");
    workplace.succeed(&pair).check_stdout(&["on the same scans of one run"]);
    workplace.end_with("compare before run", 5, &["hierarchical@cell_size_m=0.6 is only in the earlier run"]);
}
