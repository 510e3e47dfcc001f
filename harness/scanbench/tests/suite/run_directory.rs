//! What a run leaves behind, whole or not at all, and the same every time.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};
use crate::shard_folders::{
    check_in_shards, check_same_but_times, check_same_bytes, check_study, untimed_rows,
};

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
    workplace.succeed("run street-narrow --scans 0..2 --sensor vlp-16 -o runs/first");
    let figures =
        "precision_recall range_objects range_vehicles stages ranking times losses_objects losses_vehicles";
    let mut expected: Vec<String> = figures
        .split(' ')
        .flat_map(|it| ["pdf", "svg"].map(|ending| format!("figures/{it}.{ending}")))
        .collect();
    let others = "confusion.csv table_classes_street-narrow.md table_classes_street-narrow.tex errors.csv figures manifest.json matches.csv poses.csv precision_recall.csv report.html report.json scans.csv stages.csv \
                  table_objects.csv table_objects.md table_objects.tex table_stages.md table_times.md \
                  table_vehicles.csv table_vehicles.md table_vehicles.tex worst_points.json";
    expected.extend(others.split_whitespace().map(str::to_owned));
    if cfg!(feature = "viewer") {
        let detectors = ["hierarchical", "kd-tree-tree", "paper", "kd-tree", "pca"];
        let layers = detectors.map(|it| format!("detector-{it}")).into_iter();
        let layers = layers.chain(["scans", "layout"].map(str::to_owned));
        expected.push("recording".to_owned());
        expected.extend(layers.map(|it| format!("recording/{it}.rrd")));
    }
    let names = workplace.names().into_iter();
    let in_run =
        names.filter_map(|it| Some(it.strip_prefix("runs/first").ok()?.to_string_lossy().into_owned()));
    let found: BTreeSet<String> = in_run.filter(|it| !it.is_empty()).collect();
    assert_eq!(found, expected.into_iter().collect());
}

#[test]
fn recorded_and_simulated_data_sets_are_separated_and_published_rows_stand_beside_the_papers_method() {
    let workplace = Workplace::with_drive(3);
    let run = |detectors: &str, output: &str| {
        workplace.succeed(&("run street narrow.mcap --no-rrd", ["-d", detectors, "-o", output])).stdout
    };
    workplace.succeed("data simulate street-narrow --simulated-scans 3 --sensor vlp-16 -o narrow.mcap");
    let with_paper = run("paper,hierarchical,pca", "with");
    for task in ["objects", "vehicles"] {
        for on in ["street (recorded)", "narrow (simulated)"] {
            let verdict = with_paper.split(&format!("Task {task} on {on}: ")).nth(1).unwrap_or_default();
            let verdict = verdict.split("\nTask ").next().unwrap_or_default();
            let named = ["paper", "hierarchical", "pca"].iter().filter(|it| verdict.contains(**it));
            assert!(named.count() >= 2, "{with_paper}");
        }
    }
    let report = workplace.read("with/report.json");
    assert!(!with_paper.contains("overall (") && report.contains("\"overall\": [\n  ]"), "{with_paper}");
    workplace.check_file("with/table_objects.csv", &["\nobjects,published,Budapest #1,recorded,paper,"]);
    let stages = workplace.read("with/table_stages.md");
    assert!(stages.contains("| **paper** | whole |  | 43 |") && !stages.contains("undefined"), "{stages}");
    run("hierarchical,pca", "without");
    let without = workplace.read("without/table_objects.md");
    assert!(
        !without.contains("published: ") && without.contains(": -d paper,hierarchical,kd-tree,pca."),
        "{without}"
    );
    assert!(!workplace.read("without/table_stages.md").contains("published"));
}

#[test]
fn a_run_without_a_name_is_found_as_the_latest() {
    let workplace = Workplace::with_drive(1);
    let ended = workplace.succeed("run street -d pca");
    let named = ended.named_directory();
    assert!(named.starts_with("runs/") && named.ends_with("Z-street"), "{named}");
    assert_eq!(workplace.read("runs/latest/report.json"), workplace.read(&format!("{named}/report.json")));
}

#[test]
fn runs_that_begin_in_the_same_second_have_names_of_their_own() {
    let workplace = Workplace::with_drive(1);
    let children: Vec<_> = (0..4).map(|_| workplace.start("run street -d pca --no-rrd")).collect();
    for child in children {
        let ended = Ended::from(child.wait_with_output().expect("it ends"));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        let named = ended.named_directory();
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
fn what_is_there_is_replaced_only_when_asked_for_and_threads_change_no_byte() {
    for (command, files) in [
        ("fit-density street --figures out -o curve.toml", &["curve.toml", "out/density.csv"][..]),
        ("data realism street --against street -o out", &["out/realism.csv", "out/ring_density.svg"]),
        (
            "train paper streets --seed 7 --simulated-scans 4 --sensor vlp-16 --nu 0.3 -o out",
            &["out/curves.csv", "out/curves.svg", "out/importance.csv", "out/objects.csv", "out/paper.model"],
        ),
    ] {
        let workplace = Workplace::with_drive(3);
        let made = |n_threads: &str, more: &str| {
            let ended = workplace.run_with(&[("RAYON_NUM_THREADS", n_threads)], &(command, more));
            assert_eq!(ended.exit_code, Some(0), "{command}: {ended:#?}");
            let files = files.iter().map(|it| (*it, workplace.read_bytes(it)));
            (files.collect::<Vec<_>>(), ended.stdout)
        };
        let (first, said) = made("1", "");
        let names = workplace.names();
        workplace.refuse(command, 2, &["exists", "--overwrite"]);
        let (second, said_again) = made("3", "--overwrite");
        assert_eq!(workplace.names(), names, "{command}");
        for ((name, one), (_, other)) in first.iter().zip(&second) {
            assert!(one == other && !one.is_empty(), "{name}: {command}");
        }
        assert_eq!(said, said_again, "{command}");
    }
}

#[test]
fn shards_of_a_run_without_times_make_the_run_to_the_last_byte() {
    let workplace = Workplace::with_drive(20);
    workplace.succeed("run street -d simple-grid --detections-out found --as csv --no-rrd -q -o first");
    // Results that were read have no times.
    let run =
        "run street --detections grid=found/simple-grid -d grid --protocol nuscenes,argoverse2 --no-rrd";
    check_study(&workplace, run, &[1, 7], check_same_bytes);
    workplace.succeed("gate merged-7 --baseline in-one");
}

#[test]
fn detectors_of_ours_and_of_others_find_the_same_in_shards() {
    let workplace = Workplace::new();
    let program = env!("CARGO_BIN_EXE_scanbench");
    let command = format!("[detector.served]\ncommand = [{program:?}, \"serve\", \"simple-grid\"]\n");
    workplace.write("scanbench.toml", &command);
    let run = "run street-narrow street-main-road --simulated-scans 2 --sensor vlp-16 -d simple-grid,served,pca --no-rrd";
    check_in_shards(&workplace, run, &[3], check_same_but_times);
}

#[test]
fn neither_jobs_nor_order_nor_what_was_before_changes_a_number() {
    let workplace = Workplace::with_drive(5);
    for (run, options) in [
        ("one", "--jobs 1 --warmup 0"),
        ("four", "--jobs 4"),
        ("again", "--jobs 4"),
        ("last", "--scans 2"),
        ("there", "-d hierarchical,pca"),
        ("back", "-d pca,hierarchical"),
    ] {
        workplace.succeed(&("run street --no-rrd -o", run, options));
    }
    check_same_numbers(&workplace, ["one", "four"]);
    check_same_numbers(&workplace, ["four", "again"]);
    let [there, back] = ["there", "back"].map(|run| untimed_rows(&workplace, run));
    assert_eq!((&there[0]["detector"], &back[0]["detector"]), (&"hierarchical".into(), &"pca".into()));
    let sorted = |lines: Vec<String>| lines.into_iter().collect::<BTreeSet<String>>();
    let [there, back] = [there, back].map(|rows| sorted(rows.iter().map(Value::to_string).collect()));
    assert_eq!(there, back);
    let matches = |run: &str, of: &str| -> Vec<String> {
        let text = workplace.read(&format!("{run}/matches.csv"));
        text.lines().filter(|line| line.starts_with(of)).map(str::to_owned).collect()
    };
    assert_eq!(sorted(matches("there", "")), sorted(matches("back", "")));
    assert!(!matches("last", "street,0000,2,").is_empty());
    assert_eq!(matches("one", "street,0000,2,"), matches("last", "street,0000,2,"));
}

#[test]
fn a_simulated_street_hangs_on_its_seed_alone() {
    let workplace = Workplace::new();
    for (run, seed, jobs) in [("one", "7", "1"), ("three", "7", "3"), ("other", "8", "3")] {
        let options = format!("--seed {seed} --jobs {jobs} -o {run}");
        workplace
            .succeed(&("run -d pca --scans 0..5:4 --sensor vlp-16 --no-rrd", &options))
            .check_stdout(&["on 3 simulated data sets, 6 scans"]);
    }
    check_same_numbers(&workplace, ["one", "three"]);
    assert_ne!(workplace.read("one/matches.csv"), workplace.read("other/matches.csv"));
}

#[test]
fn the_manifest_says_what_was_done() {
    let workplace = Workplace::with_drive(2);
    workplace.write("mine.toml", "[matching]\nmin_iou = 0.7\n");
    let arguments =
        ["run", "street", "-d", "pca", "-c", "mine.toml", "--scans", "1", "--warmup", "5", "-o", "out"];
    workplace.succeed(&arguments);
    let manifest = workplace.json("out/manifest.json");
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
    let manifest = workplace.json("out/manifest.json");
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
    let workplace = Workplace::with_drive(2);
    workplace.succeed("run street -d pca --criterion centre -o out");
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["matching_criterion"], "centre, closer than 2 m");
    assert_eq!(manifest["config"]["matching"]["criterion"], "centre");
    let matches = workplace.read("out/matches.csv");
    assert!(matches.contains(",centre,") && !matches.contains(",points,"), "{matches}");
}

/// The report is what `matches.csv` adds up to: anyone can count again.
#[test]
fn the_rows_of_the_matches_add_up_to_the_report() {
    let workplace = Workplace::with_drive(3);
    workplace.succeed("run street -d hierarchical -o out");
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
    let workplace = Workplace::with_drive(1);
    workplace.succeed("run street -d pca -o none --no-rrd");
    assert!(!workplace.path("none/recording").exists());
    workplace.succeed("run street -d pca -o here --save-rrd");
    assert!(workplace.path("here/recording/detector-pca.rrd").is_file());
    workplace.succeed("run street -d pca -o there --save-rrd=mine.rrd");
    assert!(workplace.path("mine.rrd").is_file() && !workplace.path("there/recording").exists());
    assert_eq!(workplace.top_names(), ["here", "mine.rrd", "none", "street", "there"]);
}

#[cfg(all(target_os = "linux", feature = "viewer"))]
#[test]
fn a_device_is_written_to_and_not_replaced() {
    let workplace = Workplace::with_drive(1);
    workplace.succeed("run street -d pca -o out --save-rrd=/dev/null");
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
    use std::process::Child;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::program::send;

    /// Starts a run over thousands of scans, and returns once some of them are written.
    fn started(workplace: &Workplace) -> Child {
        let dataset = DrawnDataset::tracking(workplace.folder(), 1);
        dataset.repeat_first_scan(4000);
        workplace.start_until("run street -d hierarchical,pca -o out --jobs 1", |it| {
            it.n_bytes("out.unfinished/journal") >= 30_000
        })
    }

    #[test]
    fn one_writes_at_a_time_and_a_request_to_end_leaves_what_is_done() {
        for (signal, exit_code) in [("-INT", 130), ("-TERM", 143)] {
            let workplace = Workplace::new();
            let child = started(&workplace);
            for more in ["", "--overwrite"] {
                let asked = Instant::now();
                let ended = workplace.run(&("run street -d pca -o out", more));
                let said = "error: another program is writing \"out\"; choose another name, or wait for it\n";
                assert_eq!((ended.exit_code, ended.stderr.as_str()), (Some(2), said));
                assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
            }
            send(&child, signal);
            let ended = Ended::from(child.wait_with_output().expect("it ends"));
            ended.check_refusal(exit_code, &["error: interrupted after ", " of 4000 scans"]);
            assert_eq!(workplace.top_names(), ["out.unfinished", "street"]);
        }
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
        // The lock of the killed one goes with whoever comes next.
        workplace.run(&other).check_refusal(2, &["start again with --overwrite"]);
        workplace.succeed(&(&other, "--overwrite"));
        assert!(workplace.path("out/report.json").is_file());
        assert!(!workplace.path("out.unfinished").exists());
    }
}
