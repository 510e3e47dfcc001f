//! Work that was ended goes on where it was, and comes to the same.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::program::{Ended, Words, Workplace, send};
use crate::shard_folders::{check_same_but_times, check_same_bytes, make_shards, merge_whole};

/// Sends `signal` once `command` has added so many bytes to the journal in `folder`, and returns how that ended.
fn end_in_the_middle(
    workplace: &Workplace,
    command: &(impl Words + ?Sized),
    (folder, n_bytes): (&str, u64),
    signal: &str,
) -> Ended {
    let journal = format!("{folder}/journal");
    let n_before = workplace.n_bytes(&journal);
    let child = workplace.start_until(command, |it| it.n_bytes(&journal) >= n_before + n_bytes);
    send(&child, signal);
    Ended::from(child.wait_with_output().unwrap())
}

#[test]
fn a_run_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 36 --sensor vlp-16 -d simple-grid --jobs 1 -o";
    for (signal, exit_code) in [("-KILL", None), ("-TERM", Some(143))] {
        let ended = end_in_the_middle(&workplace, &(run, "out"), ("out.unfinished", 40_000), signal);
        assert_eq!(ended.exit_code, exit_code, "{ended:#?}");
        assert!(!workplace.path("out").exists());
        if exit_code.is_some() {
            let kept = "of the 36 scans is kept in out.unfinished; to continue, give the same";
            ended.check_stderr(&[kept, "interrupted after"]);
        }
    }
    // Another run does not go on with it.
    workplace.end_with(&(run, "out --seed 7"), 2, &["belongs to another run: "]);
    // What needs all scans at once begins anew, and does not touch what is kept.
    workplace.succeed(&(run, "at-once --no-rrd --detections-out found --as csv"));
    // What somebody else has put there stays.
    workplace.write("out.unfinished/notes.txt", "");
    workplace.succeed(&(run, "out")).check_stderr(&["Continuing with "]);
    if cfg!(feature = "viewer") {
        // The first was killed, and is not whole.
        for name in ["recording-2", "recording-3"] {
            std::fs::remove_dir_all(workplace.path("out").join(name)).unwrap();
        }
        std::fs::remove_file(workplace.path("out/recordings.json")).unwrap();
    }
    check_same_but_times(&workplace, "at-once", "out");
    assert_eq!(workplace.top_names(), ["at-once", "found", "out", "out.unfinished"]);
    assert_eq!(workplace.read("out.unfinished/notes.txt"), "");
    assert!(!workplace.path("out.unfinished/journal").exists());
}

#[cfg(unix)]
#[test]
fn a_shard_of_a_study_goes_on_where_it_was_ended() {
    const UNFINISHED: &str = "shards/shard-1-of-1.unfinished";
    for (command, other, n_bytes, extent) in [
        (
            "sweep street-narrow --simulated-scans 8 --sensor vlp-16 -P cell_size_m=0.4:0.8:0.2 --timed-scans 0 --jobs 1",
            "--seed 7",
            1000,
            "8 scans",
        ),
        ("partial objects-vlp-16 --per-class 20", "--others", 1000, "100 objects"),
    ] {
        let workplace = Workplace::new();
        let shard = (command, "--no-rrd --shard 1/1 -o shards");
        for (signal, exit_code) in [("-KILL", None), ("-TERM", Some(143))] {
            let ended = end_in_the_middle(&workplace, &shard, (UNFINISHED, n_bytes), signal);
            assert_eq!(ended.exit_code, exit_code, "{ended:#?}");
            assert!(!workplace.path("shards/shard-1-of-1").exists());
            if exit_code.is_some() {
                let kept = format!(
                    "What is finished of the {extent} of shard 1/1 is kept in {UNFINISHED}; to continue"
                );
                ended.check_stderr(&[&kept, "interrupted after"]);
            }
        }
        workplace.end_with(&(shard, other), 2, &["belongs to another shard: "]);
        workplace.succeed(&shard).check_stderr(&["Continuing with "]);
        merge_whole(&workplace, "shards", "merged");
        workplace.succeed(&(command, "--no-rrd -o in-one"));
        check_same_bytes(&workplace, "in-one", "merged");
        assert_eq!(workplace.top_names(), ["in-one", "merged", "shards"]);
    }
}

/// Detections of equal score are one row of `precision_recall.csv`, whether they were kept or judged after the end.
#[test]
fn a_shard_with_equal_scores_goes_on_where_it_was_ended() {
    let workplace = Workplace::new();
    let run = "run street-narrow --simulated-scans 36 --sensor vlp-16 --no-rrd --jobs 1";
    workplace.succeed(&(run, "-d simple-grid -o first --detections-out found --as csv"));
    let is_csv = |it: &std::path::PathBuf| it.extension().is_some_and(|it| it == "csv");
    for name in workplace.names().into_iter().filter(|it| it.starts_with("found") && is_csv(it)) {
        let name = name.into_os_string().into_string().unwrap();
        let equal = |line: &str| {
            let mut cells: Vec<&str> = line.split(',').collect();
            cells[2] = if cells[2] == "score" { "score" } else { "1" };
            cells.join(",") + "\n"
        };
        workplace.write(&name, &workplace.read(&name).lines().map(equal).collect::<String>());
    }
    let judged = (run, "--detections equal=found/simple-grid -d equal,simple-grid");
    let shard = (judged, "--shard 1/2 -o shards");
    let ended = end_in_the_middle(&workplace, &shard, ("shards/shard-1-of-2.unfinished", 20_000), "-KILL");
    assert_eq!(ended.exit_code, None, "{ended:#?}");
    make_shards(&workplace, &judged, 2, "shards");
    merge_whole(&workplace, "shards", "merged");
    workplace.succeed(&(judged, "-o in-one"));
    check_same_but_times(&workplace, "in-one", "merged");
    let detectors = workplace.column("merged/precision_recall.csv", "detector");
    let n_rows = |name: &str| detectors.iter().filter(|it| *it == name).count();
    // Vehicles, pedestrians and cyclists.
    assert_eq!(n_rows("equal"), 3);
    assert!(n_rows("simple-grid") > 20);
}
