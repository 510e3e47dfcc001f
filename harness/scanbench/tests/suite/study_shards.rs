//! Shards of studies, and what `merge` makes of them: the study in one piece to the last byte, but for its times.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use serde_json::Value;
use test_data::test_data;

use crate::program::{Ended, Workplace};
use crate::shard_folders::{
    check_same_bytes, check_study_in_shards, files_of, make_shards, merge, merge_whole,
};

/// Two streets of a few seconds, at three points, by two detectors.
const SWEEP: [&str; 14] = [
    "sweep",
    "street-narrow",
    "street-main-road",
    "--simulated-scans",
    "6",
    "--sensor",
    "vlp-16",
    "-d",
    "hierarchical,pca",
    "-P",
    "hierarchical.grid.cell_size_m=0.6:0.8:0.2",
    "--no-rrd",
    "-q",
    "--timed-scans",
];

/// Makes `command` in one piece, and in this many shards, and compares all files but those of `is_timed`.
#[track_caller]
fn check_in_shards(command: &[&str], counts: &[u32], is_timed: fn(&Path) -> bool) {
    let workplace = Workplace::new();
    workplace.succeed(&[command, &["-o", "whole"]].concat());
    let times = files_of(&workplace, "whole").into_iter().filter(|it| is_timed(it));
    for name in times {
        std::fs::remove_file(workplace.path("whole").join(name)).unwrap();
    }
    for count in counts {
        let [shards, merged] = [format!("shards-{count}"), format!("merged-{count}")];
        make_shards(&workplace, command, *count, &shards);
        merge_whole(&workplace, &shards, &merged);
        for name in files_of(&workplace, &merged).into_iter().filter(|it| is_timed(it)) {
            std::fs::remove_file(workplace.path(&merged).join(name)).unwrap();
        }
        check_same_bytes(&workplace, "whole", &merged);
        let manifest: Value =
            serde_json::from_str(&workplace.read(&format!("{merged}/manifest.json"))).unwrap();
        assert_eq!(manifest["shards"].as_array().map(Vec::len), Some(*count as usize));
        assert!(manifest.get("shard").is_none());
    }
}

fn nothing_is_timed(_: &Path) -> bool {
    false
}

/// A file whose bytes hang on times.
fn hangs_on_times(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    ["times.csv", "sweep.md", "sweep.tex", "report.html"].contains(&name.as_str())
        || name.starts_with("pareto_")
}

#[test]
fn a_sweep_in_shards_is_the_sweep_in_one_piece() {
    check_in_shards(&[&SWEEP[..], &["0"]].concat(), &[1, 7], nothing_is_timed);
    // Skipped scans, a selection, values that go with others.
    let tied = [
        "0",
        "-P",
        "hierarchical.cluster.min_points=12/hierarchical.grid.cell_size_m",
        "--scans",
        "0..6:2",
        "--skip-damaged",
    ];
    check_in_shards(&[&SWEEP[..], &tied].concat(), &[2], nothing_is_timed);
}

#[test]
fn scans_of_a_sweep_are_timed_in_the_shards_that_have_them() {
    let command = [&SWEEP[..], &["2"]].concat();
    check_in_shards(&command, &[3], hangs_on_times);
    let workplace = Workplace::new();
    make_shards(&workplace, &command, 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    let times = workplace.read("merged/times.csv");
    let n_scans: Vec<&str> = times.lines().skip(1).filter_map(|it| it.split(',').nth(6)).collect();
    // Two of each data set, and four of both, for two detectors at two points.
    assert_eq!(n_scans, [["2"; 4], ["2"; 4], ["4"; 4]].concat(), "{times}");
    let sorted = |it: &str| {
        let text = workplace.read(&format!("shards/shard-{it}-of-3/timed_scans.jsonl"));
        text.lines().count()
    };
    assert_eq!(["1", "2", "3"].map(sorted).into_iter().sum::<usize>(), 4);
}

/// A shard of a sweep of many results.
const LONG: [&str; 14] = [
    "sweep",
    "street-narrow",
    "--simulated-scans",
    "12",
    "-P",
    "cell_size_m=0.4:0.8:0.2",
    "--timed-scans",
    "0",
    "--jobs",
    "1",
    "--shard",
    "1/1",
    "-o",
    "shards",
];
const UNFINISHED: &str = "shards/shard-1-of-1.unfinished/journal";

/// Starts `command`, and returns once its journal has grown by `n_more` lines.
fn started(workplace: &Workplace, command: &[&str], n_more: usize) -> Child {
    let n_lines = || std::fs::read_to_string(workplace.path(UNFINISHED)).map_or(0, |it| it.lines().count());
    let n_before = n_lines();
    let child = workplace.start(command);
    let started = Instant::now();
    while n_lines() < n_before + n_more {
        assert!(started.elapsed() < Duration::from_mins(2), "the shard does not get on");
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

/// Ends the program in the middle of `command`, twice, and returns how it ended the second time.
fn ended_twice(workplace: &Workplace, command: &[&str]) -> Ended {
    let mut last = None;
    for signal in ["-KILL", "-TERM"] {
        let child = started(workplace, command, 3);
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.unwrap().success());
        last = Some(Ended::from(child.wait_with_output().unwrap()));
        assert!(!workplace.path("shards/shard-1-of-1").exists());
    }
    last.unwrap()
}

#[cfg(unix)]
#[test]
fn a_shard_of_a_sweep_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let ended = ended_twice(&workplace, &LONG);
    assert_eq!(ended.exit_code, Some(143), "{ended:#?}");
    let kept = "What is done of the 12 scans of shard 1/1 is kept in shards/shard-1-of-1.unfinished: to go on with the others";
    assert!(ended.stderr.contains(kept) && ended.stderr.contains("interrupted after"), "{ended:#?}");
    let other = workplace.run(&[&LONG[..], &["--seed", "7"]].concat());
    assert_eq!(other.exit_code, Some(2), "{other:#?}");
    assert!(other.stderr.contains("belongs to another shard: "), "{other:#?}");
    let ended = workplace.succeed(&LONG);
    assert!(
        ended.stderr.contains("Continuing with ") && ended.stderr.contains(" of 36 results"),
        "{ended:#?}"
    );
    merge_whole(&workplace, "shards", "merged");
    workplace.succeed(&[&LONG[..10], &["--no-rrd", "-o", "whole"]].concat());
    check_same_bytes(&workplace, "whole", "merged");
    assert_eq!(workplace.top_names(), ["merged", "shards", "whole"]);
}

/// The shards are refused with this exit code and these words, and nothing is left.
#[track_caller]
fn check_refused(workplace: &Workplace, exit_code: i32, words: &str) {
    let merged = merge(workplace, "shards", "whole");
    assert_eq!(merged.exit_code, Some(exit_code), "{words}: {merged:#?}");
    assert!(merged.stderr.contains(words), "{words}: {}", merged.stderr);
    assert!(!workplace.path("whole").exists());
}

/// Makes `command` with `more` as the second of two shards elsewhere, and has it stand in for the second of `shards`.
#[track_caller]
fn check_stands_not_in(workplace: &Workplace, command: &[&str], more: &[&str], words: &str) {
    workplace.succeed(&[command, more, &["--shard", "2/2", "-o", "others"]].concat());
    let second = workplace.path("shards/shard-2-of-2");
    std::fs::rename(&second, workplace.path("aside")).unwrap();
    std::fs::rename(workplace.path("others/shard-2-of-2"), &second).unwrap();
    check_refused(workplace, 5, words);
    std::fs::remove_dir_all(&second).unwrap();
    std::fs::rename(workplace.path("aside"), &second).unwrap();
}

#[test]
fn shards_that_do_not_make_a_sweep_are_refused() {
    let workplace = Workplace::new();
    let common = ["street-narrow", "--simulated-scans", "20", "--sensor", "vlp-16", "-d", "pca"];
    let swept = ["-P", "pca.grid.cell_size_m=0.6:0.8:0.2", "--timed-scans", "0"];
    let sweep = [&["sweep"], &common[..], &swept].concat();
    make_shards(&workplace, &sweep, 2, "shards");
    let ours = [&["sweep"], &common[..]].concat();
    let finer = ["-P", "pca.grid.cell_size_m=0.6:0.8:0.1", "--timed-scans", "0"];
    check_stands_not_in(&workplace, &ours, &finer, "have different parameters: those that are swept");
    check_stands_not_in(&workplace, &sweep, &["--seed", "7"], "are of different data: their seeds differ");
    let criterion = ["--criterion", "centre"];
    check_stands_not_in(&workplace, &sweep, &criterion, "have different parameters: the matching criterion");
    let run = [&["run"], &common[..], &["--no-rrd"]].concat();
    check_stands_not_in(&workplace, &run, &[], "shard-1-of-2 is a shard of `sweep`, ");
    for name in ["swept_scans.jsonl", "timed_scans.jsonl"] {
        let name = format!("shards/shard-2-of-2/{name}");
        let sound = workplace.read(&name);
        let without_last_line = sound.trim_end().rsplit_once('\n').map(|(it, _)| format!("{it}\n"));
        let damaged = [Some("{}\n".to_owned()), without_last_line, Some(format!("{sound}{sound}x"))];
        for damaged in damaged.into_iter().flatten() {
            workplace.write(&name, &damaged);
            check_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        }
        std::fs::remove_file(workplace.path(&name)).unwrap();
        check_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        workplace.write(&name, &sound);
    }
    for verb in ["report", "view"] {
        let ended = workplace.run(&[verb, "shards/shard-1-of-2"]);
        assert!(ended.exit_code == Some(5) && ended.stderr.contains("is shard 1 of 2"), "{ended:#?}");
    }
    std::fs::rename(workplace.path("shards/shard-2-of-2"), workplace.path("aside")).unwrap();
    check_refused(&workplace, 5, "1 of 2 shards are missing: 2");
    std::fs::rename(workplace.path("aside"), workplace.path("shards/shard-2-of-2")).unwrap();
    let again = workplace.run(&[&sweep[..], &["--shard", "1/2", "-o", "shards"]].concat());
    assert_eq!(again.exit_code, Some(2), "{again:#?}");
    assert!(again.stderr.contains("shard-1-of-2 is there: shard 1/2 of `sweep`, finished"), "{again:#?}");
    merge_whole(&workplace, "shards", "whole");
    workplace.succeed(&["report", "whole"]);
}

#[test]
fn times_of_unlike_processors_are_never_put_together() {
    let workplace = Workplace::new();
    make_shards(&workplace, &[&SWEEP[..], &["2"]].concat(), 2, "shards");
    let name = "shards/shard-2-of-2/timed_scans.jsonl";
    let timed: Vec<Value> =
        workplace.read(name).lines().map(|it| serde_json::from_str(it).unwrap()).collect();
    let model = timed[0]["processor"].as_str().unwrap().to_owned();
    let other = workplace.read(name).replace(&model, "Abacus 3");
    workplace.write(name, &other);
    let manifest = "shards/shard-2-of-2/manifest.json";
    let mut changed: Value = serde_json::from_str(&workplace.read(manifest)).unwrap();
    changed["shard"]["processors"][0]["cpu_model"] = "Abacus 3".into();
    let sum = Command::new("sha256sum").arg(workplace.path(name)).output().unwrap();
    let sum = String::from_utf8(sum.stdout).unwrap();
    changed["shard"]["files"][1]["sha256"] = sum.split(' ').next().unwrap().into();
    changed["shard"]["files"][1]["n_bytes"] = other.len().into();
    workplace.write(manifest, &changed.to_string());
    merge_whole(&workplace, "shards", "whole");
    let names: Vec<String> =
        files_of(&workplace, "whole").iter().map(|it| it.display().to_string()).collect();
    assert!(!names.iter().any(|it| it == "times.csv" || it.starts_with("pareto_")), "{names:?}");
    let times = workplace.read("whole/times_of_processors.csv");
    assert!(times.lines().any(|it| it.starts_with("Abacus 3,0,")), "{times}");
    assert!(times.lines().any(|it| it.contains(&model)), "{times}");
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn recorded_drives_are_swept_the_same_in_shards() {
    let root = test_data("data/kitti_tracking");
    let sweep = ["sweep", root.to_str().unwrap(), "-d", "pca,kd-tree", "--scans", "0..60:6"];
    let values = ["-P", "pca.grid.cell_size_m=0.6:0.8:0.2", "--timed-scans", "0", "--no-rrd", "-q"];
    check_in_shards(&[&sweep[..], &values].concat(), &[2, 7], nothing_is_timed);
}

#[test]
fn an_ablation_in_shards_is_the_ablation_in_one_piece() {
    let data = ["street-narrow", "street-main-road", "--simulated-scans", "4", "--sensor", "vlp-16"];
    let command = [&["ablation"], &data[..], &["-q"]].concat();
    let workplace = Workplace::new();
    workplace.succeed(&[&command[..], &["-o", "whole"]].concat());
    check_study_in_shards(&workplace, &command, 3, "ablation.csv");
}

#[test]
fn shards_of_an_ablation_and_of_a_run_are_kept_apart() {
    let workplace = Workplace::new();
    let data = ["street-narrow", "--simulated-scans", "4", "--sensor", "vlp-16"];
    make_shards(&workplace, &[&["ablation"], &data[..]].concat(), 2, "shards");
    let run = [&["run"], &data[..], &["-d", "hierarchical", "--no-rrd"]].concat();
    check_stands_not_in(&workplace, &run, &[], "shard-1-of-2 is a shard of `ablation`, ");
    let ablation = [&["ablation"], &data[..]].concat();
    let other = ["-P", "hierarchical.grid.xi=2"];
    let words = "have different parameters: configuration changed: whole method: grid.xi: ";
    check_stands_not_in(&workplace, &ablation, &other, words);
}

/// Four objects of each class, from below and from above.
const PARTIAL: [&str; 6] = ["partial", "objects-vlp-16", "--per-class", "4", "--no-rrd", "-q"];

#[test]
fn objects_in_shards_are_classified_as_in_one_piece() {
    check_in_shards(&[&PARTIAL[..], &["--others"]].concat(), &[1, 7], nothing_is_timed);
    // More shards than objects of the second set, which methods learn about anew.
    let sets = ["objects-around", "--train", "objects-around", "--trained-on", "whole"];
    check_in_shards(&[&PARTIAL[..], &sets].concat(), &[3], nothing_is_timed);
}

#[cfg(unix)]
#[test]
fn a_shard_of_objects_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let command =
        ["partial", "objects-vlp-16", "--per-class", "40", "--no-rrd", "--shard", "1/1", "-o", "shards"];
    let ended = ended_twice(&workplace, &command);
    assert_eq!(ended.exit_code, Some(143), "{ended:#?}");
    let kept = "What is done of the 200 objects of shard 1/1 is kept in shards/shard-1-of-1.unfinished";
    assert!(ended.stderr.contains(kept) && ended.stderr.contains("interrupted after object"), "{ended:#?}");
    let other = workplace.run(&[&command[..], &["--others"]].concat());
    assert!(other.exit_code == Some(2) && other.stderr.contains("belongs to another shard"), "{other:#?}");
    assert!(workplace.succeed(&command).stderr.contains("Continuing with "));
    merge_whole(&workplace, "shards", "merged");
    workplace.succeed(&[&command[..5], &["-o", "whole"]].concat());
    check_same_bytes(&workplace, "whole", "merged");
}

#[test]
fn shards_that_do_not_make_a_result_of_objects_are_refused() {
    let workplace = Workplace::new();
    let partial = &PARTIAL[..4];
    make_shards(&workplace, partial, 2, "shards");
    let first = &PARTIAL[..2];
    check_stands_not_in(&workplace, first, &["--per-class", "5"], "are of different data: other objects");
    let words = "have different parameters: --others, --drives, --ablation or --trained-on";
    check_stands_not_in(&workplace, partial, &["--others"], words);
    let run =
        ["run", "street-narrow", "--simulated-scans", "2", "--sensor", "vlp-16", "-d", "pca", "--no-rrd"];
    check_stands_not_in(&workplace, &run, &[], "is of `partial`, and others are not");
    let name = "shards/shard-2-of-2/partial.csv";
    let sound = workplace.read(name);
    workplace.write(name, &sound[..sound.len() / 2]);
    check_refused(&workplace, 3, "shard-2-of-2 cannot be read");
    workplace.write(name, &sound);
    for verb in [&["report"][..], &["compare", "-d", "extents,bag of graphs"]] {
        let ended = workplace.run(&[verb, &["shards/shard-1-of-2"]].concat());
        assert!(ended.exit_code == Some(5) && ended.stderr.contains("is shard 1 of 2"), "{ended:#?}");
    }
    std::fs::remove_dir_all(workplace.path("shards/shard-1-of-2")).unwrap();
    check_refused(&workplace, 5, "1 of 2 shards are missing: 1");
}
