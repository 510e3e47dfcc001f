//! Shards of a run, and what `merge` makes of them: the run in one piece to the last byte, but for its times, or a refusal.

use serde_json::Value;
use test_data::test_data;

use crate::program::{Ended, Prepared, Workplace, send};
use crate::shard_folders::{
    check_merge_refused, check_same_but_times, check_same_bytes, make_shards, merge_whole,
};

/// Two streets of a few seconds: forty scans.
const STREETS: &str = "run street-narrow street-main-road --simulated-scans 20 --sensor vlp-16 --no-rrd -q";
const QUICK: &str = "-d simple-grid,pca";

#[test]
fn what_has_no_times_is_the_same_to_the_last_byte_in_any_number_of_shards() {
    let workplace = Workplace::new();
    workplace.succeed(&(STREETS, "-d simple-grid --detections-out found --as csv -o first"));
    // Results that were read have no times.
    let options = "--detections grid=found/simple-grid -d grid --protocol nuscenes,argoverse2";
    let read = (STREETS, options);
    workplace.succeed(&(read, "-o in-one"));
    for count in [1, 2, 3, 7, 16] {
        let [shards, merged] = [format!("shards-{count}"), format!("merged-{count}")];
        make_shards(&workplace, &read, count, &shards);
        merge_whole(&workplace, &shards, &merged);
        check_same_bytes(&workplace, "in-one", &merged);
    }
    let manifest = workplace.json("merged-3/manifest.json");
    assert_eq!(manifest["shards"].as_array().unwrap().len(), 3);
    assert!(manifest.get("shard").is_none());
    workplace.succeed("gate merged-3 --baseline in-one");
}

#[test]
fn detectors_of_ours_and_of_others_find_the_same_in_shards() {
    let workplace = Workplace::new();
    let program = env!("CARGO_BIN_EXE_scanbench");
    let command = format!("[detector.served]\ncommand = [{program:?}, \"serve\", \"simple-grid\"]\n");
    workplace.write("scanbench.toml", &command);
    let run = (STREETS, "-d simple-grid,served,pca --scans 0..20:2");
    workplace.succeed(&(run, "-o in-one"));
    make_shards(&workplace, &run, 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    check_same_but_times(&workplace, "in-one", "merged");
}

#[test]
#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]
fn recorded_drives_give_the_same_in_shards() {
    let root = test_data("data/kitti_tracking");
    let workplace = Workplace::new();
    let options = "--scans 0..60:4 --no-rrd -q --protocol kitti-object";
    let run = (["run", root.to_str().unwrap()], QUICK, options);
    workplace.succeed(&(run, "-o in-one"));
    make_shards(&workplace, &run, 3, "shards");
    merge_whole(&workplace, "shards", "merged");
    check_same_but_times(&workplace, "in-one", "merged");
    for name in ["protocol_kitti_object.csv", "protocols.json", "table_protocol_kitti-object.md"] {
        let [one, other] = ["in-one", "merged"].map(|it| workplace.read(&format!("{it}/{name}")));
        assert!(one == other && one.lines().count() > 20, "{name}");
    }
    let manifest = workplace.json("merged/manifest.json");
    assert_eq!(manifest["shards"][0]["cut_by"], "file-sizes");
}

/// A workplace with both halves of a run.
fn halves() -> Workplace {
    static HALVES: Prepared = Prepared::new();
    HALVES.workplace(|workplace| make_shards(workplace, &(STREETS, QUICK), 2, "shards"))
}

/// Changes the manifest of the second half.
fn change_manifest(workplace: &Workplace, change: impl FnOnce(&mut Value)) {
    let name = "shards/shard-2-of-2/manifest.json";
    let mut manifest = workplace.json(name);
    change(&mut manifest);
    workplace.write(name, &manifest.to_string());
}

#[test]
fn shards_that_do_not_make_a_run_are_refused_each_in_its_own_words() {
    let workplace = halves();
    let second = workplace.path("shards/shard-2-of-2");
    let manifest = workplace.read("shards/shard-2-of-2/manifest.json");
    // Each is made in a folder of its own and stands in for the second half.
    for (more, shard, words) in [
        ("--seed 7", "2/2", "are of different data: their seeds differ"),
        ("--scans 0..10", "2/2", "are of different data: other scans of \"street-narrow\" were selected"),
        (
            "-P pca.grid.cell_size_m=0.7",
            "2/2",
            "have different parameters: configuration changed: pca: grid.cell_size_m: ",
        ),
        ("--warmup 7", "2/2", "have different parameters: --warmup: 3 and 7"),
        ("--criterion centre", "2/2", "have different parameters: the matching criterion"),
        ("", "2/3", "is one of 2 shards"),
    ] {
        workplace.succeed(&(STREETS, QUICK, more, ["--shard", shard, "-o", "others"]));
        std::fs::rename(&second, workplace.path("aside")).unwrap();
        let made = format!("others/shard-{}-of-{}", &shard[..1], &shard[2..]);
        std::fs::rename(workplace.path(&made), &second).unwrap();
        check_merge_refused(&workplace, 5, words);
        std::fs::remove_dir_all(&second).unwrap();
        std::fs::rename(workplace.path("aside"), &second).unwrap();
    }
    for (change, words) in [
        ((|it| it["shard"]["program"] = "f00d".into()) as fn(&mut Value), "were made by different programs"),
        (|it| it["scoring_version"] = 77.into(), "has scoring version 2, "),
        (|it| it["datasets"][0]["checksum"] = "f00d".into(), "the checksums of \"street-narrow\" differ"),
        (|it| it["shard"]["index"] = 1.into(), "are both shard 1/2"),
        (|it| it["shard"]["index"] = 0.into(), "there is no shard 0"),
        (|it| it["shard"]["parts"][1]["first"] = 3.into(), "from place"),
        (|it| it["shard"] = Value::Null, "is no shard, but a whole run"),
    ] {
        change_manifest(&workplace, change);
        check_merge_refused(&workplace, 5, words);
        workplace.write("shards/shard-2-of-2/manifest.json", &manifest);
    }
    std::fs::rename(&second, workplace.path("aside")).unwrap();
    check_merge_refused(&workplace, 5, "1 of 2 shards are missing: 2");
    std::fs::rename(workplace.path("aside"), workplace.path("shards/shard-2-of-2.unfinished")).unwrap();
    check_merge_refused(&workplace, 5, "is an unfinished shard: give its command again");
    std::fs::rename(workplace.path("shards/shard-2-of-2.unfinished"), &second).unwrap();
    merge_whole(&workplace, "shards", "in-one");
}

#[test]
fn damaged_shards_are_refused() {
    let workplace = halves();
    for name in ["scans.csv", "matches.csv", "stages.csv"] {
        let name = format!("shards/shard-2-of-2/{name}");
        let sound = workplace.read(&name);
        let without_last_line = sound.trim_end().rsplit_once('\n').unwrap().0.to_owned() + "\n";
        let half_a_line = sound[..sound.len() - 20].to_owned();
        for damaged in [without_last_line, half_a_line, "a,b\n".to_owned(), String::new()] {
            workplace.write(&name, &damaged);
            check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        }
        std::fs::remove_file(workplace.path(&name)).unwrap();
        check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
        workplace.write(&name, &sound);
    }
    std::fs::remove_file(workplace.path("shards/shard-2-of-2/worst_points.json")).unwrap();
    check_merge_refused(&workplace, 3, "shard-2-of-2 cannot be read");
}

#[test]
fn times_of_unlike_processors_are_never_put_together() {
    let workplace = halves();
    change_manifest(&workplace, |it| it["shard"]["processors"][0]["cpu_model"] = "Abacus 3".into());
    merge_whole(&workplace, "shards", "in-one");
    let report = workplace.json("in-one/report.json");
    let rows = report["rows"].as_array().unwrap();
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
}

#[test]
fn an_empty_shard_is_a_sound_result_and_a_shard_is_no_run() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 3 --sensor vlp-16 -d pca --no-rrd";
    make_shards(&workplace, run, 4, "shards");
    let n_lines: Vec<usize> =
        (1..=4).map(|it| workplace.n_lines(&format!("shards/shard-{it}-of-4/scans.csv"))).collect();
    // Each scan is of a street of its own. Beside the names of columns it has a row for each task.
    assert_eq!((n_lines.iter().filter(|it| **it == 1).count(), n_lines.iter().sum::<usize>()), (1, 4 + 6));
    for verb in ["report", "compare -d pca,pca", "view"] {
        workplace.end_with(&(verb, "shards/shard-1-of-4"), 5, &["shards/shard-1-of-4 is shard 1 of 4"]);
    }
    // The folder of all shards stands for them.
    workplace.succeed("merge shards -o in-one");
    workplace.succeed("report in-one");
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

/// A run of many scans.
const LONG: &str = "run street-narrow --simulated-scans 60 --sensor vlp-16 -d simple-grid --jobs 1 -o";

#[test]
fn a_run_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    for (signal, exit_code) in [("-KILL", None), ("-TERM", Some(143))] {
        // Some scans are in its journal.
        let journal = "out.unfinished/journal";
        let n_before = workplace.n_bytes(journal);
        let child = workplace.start_until(&(LONG, "out"), |it| it.n_bytes(journal) >= n_before + 40_000);
        send(&child, signal);
        let ended = Ended::from(child.wait_with_output().unwrap());
        assert_eq!(ended.exit_code, exit_code, "{ended:#?}");
        assert!(!workplace.path("out").exists());
        if exit_code.is_some() {
            let kept = "of the 60 scans is kept in out.unfinished; to continue, give the same";
            ended.check_stderr(&[kept, "interrupted after"]);
        }
    }
    // Another run does not go on with it.
    workplace.end_with(&(LONG, "out --seed 7"), 2, &["belongs to another run: "]);
    // What needs all scans at once begins anew, and does not touch what is kept.
    workplace.succeed(&(LONG, "at-once --no-rrd --detections-out found --as csv"));
    // What somebody else has put there stays.
    workplace.write("out.unfinished/notes.txt", "");
    workplace.succeed(&(LONG, "out")).check_stderr(&["Continuing with "]);
    if cfg!(feature = "viewer") {
        // The first was killed, and is not whole.
        for name in ["run-2.rrd", "run-3.rrd", "recordings.json"] {
            std::fs::remove_file(workplace.path("out").join(name)).unwrap();
        }
    }
    check_same_but_times(&workplace, "at-once", "out");
    assert_eq!(workplace.top_names(), ["at-once", "found", "out", "out.unfinished"]);
    assert_eq!(workplace.read("out.unfinished/notes.txt"), "");
    assert!(!workplace.path("out.unfinished/journal").exists());
}

#[cfg(feature = "viewer")]
#[test]
fn the_page_leads_to_the_recordings_of_the_shards() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 24 --sensor vlp-16 -d pca --rerun-every 2";
    make_shards(&workplace, run, 2, "shards");
    assert!(workplace.path("shards/shard-2-of-2/run.rrd").is_file());
    merge_whole(&workplace, "shards", "in-one");
    let recordings = workplace.json("in-one/recordings.json");
    let recorded = recordings["places"].as_array().unwrap();
    let page = workplace.read("in-one/report.html");
    for object in recorded {
        let file = object["recording"].as_str().unwrap();
        assert!(
            file.starts_with("../shards/shard-") && workplace.path("in-one").join(file).is_file(),
            "{file}"
        );
        assert!(page.contains(&format!("href=\"{file}\"")), "{file}");
        // By the number in the run, and not in the shard.
        assert_eq!(object["step"].as_u64().unwrap() % 2, 0);
    }
    assert!(!recorded.is_empty());
}
