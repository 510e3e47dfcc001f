//! Shards of runs and studies, and what `merge` refuses of them; that they make the whole is tested with each study.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use test_data::test_data;

use crate::program::{Prepared, Workplace};
use crate::shard_folders::{
    check_in_shards, check_merge_refused, check_same_but_times, check_same_bytes, files_of, make_shards,
    merge_whole,
};

const RUN: &str = "run street-narrow street-main-road --simulated-scans 4 --sensor vlp-16 -d simple-grid,pca \
                   --no-rrd -q";
const SWEEP: &str = "sweep street-narrow street-main-road --simulated-scans 4 --sensor vlp-16 -d pca \
                     -P pca.grid.cell_size_m=0.6:0.8:0.2 -q --timed-scans 2";
const ABLATION: &str = "ablation street-narrow --simulated-scans 2 --sensor vlp-16 -q";
const PARTIAL: &str = "partial objects-vlp-16 --per-class 2 --no-rrd -q";

/// The second half of `RUN`.
const SECOND: &str = "run/shard-2-of-2";

/// A workplace with both halves of each of these, in folders that are called as the verbs.
fn halves() -> Workplace {
    static HALVES: Prepared = Prepared::new();
    HALVES.workplace(|workplace| {
        for (command, folder) in
            [(RUN, "run"), (SWEEP, "sweep"), (ABLATION, "ablation"), (PARTIAL, "partial")]
        {
            make_shards(workplace, command, 2, folder);
        }
    })
}

/// Changes the manifest of the second half in `folder`.
fn change_manifest(workplace: &Workplace, folder: &str, change: impl FnOnce(&mut Value)) {
    let name = format!("{folder}/shard-2-of-2/manifest.json");
    let mut manifest = workplace.json(&name);
    change(&mut manifest);
    workplace.write(&name, &manifest.to_string());
}

/// The lines of a log, each with the checksum that belongs before it.
fn with_checksums(log: &str) -> String {
    let mut checksum = crc32fast::Hasher::new();
    let mut line = |it: &str| {
        let content = &it[9..];
        checksum.update(content.as_bytes());
        format!("{:08x} {content}\n", checksum.clone().finalize())
    };
    log.lines().map(&mut line).collect()
}

/// Makes this the log of the second half in `folder`, as its manifest says.
fn write_log(workplace: &Workplace, folder: &str, log: &str) {
    let name = format!("{folder}/shard-2-of-2/shard.log");
    workplace.write(&name, log);
    let sum = Command::new("sha256sum").arg(workplace.path(&name)).output().expect("it runs").stdout;
    let sum = String::from_utf8(sum).expect("it is text");
    let written = json!({
        "name": "shard.log",
        "n_bytes": log.len(),
        "sha256": sum.split(' ').next(),
    });
    change_manifest(workplace, folder, |it| it["shard"]["log"] = written);
}

/// The shard `other` in the place of the second half in `folder` is refused in these words.
#[track_caller]
fn check_stands_not_in(workplace: &Workplace, folder: &str, other: &str, words: &str) {
    let second = workplace.path(&format!("{folder}/shard-2-of-2"));
    let rename = |from: &Path, to: &Path| std::fs::rename(from, to).expect("it is there");
    rename(&second, &workplace.path("aside"));
    rename(&workplace.path(other), &second);
    check_merge_refused(workplace, folder, 5, words);
    rename(&second, &workplace.path(other));
    rename(&workplace.path("aside"), &second);
}

#[test]
fn shards_of_other_data_parameters_or_studies_are_refused_each_in_its_own_words() {
    let workplace = halves();
    for (folder, other, words) in [
        ("sweep", SECOND, "shard-1-of-2 is a shard of `sweep`, "),
        ("ablation", SECOND, "shard-1-of-2 is a shard of `ablation`, "),
        ("partial", SECOND, "shard-1-of-2 is a shard of `partial`, "),
    ] {
        check_stands_not_in(&workplace, folder, other, words);
    }
    let swept = "sweep street-narrow street-main-road --simulated-scans 4 --sensor vlp-16 -d pca -q";
    for (folder, command, more, words) in [
        ("run", RUN, "--seed 7", "are of different data: their seeds differ"),
        ("run", RUN, "--scans 0..2", "are of different data: other scans of \"street-narrow\" were selected"),
        (
            "run",
            RUN,
            "-P pca.grid.cell_size_m=0.7",
            "have different parameters: configuration changed: pca: grid.cell_size_m: ",
        ),
        (
            "sweep",
            swept,
            "-P pca.grid.cell_size_m=0.6:0.8:0.1 --timed-scans 2",
            "have different parameters: those that are swept",
        ),
        (
            "partial",
            "partial objects-vlp-16 --no-rrd",
            "--per-class 3",
            "are of different data: other objects",
        ),
        (
            "partial",
            PARTIAL,
            "--others",
            "have different parameters: --others, --drives, --ablation or --trained-on",
        ),
    ] {
        workplace.succeed(&(command, more, "--shard 2/2 -o others"));
        check_stands_not_in(&workplace, folder, "others/shard-2-of-2", words);
        std::fs::remove_dir_all(workplace.path("others")).expect("it was made");
    }
}

#[test]
fn shards_of_which_the_manifests_do_not_make_a_run_are_refused() {
    let workplace = halves();
    let manifest = workplace.read("run/shard-2-of-2/manifest.json");
    for (change, words) in [
        ((|it| it["shard"]["program"] = "f00d".into()) as fn(&mut Value), "were made by different programs"),
        (|it| it["scoring_version"] = 77.into(), "has scoring version 2, "),
        (|it| it["datasets"][0]["checksum"] = "f00d".into(), "the checksums of \"street-narrow\" differ"),
        (|it| it["n_warmup_detections"] = 7.into(), "have different parameters: --warmup: 3 and 7"),
        (|it| it["matching_criterion"] = "".into(), "have different parameters: the matching criterion"),
        (|it| it["shard"]["count"] = 3.into(), "is one of 2 shards"),
        (|it| it["shard"]["index"] = 0.into(), "there is no shard 0"),
        (|it| it["shard"] = Value::Null, "is no shard, but a whole run"),
    ] {
        change_manifest(&workplace, "run", change);
        check_merge_refused(&workplace, "run", 5, words);
        workplace.write("run/shard-2-of-2/manifest.json", &manifest);
    }
    let [second, unfinished] = [SECOND, "run/shard-2-of-2.unfinished"].map(|it| workplace.path(it));
    std::fs::rename(&second, &unfinished).expect("it is there");
    check_merge_refused(&workplace, "run", 5, "is an unfinished shard: give its command again");
    std::fs::remove_dir_all(unfinished).expect("it is there");
    check_merge_refused(&workplace, "run", 5, "1 of 2 shards are missing: 2");
}

#[test]
fn damaged_shards_are_refused() {
    let workplace = halves();
    for folder in ["run", "sweep", "partial"] {
        let name = format!("{folder}/shard-2-of-2/shard.log");
        let sound = workplace.read(&name);
        let without_last_line = sound.trim_end().rsplit_once('\n').map(|(it, _)| format!("{it}\n"));
        let half_a_line = sound[..sound.len() - 20].to_owned();
        let damaged = [half_a_line, "a,b\n".to_owned(), String::new(), format!("{sound}{sound}x")];
        for damaged in damaged.into_iter().chain(without_last_line) {
            workplace.write(&name, &damaged);
            check_merge_refused(&workplace, folder, 3, "shard-2-of-2 cannot be read");
        }
        std::fs::remove_file(workplace.path(&name)).expect("it is there");
        check_merge_refused(&workplace, folder, 3, "shard-2-of-2 cannot be read");
        workplace.write(&name, &sound);
        // With a checksum of its own, a log that is damaged is still found out.
        let lines: Vec<&str> = sound.lines().collect();
        let swapped = [&lines[..1], &lines[2..3], &lines[1..2], &lines[3..]].concat().join("\n") + "\n";
        write_log(&workplace, folder, &swapped);
        check_merge_refused(&workplace, folder, 3, "line 2 of ");
        write_log(&workplace, folder, &sound);
        // As of a version before.
        change_manifest(&workplace, folder, |it| it["shard"]["log"] = Value::Null);
        check_merge_refused(
            &workplace,
            folder,
            3,
            "if another version of scanbench made it, make the shard again",
        );
        write_log(&workplace, folder, &sound);
    }
}

#[test]
fn a_shard_is_no_result_and_is_made_once() {
    let workplace = halves();
    for arguments in [
        "report run/shard-1-of-2",
        "compare -d pca,pca run/shard-1-of-2",
        "view run/shard-1-of-2",
        "report sweep/shard-1-of-2",
        "view sweep/shard-1-of-2",
        "report partial/shard-1-of-2",
        "compare partial/shard-1-of-2 -d extents,others",
    ] {
        workplace.end_with(arguments, 5, &["/shard-1-of-2 is shard 1 of 2"]);
    }
    let is_there = "shard-1-of-2 is there: shard 1/2 of `sweep`, finished";
    workplace.end_with(&(SWEEP, "--shard 1/2 -o sweep"), 2, &[is_there]);
    // The folder of all shards stands for them.
    for folder in ["run", "sweep"] {
        workplace.succeed(&("merge", folder, "-o", &format!("whole-{folder}")));
        workplace.succeed(&("report", format!("whole-{folder}")));
    }
}

#[test]
fn times_of_unlike_processors_are_never_put_together() {
    let workplace = halves();
    let manifest = workplace.json("sweep/shard-2-of-2/manifest.json");
    let model = manifest["shard"]["processors"][0]["cpu_model"].as_str().expect("a name");
    for folder in ["run", "sweep"] {
        change_manifest(&workplace, folder, |it| {
            it["shard"]["processors"][0]["cpu_model"] = "Abacus 3".into();
        });
        let log = workplace.read(&format!("{folder}/shard-2-of-2/shard.log"));
        write_log(&workplace, folder, &with_checksums(&log.replace(model, "Abacus 3")));
    }
    merge_whole(&workplace, "run", "in-one");
    let report = workplace.json("in-one/report.json");
    let rows = report["rows"].as_array().expect("a list");
    let values = |metric: &str| {
        let of_metric = rows.iter().filter(|it| it["metric"] == metric);
        of_metric.map(|it| it["value"].clone()).collect::<Vec<_>>()
    };
    for metric in ["latency_p50_ms", "fps_mean", "reference_ms"] {
        let values = values(metric);
        assert!(!values.is_empty() && values.iter().all(Value::is_null), "{metric}: {values:?}");
    }
    assert!(values("time_over_reference").iter().all(Value::is_number));
    let times = workplace.read("in-one/times_of_processors.csv");
    let n = |model: &str| times.lines().filter(|it| it.starts_with(model)).count();
    assert_eq!((n("Abacus 3") > 8, n("Abacus 3") * 2), (true, times.lines().count() - 1), "{times}");
    workplace.check_file("in-one/table_times.md", &["on Abacus 3"]);

    merge_whole(&workplace, "sweep", "swept");
    let names: Vec<String> =
        files_of(&workplace, "swept").iter().map(|it| it.display().to_string()).collect();
    assert!(!names.iter().any(|it| it == "times.csv" || it.starts_with("pareto_")), "{names:?}");
    let times = workplace.read("swept/times_of_processors.csv");
    assert!(times.lines().any(|it| it.starts_with("Abacus 3,0,")), "{times}");
    assert!(times.lines().any(|it| it.contains(model)), "{times}");
}

#[test]
fn an_empty_shard_is_a_sound_result() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 3 --sensor vlp-16 -d pca --no-rrd";
    make_shards(&workplace, run, 4, "shards");
    let log = |index: u32| workplace.read(&format!("shards/shard-{index}-of-4/shard.log"));
    let n_scans: Vec<usize> = (1..=4).map(|it| log(it).matches("{\"scan\":{").count()).collect();
    // Each scan is of a street of its own.
    assert_eq!((n_scans.iter().filter(|it| **it == 0).count(), n_scans.iter().sum::<usize>()), (1, 3));
    merge_whole(&workplace, "shards", "in-one");
}

#[test]
fn options_that_a_shard_cannot_keep_are_refused() {
    let workplace = Workplace::new();
    for more in [
        "",
        "-o shards --mcap",
        "-o shards --detections-out found --as csv",
        "-o shards --save-rrd=mine.rrd",
        "-o shards --serve=0",
    ] {
        workplace.end_with(&("run street-narrow --simulated-scans 3 --shard 1/2", more), 2, &[]);
    }
    let first_and_last = "the first of 2 is 1/2, the last 2/2";
    workplace.end_with("run street-narrow --shard 0/2 -o shards", 2, &[first_and_last]);
    assert_eq!(workplace.top_names(), [""; 0]);
}

#[cfg(feature = "viewer")]
#[test]
fn the_page_leads_to_the_recordings_of_the_shards() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 24 --sensor vlp-16 -d pca --rerun-every 2";
    make_shards(&workplace, run, 2, "shards");
    assert!(workplace.path("shards/shard-2-of-2/recording").is_dir());
    merge_whole(&workplace, "shards", "in-one");
    let recordings = workplace.json("in-one/recordings.json");
    let recorded = recordings["places"].as_array().expect("a list");
    let page = workplace.read("in-one/report.html");
    for object in recorded {
        let file = object["recording"].as_str().expect("a path");
        assert!(
            file.starts_with("../shards/shard-") && workplace.path("in-one").join(file).is_dir(),
            "{file}"
        );
        assert!(page.contains(&format!("href=\"{file}\"")), "{file}");
        // By the number in the run, and not in the shard.
        assert_eq!(object["step"].as_u64().map(|it| it % 2), Some(0));
    }
    assert!(!recorded.is_empty());
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn recorded_drives_give_the_same_in_shards() {
    let root = test_data("data/kitti_tracking");
    let root = root.to_str().expect("a readable path");
    let workplace = Workplace::new();
    let options = "-d simple-grid,pca --scans 0..60:4 --no-rrd -q --protocol kitti-object";
    check_in_shards(&workplace, &(["run", root], options), &[3], check_same_but_times);
    for name in ["protocol_kitti_object.csv", "protocols.json", "table_protocol_kitti-object.md"] {
        let [one, other] = ["in-one", "merged-3"].map(|it| workplace.read(&format!("{it}/{name}")));
        assert!(one == other && one.lines().count() > 20, "{name}");
    }
    let manifest = workplace.json("merged-3/manifest.json");
    assert_eq!(manifest["shards"][0]["cut_by"], "file-sizes");
    let workplace = Workplace::new();
    let options =
        "-P pca.grid.cell_size_m=0.6:0.8:0.2 --timed-scans 0 --no-rrd -q -d pca,kd-tree --scans 0..60:6";
    check_in_shards(&workplace, &(["sweep", root], options), &[2, 7], check_same_bytes);
}
