//! Shards of studies, and what `merge` makes of them: the study in one piece to the last byte, but for its times.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use test_data::test_data;

use crate::program::{Ended, Words, Workplace, send};
use crate::shard_folders::{
    check_merge_refused, check_same_bytes, check_study_in_shards, files_of, make_shards, merge_whole,
};

/// Two streets of a few seconds, at three points, by two detectors.
const SWEEP: &str = "sweep street-narrow street-main-road --simulated-scans 6 --sensor vlp-16 -d hierarchical,pca \
                     -P hierarchical.grid.cell_size_m=0.6:0.8:0.2 --no-rrd -q --timed-scans";

/// Makes `command` in one piece, and in this many shards, and compares all files but those of `is_timed`.
#[track_caller]
fn check_in_shards(command: &(impl Words + ?Sized), counts: &[u32], is_timed: fn(&Path) -> bool) {
    let workplace = Workplace::new();
    let without_times = |study: &str| {
        for name in files_of(&workplace, study).into_iter().filter(|it| is_timed(it)) {
            std::fs::remove_file(workplace.path(study).join(name)).unwrap();
        }
    };
    workplace.succeed(&(command, "-o whole"));
    without_times("whole");
    for count in counts {
        let [shards, merged] = [format!("shards-{count}"), format!("merged-{count}")];
        make_shards(&workplace, command, *count, &shards);
        merge_whole(&workplace, &shards, &merged);
        without_times(&merged);
        check_same_bytes(&workplace, "whole", &merged);
        let manifest = workplace.json(&format!("{merged}/manifest.json"));
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
    check_in_shards(&(SWEEP, "0"), &[1, 7], nothing_is_timed);
    // Skipped scans, a selection, values that go with others.
    let tied =
        "0 -P hierarchical.cluster.min_points=12/hierarchical.grid.cell_size_m --scans 0..6:2 --skip-damaged";
    check_in_shards(&(SWEEP, tied), &[2], nothing_is_timed);
}

#[test]
fn scans_of_a_sweep_are_timed_in_the_shards_that_have_them() {
    let command = (SWEEP, "2");
    check_in_shards(&command, &[3], hangs_on_times);
    let workplace = Workplace::new();
    make_shards(&workplace, &command, 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    let times = workplace.read("merged/times.csv");
    let n_scans: Vec<&str> = times.lines().skip(1).filter_map(|it| it.split(',').nth(6)).collect();
    // Two of each data set, and four of both, for two detectors at two points.
    assert_eq!(n_scans, [["2"; 4], ["2"; 4], ["4"; 4]].concat(), "{times}");
    let n_timed = |it: u32| workplace.n_lines(&format!("shards/shard-{it}-of-3/timed_scans.jsonl"));
    assert_eq!((1..=3).map(n_timed).sum::<usize>(), 4);
}

/// A sweep of many results, and one shard of it.
const LONG: &str =
    "sweep street-narrow --simulated-scans 12 -P cell_size_m=0.4:0.8:0.2 --timed-scans 0 --jobs 1";
const ONE_SHARD: &str = "--shard 1/1 -o shards";

/// Ends the program in the middle of `command`, twice, and returns how it ended the second time.
fn ended_twice(workplace: &Workplace, command: &(impl Words + ?Sized)) -> Ended {
    let [_, last] = ["-KILL", "-TERM"].map(|signal| {
        let journal = "shards/shard-1-of-1.unfinished/journal";
        let n_before = workplace.n_lines(journal);
        let child = workplace.start_until(command, |it| it.n_lines(journal) >= n_before + 3);
        send(&child, signal);
        let ended = Ended::from(child.wait_with_output().unwrap());
        assert!(!workplace.path("shards/shard-1-of-1").exists());
        ended
    });
    last
}

#[cfg(unix)]
#[test]
fn a_shard_of_a_sweep_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let ended = ended_twice(&workplace, &(LONG, ONE_SHARD));
    assert_eq!(ended.exit_code, Some(143), "{ended:#?}");
    let kept = "What is done of the 12 scans of shard 1/1 is kept in shards/shard-1-of-1.unfinished: to go on with the others";
    ended.check_stderr(&[kept, "interrupted after"]);
    workplace.end_with(&(LONG, ONE_SHARD, "--seed 7"), 2, &["belongs to another shard: "]);
    workplace.succeed(&(LONG, ONE_SHARD)).check_stderr(&["Continuing with ", " of 36 results"]);
    merge_whole(&workplace, "shards", "merged");
    workplace.succeed(&(LONG, "--no-rrd -o whole"));
    check_same_bytes(&workplace, "whole", "merged");
    assert_eq!(workplace.top_names(), ["merged", "shards", "whole"]);
}

/// Makes `command` with `more` as the second of two shards elsewhere, and has it stand in for the second of `shards`.
#[track_caller]
fn check_stands_not_in(workplace: &Workplace, command: &str, more: &str, words: &str) {
    workplace.succeed(&(command, more, "--shard 2/2 -o others"));
    let second = workplace.path("shards/shard-2-of-2");
    std::fs::rename(&second, workplace.path("aside")).unwrap();
    std::fs::rename(workplace.path("others/shard-2-of-2"), &second).unwrap();
    check_merge_refused(workplace, 5, words);
    std::fs::remove_dir_all(&second).unwrap();
    std::fs::rename(workplace.path("aside"), &second).unwrap();
}

#[test]
fn shards_that_do_not_make_a_sweep_are_refused() {
    let workplace = Workplace::new();
    let ours = "sweep street-narrow --simulated-scans 20 --sensor vlp-16 -d pca";
    let sweep = format!("{ours} -P pca.grid.cell_size_m=0.6:0.8:0.2 --timed-scans 0");
    let sweep = sweep.as_str();
    make_shards(&workplace, sweep, 2, "shards");
    let finer = "-P pca.grid.cell_size_m=0.6:0.8:0.1 --timed-scans 0";
    let run = "run street-narrow --simulated-scans 20 --sensor vlp-16 -d pca --no-rrd";
    for (command, more, words) in [
        (ours, finer, "have different parameters: those that are swept"),
        (sweep, "--seed 7", "are of different data: their seeds differ"),
        (sweep, "--criterion centre", "have different parameters: the matching criterion"),
        (run, "", "shard-1-of-2 is a shard of `sweep`, "),
    ] {
        check_stands_not_in(&workplace, command, more, words);
    }
    for name in ["swept_scans.jsonl", "timed_scans.jsonl"] {
        let name = format!("shards/shard-2-of-2/{name}");
        let sound = workplace.read(&name);
        let without_last_line = sound.trim_end().rsplit_once('\n').map(|(it, _)| format!("{it}\n"));
        let damaged = [Some("{}\n".to_owned()), without_last_line, Some(format!("{sound}{sound}x"))];
        for damaged in damaged.into_iter().flatten() {
            workplace.write(&name, &damaged);
            check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        }
        std::fs::remove_file(workplace.path(&name)).unwrap();
        check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        workplace.write(&name, &sound);
    }
    for verb in ["report", "view"] {
        workplace.end_with(&(verb, "shards/shard-1-of-2"), 5, &["is shard 1 of 2"]);
    }
    std::fs::rename(workplace.path("shards/shard-2-of-2"), workplace.path("aside")).unwrap();
    check_merge_refused(&workplace, 5, "1 of 2 shards are missing: 2");
    std::fs::rename(workplace.path("aside"), workplace.path("shards/shard-2-of-2")).unwrap();
    let is_there = "shard-1-of-2 is there: shard 1/2 of `sweep`, finished";
    workplace.end_with(&(sweep, "--shard 1/2 -o shards"), 2, &[is_there]);
    merge_whole(&workplace, "shards", "whole");
    workplace.succeed("report whole");
}

#[test]
fn times_of_unlike_processors_are_never_put_together() {
    let workplace = Workplace::new();
    make_shards(&workplace, &(SWEEP, "2"), 2, "shards");
    let name = "shards/shard-2-of-2/timed_scans.jsonl";
    let timed: Vec<Value> =
        workplace.read(name).lines().map(|it| serde_json::from_str(it).unwrap()).collect();
    let model = timed[0]["processor"].as_str().unwrap().to_owned();
    let other = workplace.read(name).replace(&model, "Abacus 3");
    workplace.write(name, &other);
    let manifest = "shards/shard-2-of-2/manifest.json";
    let mut changed = workplace.json(manifest);
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
    let values = "-P pca.grid.cell_size_m=0.6:0.8:0.2 --timed-scans 0 --no-rrd -q";
    let sweep = (["sweep", root.to_str().unwrap()], "-d pca,kd-tree --scans 0..60:6", values);
    check_in_shards(&sweep, &[2, 7], nothing_is_timed);
}

#[test]
fn an_ablation_in_shards_is_the_ablation_in_one_piece() {
    let command = "ablation street-narrow street-main-road --simulated-scans 4 --sensor vlp-16 -q";
    let workplace = Workplace::new();
    workplace.succeed(&(command, "-o whole"));
    check_study_in_shards(&workplace, command, 3, "ablation.csv");
}

#[test]
fn shards_of_an_ablation_and_of_a_run_are_kept_apart() {
    let workplace = Workplace::new();
    let ablation = "ablation street-narrow --simulated-scans 4 --sensor vlp-16";
    make_shards(&workplace, ablation, 2, "shards");
    let run = "run street-narrow --simulated-scans 4 --sensor vlp-16 -d hierarchical --no-rrd";
    check_stands_not_in(&workplace, run, "", "shard-1-of-2 is a shard of `ablation`, ");
    let words = "have different parameters: configuration changed: whole method: grid.xi: ";
    check_stands_not_in(&workplace, ablation, "-P hierarchical.grid.xi=2", words);
}

/// Four objects of each class, from below and from above.
const PARTIAL: &str = "partial objects-vlp-16 --per-class 4 --no-rrd -q";

#[test]
fn objects_in_shards_are_classified_as_in_one_piece() {
    check_in_shards(&(PARTIAL, "--others"), &[1, 7], nothing_is_timed);
    // More shards than objects of the second set, which methods learn about anew.
    let sets = "objects-around --train objects-around --trained-on whole";
    check_in_shards(&(PARTIAL, sets), &[3], nothing_is_timed);
}

#[cfg(unix)]
#[test]
fn a_shard_of_objects_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let many = "partial objects-vlp-16 --per-class 40 --no-rrd";
    let ended = ended_twice(&workplace, &(many, ONE_SHARD));
    assert_eq!(ended.exit_code, Some(143), "{ended:#?}");
    let kept = "What is done of the 200 objects of shard 1/1 is kept in shards/shard-1-of-1.unfinished";
    ended.check_stderr(&[kept, "interrupted after object"]);
    workplace.end_with(&(many, ONE_SHARD, "--others"), 2, &["belongs to another shard"]);
    workplace.succeed(&(many, ONE_SHARD)).check_stderr(&["Continuing with "]);
    merge_whole(&workplace, "shards", "merged");
    workplace.succeed(&(many, "-o whole"));
    check_same_bytes(&workplace, "whole", "merged");
}

#[test]
fn shards_that_do_not_make_a_result_of_objects_are_refused() {
    let workplace = Workplace::new();
    let partial = "partial objects-vlp-16 --per-class 4";
    make_shards(&workplace, partial, 2, "shards");
    let run = "run street-narrow --simulated-scans 2 --sensor vlp-16 -d pca --no-rrd";
    let options = "have different parameters: --others, --drives, --ablation or --trained-on";
    for (command, more, words) in [
        ("partial objects-vlp-16", "--per-class 5", "are of different data: other objects"),
        (partial, "--others", options),
        (run, "", "of `partial`"),
    ] {
        check_stands_not_in(&workplace, command, more, words);
    }
    let name = "shards/shard-2-of-2/partial.csv";
    let sound = workplace.read(name);
    workplace.write(name, &sound[..sound.len() / 2]);
    check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
    workplace.write(name, &sound);
    for verb in [&["report"][..], &["compare", "-d", "extents,bag of graphs"]] {
        workplace.end_with(&(verb, "shards/shard-1-of-2"), 5, &["is shard 1 of 2"]);
    }
    std::fs::remove_dir_all(workplace.path("shards/shard-1-of-2")).unwrap();
    check_merge_refused(&workplace, 5, "1 of 2 shards are missing: 1");
}
