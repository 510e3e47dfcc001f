//! What a run leaves behind, whole or not at all, and the same every time.

use std::collections::BTreeMap;

use serde_json::Value;
use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

/// A workplace with a drive of `n_scans` scans.
fn drive(n_scans: u32) -> Workplace {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), n_scans);
    workplace
}

/// The rows of the report of `run`, without those that hold times.
fn untimed_rows(workplace: &Workplace, run: &str) -> Vec<Value> {
    let report: Value = serde_json::from_str(&workplace.read(&format!("{run}/report.json"))).expect("JSON");
    let rows = report["rows"].as_array().expect("rows").clone();
    let is_time = |row: &Value| {
        let metric = row["metric"].as_str().expect("a metric");
        ["fps_", "latency_", "stage_", "cpu_", "door_", "reference_ms", "time_over_reference"]
            .iter()
            .any(|prefix| metric.starts_with(prefix))
    };
    let (times, rest): (Vec<Value>, Vec<Value>) = rows.into_iter().partition(is_time);
    assert!(!times.is_empty() && !rest.is_empty());
    rest
}

#[track_caller]
fn check_same_numbers(workplace: &Workplace, runs: [&str; 2]) {
    let [first, second] = runs.map(|run| untimed_rows(workplace, run));
    assert_eq!(first, second);
    let [first, second] = runs.map(|run| workplace.read(&format!("{run}/matches.csv")));
    assert!(first.lines().count() > 10);
    assert_eq!(first, second);
}

#[test]
fn a_run_leaves_its_files_and_nothing_else() {
    let workplace = Workplace::new();
    // Without a vehicle that is found there is no curve.
    workplace.succeed(&["run", "street-narrow", "--scans", "0..2", "-o", "runs/first"]);
    let mut expected = vec![
        "figures",
        "figures/precision_recall.pdf",
        "figures/precision_recall.svg",
        "figures/range_objects.pdf",
        "figures/range_objects.svg",
        "figures/range_vehicles.pdf",
        "figures/range_vehicles.svg",
        "figures/stages.pdf",
        "figures/stages.svg",
        "figures/standing.pdf",
        "figures/standing.svg",
        "figures/times.pdf",
        "figures/times.svg",
        "manifest.json",
        "matches.csv",
        "precision_recall.csv",
        "report.html",
        "report.json",
        "scans.csv",
        "stages.csv",
        "table_objects.csv",
        "table_objects.md",
        "table_objects.tex",
        "table_stages.md",
        "table_times.md",
        "table_vehicles.csv",
        "table_vehicles.md",
        "table_vehicles.tex",
        "worst_points.json",
    ];
    if cfg!(feature = "viewer") {
        expected.push("run.rrd");
    }
    expected.sort_unstable();
    let names = workplace.names();
    let in_runs: Vec<String> = names
        .iter()
        .filter_map(|name| Some(name.strip_prefix("runs").ok()?.to_string_lossy().into_owned()))
        .filter(|name| !name.is_empty() && name != "first")
        .collect();
    let expected: Vec<String> = expected.into_iter().map(|name| format!("first/{name}")).collect();
    assert_eq!(in_runs, expected);
}

#[test]
fn recorded_and_simulated_data_sets_are_told_apart_and_published_rows_stand_beside_the_papers_method() {
    let workplace = drive(3);
    let run = |detectors: &str, output: &str| {
        let data = ["run", "street", "street-narrow", "--scans", "0..3", "--no-rrd"];
        workplace.succeed(&[&data[..], &["-d", detectors, "-o", output]].concat()).stdout
    };
    let with_paper = run("paper,hierarchical,pca", "with");
    for task in ["objects", "vehicles"] {
        for on in ["street (recorded)", "street-narrow (simulated)"] {
            let verdict = with_paper.split(&format!("Task {task} on {on}: ")).nth(1).unwrap_or_default();
            let verdict = verdict.split("\nTask ").next().unwrap_or_default();
            assert!(["paper", "hierarchical", "pca"].iter().all(|it| verdict.contains(it)), "{with_paper}");
        }
    }
    let report = workplace.read("with/report.json");
    assert!(!with_paper.contains("overall (") && report.contains("\"overall\": [\n  ]"), "{with_paper}");
    let rows = workplace.read("with/table_objects.csv");
    assert!(rows.contains("\nobjects,published,Budapest #1,recorded,paper,"), "{rows}");
    let stages = workplace.read("with/table_stages.md");
    assert!(stages.contains("| **paper** | whole |  | 43 |") && !stages.contains("undefined"), "{stages}");
    let without = run("hierarchical,pca", "without");
    assert!(
        !without.contains("published: ") && without.contains(": -d paper,hierarchical,kd-tree,pca."),
        "{without}"
    );
    assert!(!workplace.read("without/table_stages.md").contains("published"));
}

#[test]
fn a_run_without_a_name_is_found_as_the_latest() {
    let workplace = drive(1);
    let ended = workplace.succeed(&["run", "street", "-d", "pca"]);
    let named = ended.stderr.trim().strip_prefix("Run directory: ").expect("its name").to_owned();
    assert!(named.starts_with("runs/") && named.ends_with("Z-street"), "{named}");
    assert_eq!(workplace.read("runs/latest/report.json"), workplace.read(&format!("{named}/report.json")));
}

#[test]
fn runs_that_begin_in_the_same_second_have_names_of_their_own() {
    let workplace = drive(1);
    let children: Vec<_> =
        (0..4).map(|_| workplace.start(&["run", "street", "-d", "pca", "--no-rrd"])).collect();
    for child in children {
        let ended = Ended::from(child.wait_with_output().expect("it ends"));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        let named = ended.stderr.trim().strip_prefix("Run directory: ").expect("its name").to_owned();
        assert!(workplace.path(&named).join("report.json").is_file(), "{named}");
    }
    let in_runs = std::fs::read_dir(workplace.path("runs")).expect("runs");
    let mut names: Vec<_> = in_runs.map(|it| it.expect("an entry").file_name()).collect();
    names.sort();
    assert!(names.len() == 5 && names.contains(&"latest".into()), "{names:?}");
    let latest = std::fs::read_link(workplace.path("runs/latest")).expect("a link");
    assert!(names.contains(&latest.into_os_string()), "{names:?}");
}

#[test]
fn an_earlier_run_is_overwritten_when_asked_for() {
    let workplace = drive(2);
    workplace.succeed(&["run", "street", "-d", "pca", "-o", "out"]);
    workplace.succeed(&["run", "street", "-d", "hierarchical", "-o", "out", "--overwrite"]);
    assert!(untimed_rows(&workplace, "out").iter().all(|row| row["detector"] == "hierarchical"));
    assert_eq!(workplace.top_names(), ["out", "street"]);
}

#[test]
fn the_same_command_twice_gives_the_same_numbers() {
    let workplace = drive(3);
    workplace.succeed(&["run", "street", "-o", "first"]);
    workplace.succeed(&["run", "street", "-o", "second"]);
    check_same_numbers(&workplace, ["first", "second"]);
}

#[test]
fn the_number_of_jobs_changes_no_number() {
    let workplace = drive(5);
    workplace.succeed(&["run", "street", "-o", "one", "--jobs", "1"]);
    workplace.succeed(&["run", "street", "-o", "four", "--jobs", "4"]);
    check_same_numbers(&workplace, ["one", "four"]);
}

#[test]
fn a_simulated_street_hangs_on_its_seed_alone() {
    let workplace = Workplace::new();
    for (run, seed, jobs) in [("one", "7", "1"), ("three", "7", "3"), ("other", "8", "3")] {
        let arguments = ["run", "-d", "pca", "--scans", "0..9:4", "--seed", seed, "--jobs", jobs, "-o", run];
        let ended = workplace.succeed(&arguments);
        assert!(ended.stdout.contains("street-main-road (simulated)"), "{ended:#?}");
    }
    check_same_numbers(&workplace, ["one", "three"]);
    assert_ne!(workplace.read("one/matches.csv"), workplace.read("other/matches.csv"));
}

#[test]
fn the_order_of_the_detectors_only_reorders() {
    let workplace = drive(3);
    workplace.succeed(&["run", "street", "-d", "hierarchical,pca", "-o", "there"]);
    workplace.succeed(&["run", "street", "-d", "pca,hierarchical", "-o", "back"]);
    let [there, back] = ["there", "back"].map(|run| untimed_rows(&workplace, run));
    assert_eq!((&there[0]["detector"], &back[0]["detector"]), (&"hierarchical".into(), &"pca".into()));
    let sorted = |rows: Vec<Value>| {
        let mut lines: Vec<String> = rows.iter().map(Value::to_string).collect();
        lines.sort();
        lines
    };
    assert_eq!(sorted(there), sorted(back));
    let [there, back] = ["there", "back"].map(|run| {
        let text = workplace.read(&format!("{run}/matches.csv"));
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    });
    assert_eq!(there, back);
}

#[test]
fn a_scan_is_judged_the_same_whatever_was_before_it() {
    let workplace = drive(3);
    workplace.succeed(&["run", "street", "-o", "all", "--warmup", "0"]);
    workplace.succeed(&["run", "street", "-o", "last", "--scans", "2"]);
    let of_last_scan = |run: &str| {
        let text = workplace.read(&format!("{run}/matches.csv"));
        let lines = text.lines().filter(|line| line.starts_with("street,0000,2,"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(!of_last_scan("last").is_empty(), "{}", workplace.read("last/matches.csv"));
    assert_eq!(of_last_scan("all"), of_last_scan("last"));
}

#[test]
fn the_manifest_says_what_was_done() {
    let workplace = drive(2);
    workplace.write("mine.toml", "[matching]\nmin_iou = 0.7\n");
    let arguments =
        ["run", "street", "-d", "pca", "-c", "mine.toml", "--scans", "1", "--warmup", "5", "-o", "out"];
    workplace.succeed(&arguments);
    let manifest: Value = serde_json::from_str(&workplace.read("out/manifest.json")).expect("JSON");
    let argv = manifest["argv"].as_array().expect("a list");
    assert!(argv[1..].iter().eq(arguments.iter().copied()), "{argv:?}");
    assert_eq!(manifest["n_warmup_detections"], 5);
    assert_eq!(manifest["matching_criterion"], "points, IoU at least 0.7");
    assert_eq!(manifest["config"]["matching"]["min_iou"], 0.7);
    assert_eq!(manifest["datasets"][0]["n_scans"], 1);
    assert_eq!(manifest["datasets"][0]["selection"], "1");
    assert!(manifest["datasets"][0]["simulation"].is_null());
    assert_eq!(manifest["detectors"][0]["name"], "pca");
    assert_eq!(manifest["rerun_version"].is_null(), !cfg!(feature = "viewer"));
}

#[test]
fn the_manifest_says_what_was_simulated() {
    let workplace = Workplace::new();
    let options = "--seed 7 --simulated-scans 2 --sensor vlp-16 --scans 1 -d pca -o out";
    let arguments: Vec<&str> = ["run", "street-narrow-ahead"].into_iter().chain(options.split(' ')).collect();
    workplace.succeed(&arguments);
    let manifest: Value = serde_json::from_str(&workplace.read("out/manifest.json")).expect("JSON");
    assert_eq!(manifest["seeds"]["street-narrow-ahead"], 7);
    let simulation = serde_json::json!({
        "simulator_version": simulator::SIMULATOR_VERSION,
        "street": "street-narrow",
        "n_drive_scans": 2,
        "turns_per_scan": 200,
        "scans_per_drive": 2,
        "sensor": "vlp-16",
        "shutter": "instant",
        "rain_mm_per_h": null,
        "labeled_to_either_side_deg": 40.0,
    });
    assert_eq!(manifest["datasets"][0]["simulation"], simulation);
}

#[test]
fn a_criterion_on_the_command_line_is_the_one_that_counts() {
    let workplace = drive(2);
    workplace.succeed(&["run", "street", "-d", "pca", "--criterion", "centre", "-o", "out"]);
    let manifest: Value = serde_json::from_str(&workplace.read("out/manifest.json")).expect("JSON");
    assert_eq!(manifest["matching_criterion"], "centre, closer than 2 m");
    assert_eq!(manifest["config"]["matching"]["criterion"], "centre");
    let matches = workplace.read("out/matches.csv");
    assert!(matches.contains(",centre,") && !matches.contains(",points,"), "{matches}");
}

/// The report is what `matches.csv` adds up to: anyone can count again.
#[test]
fn the_rows_of_the_matches_add_up_to_the_report() {
    let workplace = drive(3);
    workplace.succeed(&["run", "street", "-d", "hierarchical", "-o", "out"]);
    let mut reader = csv::Reader::from_path(workplace.path("out/matches.csv")).expect("a table");
    let mut n_by_outcome: BTreeMap<(String, String), f64> = BTreeMap::new();
    for row in reader.deserialize() {
        let row: BTreeMap<String, String> = row.expect("a row");
        *n_by_outcome.entry((row["task"].clone(), row["outcome"].clone())).or_default() += 1.0;
    }
    for task in ["objects", "vehicles"] {
        let n =
            |outcome: &str| n_by_outcome.get(&(task.to_owned(), outcome.to_owned())).copied().unwrap_or(0.0);
        let value_of = |metric: &str| {
            let rows = untimed_rows(&workplace, "out");
            let row = rows.iter().find(|row| row["task"] == task && row["metric"] == metric);
            row.expect("a row")["value"].as_f64().expect("a number")
        };
        assert_eq!(value_of("tp"), n("matched"), "{n_by_outcome:?}");
        assert_eq!(value_of("mo"), n("missed"), "{n_by_outcome:?}");
        assert_eq!(value_of("no"), n("matched") + n("missed"), "{n_by_outcome:?}");
    }
}

#[cfg(feature = "viewer")]
#[test]
fn a_recording_goes_where_it_is_wanted() {
    let workplace = drive(1);
    workplace.succeed(&["run", "street", "-d", "pca", "-o", "none", "--no-rrd"]);
    assert!(!workplace.path("none/run.rrd").exists());
    workplace.succeed(&["run", "street", "-d", "pca", "-o", "here", "--save-rrd"]);
    assert!(workplace.path("here/run.rrd").is_file());
    workplace.succeed(&["run", "street", "-d", "pca", "-o", "there", "--save-rrd=mine.rrd"]);
    assert!(workplace.path("mine.rrd").is_file() && !workplace.path("there/run.rrd").exists());
    assert_eq!(workplace.top_names(), ["here", "mine.rrd", "none", "street", "there"]);
}

#[cfg(all(target_os = "linux", feature = "viewer"))]
#[test]
fn a_device_is_written_to_and_not_replaced() {
    let workplace = drive(1);
    workplace.succeed(&["run", "street", "-d", "pca", "-o", "out", "--save-rrd=/dev/null"]);
    assert!(!std::path::Path::new("/dev/null").is_file());
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn real_scans_give_the_same_numbers_twice() {
    let root = test_data("data/kitti_tracking");
    let root = root.to_str().expect("a readable path");
    let workplace = Workplace::new();
    for (run, jobs) in [("first", "1"), ("second", "3")] {
        let arguments =
            ["run", root, "-d", "hierarchical,pca", "--scans", "0..40:15", "--jobs", jobs, "-o", run];
        workplace.succeed(&arguments);
    }
    check_same_numbers(&workplace, ["first", "second"]);
}

#[cfg(unix)]
mod interrupted {
    use std::process::{Child, Command};
    use std::time::{Duration, Instant};

    use super::*;

    /// Starts a run over thousands of scans, and returns once some of them are written.
    fn started(workplace: &Workplace) -> Child {
        let dataset = DrawnDataset::tracking(workplace.folder(), 1);
        dataset.repeat_first_scan(4000);
        let child = workplace.start(&["run", "street", "-d", "hierarchical,pca", "-o", "out", "--jobs", "1"]);
        let started = Instant::now();
        while workplace.path("out.unfinished/journal").metadata().map_or(0, |it| it.len()) < 30_000 {
            assert!(started.elapsed() < Duration::from_mins(1), "the run does not get on");
            std::thread::sleep(Duration::from_millis(5));
        }
        child
    }

    fn send(child: &Child, signal: &str) {
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.expect("kill is everywhere").success());
    }

    #[track_caller]
    fn check_interrupted_by(signal: &str, exit_code: i32) {
        let workplace = Workplace::new();
        let child = started(&workplace);
        send(&child, signal);
        let ended = Ended::from(child.wait_with_output().expect("it ends"));
        assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(exit_code), ""), "{ended:#?}");
        let is_said = |it: &str| it.starts_with("error: interrupted after ") && it.contains(" of 4000 scans");
        assert!(ended.stderr.lines().any(is_said), "{ended:#?}");
        assert_eq!(workplace.top_names(), ["out.unfinished", "street"]);
    }

    #[test]
    fn a_directory_that_is_being_written_is_refused_at_once() {
        let workplace = Workplace::new();
        let child = started(&workplace);
        for more in [&[][..], &["--overwrite"]] {
            let asked = Instant::now();
            let ended = workplace.run(&[&["run", "street", "-d", "pca", "-o", "out"], more].concat());
            assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
            assert_eq!(
                ended.stderr,
                "error: another program is writing \"out\"; choose another name, or wait for it\n"
            );
            assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
        }
        send(&child, "-INT");
        let ended = Ended::from(child.wait_with_output().expect("it ends"));
        assert_eq!(ended.exit_code, Some(130), "{ended:#?}");
        assert_eq!(workplace.top_names(), ["out.unfinished", "street"]);
    }

    #[test]
    fn ctrl_c_leaves_what_is_done() {
        check_interrupted_by("-INT", 130);
    }

    #[test]
    fn a_request_to_end_leaves_what_is_done() {
        check_interrupted_by("-TERM", 143);
    }

    #[test]
    fn a_kill_leaves_no_run_and_another_run_has_to_say_that_it_may_go() {
        let workplace = Workplace::new();
        let child = started(&workplace);
        send(&child, "-KILL");
        let ended = Ended::from(child.wait_with_output().expect("it ends"));
        assert_eq!(ended.exit_code, None);
        let names = workplace.top_names();
        assert!(
            names.contains(&"out.unfinished".to_owned()) && !names.contains(&"out".to_owned()),
            "{names:?}"
        );
        let other = ["run", "street", "-d", "pca", "--scans", "0", "-o", "out"];
        let refused = workplace.run(&other);
        assert_eq!(refused.exit_code, Some(2), "{refused:#?}");
        assert!(refused.stderr.contains("start again with --overwrite"), "{refused:#?}");
        workplace.succeed(&[&other[..], &["--overwrite"]].concat());
        assert!(workplace.path("out/report.json").is_file());
        assert!(!workplace.path("out.unfinished").exists());
    }
}
