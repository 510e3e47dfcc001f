//! Detectors that are programs of their own: served ones, and ones that misbehave in every way that the protocol names.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::net::TcpListener;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::program::{Ended, Words, Workplace};
use crate::shard_folders::merge_whole;

const QUIET: &str = "--no-rrd -q -o out";
/// Scans of the drive.
const N_SCANS: u32 = 5;

/// A drawn drive and a detector `odd` that behaves as `behaviour` says.
fn workplace_with(behaviour: &str, more: &str) -> Workplace {
    let workplace = Workplace::with_drive(N_SCANS);
    let program = std::env::current_exe().unwrap().display().to_string();
    let words = [program.as_str(), "odd_detector::as_a_detector", "--exact", "--nocapture", behaviour];
    workplace.write("scanbench.toml", &format!("[detector.odd]\ncommand = {words:?}\n{more}\n"));
    workplace
}

fn run_odd(workplace: &Workplace, more: &str) -> Ended {
    workplace.run(&("run street -d odd,simple-grid", QUIET, more))
}

/// Whether processes with `word` among their arguments run.
fn is_running(word: &str) -> bool {
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let mut command_lines = processes.filter_map(|it| std::fs::read(it.path().join("cmdline")).ok());
    command_lines.any(|it| it.split(|byte| *byte == 0).any(|it| it == word.as_bytes()))
}

#[track_caller]
fn check_gone(word: &str) {
    let ends = Instant::now() + Duration::from_secs(20);
    while is_running(word) {
        assert!(Instant::now() < ends, "{word} is still running");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// `behaviour` ends a run with exit code 6 and a sentence that has `expected`, and loses no earlier scan.
#[track_caller]
fn check_misbehaviour(behaviour: &str, expected: &str) -> Workplace {
    let workplace = workplace_with(behaviour, "time_limit_s = 0.5");
    let stopped = run_odd(&workplace, "");
    stopped.check_refusal(6, &["the detector \"odd\" failed at scan", expected]);
    assert!(workplace.read("out.unfinished/scans.csv").lines().count() > 1, "{behaviour}");
    assert!(!workplace.path("out").exists());
    check_gone(behaviour);
    workplace
}

/// The same; where failures are skipped, one scan counts as nothing found, and nothing else is different.
#[track_caller]
fn check_skipped(behaviour: &str, expected: &str) {
    let workplace = check_misbehaviour(behaviour, expected);
    std::fs::remove_file(workplace.path("misbehaved")).unwrap();
    let skipped = run_odd(&workplace, "--on-detector-failure skip");
    assert_eq!(skipped.exit_code, Some(0), "{behaviour}: {skipped:#?}");
    let rows = workplace.table("out/scans.csv");
    let of_objects = rows.iter().filter(|it| it["task"] == "objects");
    let failed: Vec<_> = of_objects.clone().filter(|it| it["status"] == "failed").collect();
    assert_eq!((of_objects.count(), failed.len()), (2 * N_SCANS as usize, 1), "{behaviour}: {rows:?}");
    assert_eq!(failed[0]["detector"], "odd");
    assert_eq!(skipped.stdout, "out\n");
    let said = format!("odd gave no answer to 1 of {N_SCANS} scans, which count as nothing found.");
    workplace.check_file("out/table_objects.md", &[&said]);
    let reported =
        format!("odd failed at 1 of {N_SCANS} scans. They count as nothing found. The first was street");
    workplace.check_file("out/report.html", &[&reported]);
    let judged = workplace.run("gate out --baseline out");
    judged.check_stdout(&[&format!("odd failed on 1 of {N_SCANS} scans.")]);
    // Nothing of a failed scan is a mistake about its objects.
    let matches = workplace.read("out/matches.csv");
    let with_reason = matches.lines().filter(|it| it.contains(",detector failed,"));
    let scans: BTreeSet<&str> = with_reason.map(|it| it.split(',').nth(2).unwrap()).collect();
    assert_eq!(scans.len(), 1, "{behaviour}: {scans:?}");
    check_gone(behaviour);
}

#[test]
fn one_failure_of_each_kind_is_skipped_and_counted() {
    check_skipped("exit", "it ended with exit code 3");
    check_skipped("silent", "it gave no whole answer to scan within 0.5 s");
    check_skipped("nan", "not all of them finite");
    // Noticed before the next scan, which is skipped.
    check_skipped("too-much", "it says more than it was asked");
}

/// A workplace with a detector that looks for labels and for the network, and has `more` in its table. The labels lie
/// elsewhere, where a link in the data set leads.
struct Peeking {
    workplace: Workplace,
    _listener: TcpListener,
}

impl Peeking {
    fn new(more: &str) -> Self {
        let workplace = workplace_with("peek", more);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        workplace.write("port", &listener.local_addr().unwrap().port().to_string());
        workplace.write("runs/earlier/matches.csv", "labels\n");
        let (labels, elsewhere) = (workplace.path("street/training/label_02"), workplace.path("elsewhere"));
        std::fs::rename(&labels, &elsewhere).unwrap();
        std::os::unix::fs::symlink(elsewhere, labels).unwrap();
        Self { workplace, _listener: listener }
    }

    /// What the detector finds in `command`; `None` if this system lets its users build no sandbox.
    #[track_caller]
    fn found_in(&self, command: &(impl Words + ?Sized)) -> Option<BTreeSet<String>> {
        let ended = self.workplace.run(command);
        if is_refused_by_system(&ended) {
            return None;
        }
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        let found = self.workplace.read("found");
        // What an earlier command has found is not what the next one finds.
        std::fs::remove_file(self.workplace.path("found")).unwrap();
        let lines: Vec<_> = found.lines().filter_map(|it| it.split_once(' ')).collect();
        assert_eq!(lines.iter().map(|it| it.0).collect::<Vec<_>>(), EVERYTHING);
        Some(lines.iter().filter(|it| it.1 == "true").map(|it| it.0.to_owned()).collect())
    }

    /// The detector finds `expected` in `command`. False if this system lets its users build no sandbox.
    #[track_caller]
    fn check(&self, command: &(impl Words + ?Sized), expected: &[&str]) -> bool {
        let found = self.found_in(command);
        if let Some(found) = &found {
            assert_eq!(*found, set_of(expected), "{:?}", command.words());
        }
        found.is_some()
    }
}

fn set_of(words: &[&str]) -> BTreeSet<String> {
    words.iter().map(|it| (*it).to_owned()).collect()
}

/// What a detector that peeks looks for.
const EVERYTHING: [&str; 5] =
    ["network", "street/training/label_02/0000.txt", "elsewhere/0000.txt", "runs/earlier/matches.csv", "out"];

/// Whether `ended` is the refusal of a system that lets its users build no sandbox, as programs of others find, too. Says that
/// the test is skipped then.
fn is_refused_by_system(ended: &Ended) -> bool {
    let is_refused =
        ended.exit_code == Some(6) && ended.stderr.contains("this system lets its users build no sandbox (");
    let of_others =
        ["--user", "--map-root-user", "--mount", "--net", "mount", "-t", "tmpfs", "tmpfs", "/tmp"];
    let by_others = || Command::new("unshare").args(of_others).output();
    let is_skipped = is_refused && !by_others().is_ok_and(|it| it.status.success());
    if is_skipped {
        // Past the test's own output, which is not shown.
        let _ = writeln!(std::io::stderr(), "skipped a test of --sandbox: {}", ended.stderr.trim());
    }
    is_skipped
}

#[test]
fn a_sandbox_keeps_labels_and_network_from_a_detector_that_looks_for_them() {
    let run = ("run street -d odd,simple-grid", QUIET);
    let [open, walled] = [Peeking::new(""), Peeking::new("")];
    assert_eq!(open.found_in(&run), Some(set_of(&EVERYTHING)));
    if !walled.check(&(run, "--sandbox"), &[]) {
        return;
    }
    // It gets the points all the same, and what it saw is still there for others.
    let [open, walled] = [open, walled].map(|it| it.workplace);
    let [open_rows, walled_rows] = [&open, &walled].map(|it| it.read("out/matches.csv"));
    assert!(open_rows == walled_rows && open_rows.lines().count() > 1, "{walled_rows}");
    assert!(walled.path("street").read_dir().unwrap().count() > 0);
    let sandbox = |it: &Workplace| it.json("out/manifest.json")["detectors"][0]["foreign"]["sandbox"].clone();
    assert_eq!((sandbox(&open), sandbox(&walled)), (serde_json::Value::Null, true.into()));
}

#[test]
fn a_sandbox_hides_results_in_the_making_wherever_they_are() {
    let results = "--mcap --detections-out outside --as csv";
    let recorded = if cfg!(feature = "viewer") { "--save-rrd=out.rrd" } else { "--no-rrd" };
    let run = ("run street -d odd,simple-grid -q -o out", results, recorded);
    assert_eq!(Peeking::new("").found_in(&run), Some(set_of(&EVERYTHING)));
    Peeking::new("").check(&(run, "--sandbox"), &[]);
}

#[test]
fn a_sandbox_is_one_in_every_command() {
    let parameters = "parameters = { most = 3 }";
    let [open, walled] = ["", "sandbox = true\n"].map(|it| Peeking::new(&format!("{it}{parameters}")));
    let sweep = "sweep street -d odd -P odd.most=1:3:1 --timed-scans 1 --jobs 1 --no-rrd -q -o out";
    let gaps = "gaps -d odd,simple-grid --pairs 1 --sensor vlp-16 -q -o out --overwrite";
    // The data set is no part of the gaps.
    for (command, seen, seen_all_the_same) in [
        ("detect street/training/velodyne/0000/000000.bin -d odd", 0..4, 0..0),
        ("detect street --scan 0 -d odd", 0..4, 0..0),
        (sweep, 0..5, 0..0),
        (gaps, 0..5, 1..3),
    ] {
        assert_eq!(open.found_in(command), Some(set_of(&EVERYTHING[seen])), "{command}");
        walled.check(command, &EVERYTHING[seen_all_the_same]);
    }
}

#[test]
fn a_detector_that_is_added_to_a_run_or_seen_again_is_in_the_sandbox_as_well() {
    for (sandbox, seen) in [("", &EVERYTHING[..]), ("--sandbox", &[])] {
        let peeking = Peeking::new("");
        let workplace = &peeking.workplace;
        workplace.succeed(&("run street -d pca", QUIET));
        if !peeking.check(&("run --add-to out -d odd --no-rrd -q", sandbox), seen) {
            return;
        }
        let manifest = workplace.json("out/manifest.json");
        let is_walled_in = manifest["detectors"][1]["foreign"]["sandbox"] == true;
        let words = manifest["argv"].as_array().unwrap();
        assert_eq!([is_walled_in, words.contains(&"--sandbox".into())], [!sandbox.is_empty(); 2]);
        if cfg!(feature = "viewer") {
            peeking.check("view out --task objects -d odd --worst 1", seen);
        }
        // What is added next is in it without being asked, and may be no program.
        workplace.succeed("run --add-to out -d simple-grid --no-rrd -q");
        workplace.refuse("run --add-to out -d kd-tree --sandbox", 2, &["--sandbox is for programs"]);
        let table = workplace.read("scanbench.toml");
        workplace
            .write("scanbench.toml", &(table.clone() + &table.replace("detector.odd", "detector.other")));
        peeking.check("run --add-to out -d other --no-rrd -q", seen);
    }
}

#[test]
fn a_sandbox_that_would_hide_the_detector_or_is_for_none_is_refused() {
    let workplace = workplace_with("fine", "sandbox = true");
    std::fs::create_dir(workplace.path("street/training/mine")).unwrap();
    std::fs::rename(workplace.path("scanbench.toml"), workplace.path("street/training/mine/scanbench.toml"))
        .unwrap();
    let refused = workplace.run(&("run street -d odd -c street/training/mine/scanbench.toml", QUIET));
    refused.check_refusal(6, &["street/training/mine would be hidden from it by sandbox"]);
    workplace.refuse(
        &("run street -d pca --sandbox", QUIET),
        2,
        &["--sandbox is for programs of scanbench.toml"],
    );
}

#[test]
fn crashes_errors_silence_and_broken_answers_are_reported() {
    for (behaviour, expected) in [
        ("abort", "it was ended by signal 6"),
        ("error", "it reports an error: out of ideas"),
        ("end", "it ended with exit code 0"),
        ("half", "it gave no whole answer to scan within 0.5 s"),
        ("half-and-end", "it ended with exit code 4"),
        ("stdout", "result to the wrong place"),
        ("too-few-ids", "payload_bytes is"),
        ("huge", "the size [100000.0"),
        ("another-number", "it is to scan number 4711"),
        ("no-json", "a line is not JSON"),
        ("endless-line", "a line is longer than 1 MiB"),
    ] {
        check_misbehaviour(behaviour, expected);
    }
}

#[test]
fn what_ends_a_run_is_reported_and_nobody_waits_for_orphans() {
    let skip = "--on-detector-failure skip";
    for (behaviour, more, options, expected) in [
        // What cannot begin ends it whatever the rule.
        ("silent-start", "start_limit_s = 0.5", skip, &["it gave no whole answer to hello within 0.5 s"][..]),
        ("another-protocol", "", skip, &["it speaks protocol 99, not 1"]),
        ("error-configure", "", skip, &["it reports an error: never heard of it"]),
        ("always", "", skip, &["it ended with exit code 3"]),
        ("exit-255", "", "", &["it ended with exit code 255"]),
        ("exit-126", "", "", &["it ended with exit code 126"]),
        // The detector lives on, silent, and has the pipe.
        ("kill-supervisor", "time_limit_s = 0.5", "", &["it gave no whole answer"]),
        ("exit", "", "", &["last lines that it printed:\n", "  my last words"]),
    ] {
        let workplace = workplace_with(behaviour, more);
        run_odd(&workplace, options).check_refusal(6, expected);
        check_gone(behaviour);
    }
    let workplace = Workplace::with_drive(1);
    workplace.write("scanbench.toml", "[detector.odd]\ncommand = [\"./nowhere\"]");
    run_odd(&workplace, skip).check_refusal(6, &["cannot be started: No such file"]);
}

#[test]
fn what_does_not_end_a_run_is_warned_of() {
    for (behaviour, options, warning) in [
        ("exit-at-first", "--on-detector-failure skip", ""),
        ("deaf-to-quit", "", "did not end within 2 s"),
        ("child", "", "left 1 processes behind"),
    ] {
        let workplace = workplace_with(behaviour, "");
        // Warnings are not for -q.
        workplace
            .succeed(&("run street -d odd,simple-grid --no-rrd -o out", options))
            .check_stderr(&[warning]);
        check_gone(behaviour);
    }
}

#[test]
fn nothing_is_left_behind_whatever_ends_us() {
    for (signal, exit_code) in [("KILL", None), ("INT", Some(130)), ("TERM", Some(143))] {
        let behaviour = format!("immortal-{signal}");
        let workplace = workplace_with(&behaviour, "time_limit_s = 100");
        let run = workplace.start(&("run street -d odd", QUIET));
        let ends = Instant::now() + Duration::from_secs(20);
        while !workplace.path("asked").exists() {
            assert!(Instant::now() < ends, "it was never asked");
            std::thread::sleep(Duration::from_millis(20));
        }
        let pid = run.id().to_string();
        Command::new("kill").args(["-s", signal, &pid]).status().unwrap();
        let ended = run.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), exit_code, "{ended:?}");
        check_gone(&behaviour);
        let names = workplace.top_names();
        let there = |name: &str| names.iter().any(|it| it == name);
        assert!(there("out.unfinished") && !there("out"), "{names:?}");
    }
}

/// Tasks of detectors that are built in, as columns.
const TASKS: [&str; 4] = [",objects,points,", ",vehicles,points,", ",pedestrian,points,", ",cyclist,points,"];

#[test]
fn what_is_served_finds_the_same() {
    let workplace = Workplace::new();
    let served = env!("CARGO_BIN_EXE_scanbench");
    let names = ["hierarchical", "paper", "kd-tree", "pca", "simple-grid"];
    let tables = names.map(|it| format!("[detector.x-{it}]\ncommand = [{served:?}, \"serve\", {it:?}]\n"));
    workplace.write("scanbench.toml", &tables.concat());
    let both: Vec<String> = names.iter().flat_map(|it| [format!("x-{it}"), (*it).to_owned()]).collect();
    let streets = "run street-main-road --simulated-scans 2 --sensor vlp-16 --protocol nuscenes -d";
    workplace.succeed(&(streets, &both.join(","), QUIET));
    for (file, least) in [("out/matches.csv", 20), ("out/protocol_boxes.csv", 4)] {
        let rows = workplace.read(file);
        for name in names {
            let of = |name: &str| -> Vec<String> {
                let rows = rows.lines().filter(|it| it.contains(&format!(",{name},")));
                // A served detector may give any class, so that all are judged.
                let rows =
                    rows.filter(|it| !it.contains(",points,") || TASKS.iter().any(|task| it.contains(task)));
                let rows = rows.map(|it| it.replacen(name, "", 1));
                // The stage at which an object was lost is known here only of those that are built in.
                rows.map(|it| it.split_once(",missed,").map_or(it.clone(), |(found, _)| found.to_owned()))
                    .collect()
            };
            assert!(of(name).len() > least, "{name} in {file}");
            assert_eq!(of(&format!("x-{name}")), of(name), "{name} in {file}");
        }
    }
    // What is only ranked is more than what is found.
    let n_rows = |file: &str, part: &str| workplace.read(file).lines().filter(|it| it.contains(part)).count();
    let n_ranked = n_rows("out/protocol_boxes.csv", ",x-hierarchical,");
    let n_found = n_rows("out/matches.csv", ",x-hierarchical,vehicles,");
    assert!(n_ranked > n_found, "{n_ranked} and {n_found}");
    workplace.check_file("out/manifest.json", &["\"reported_name\": \"kd-tree\""]);
}

#[test]
fn a_served_detector_is_asked_by_every_verb_that_takes_detectors() {
    let workplace = workplace_with("fine", "parameters = { most = 3 }");
    workplace.succeed("sweep street -d odd -P odd.most=1:3:1 --timed-scans 1 -q -o sweep");
    let sweep = workplace.read("sweep/sweep.csv");
    assert!(sweep.contains("detector.odd.most") && sweep.lines().count() > 6, "{sweep}");
    let points =
        (0..200_u16).flat_map(|it| [4.0 + f32::from(it) * 0.01, 2.0, -1.0, 0.5]).flat_map(f32::to_le_bytes);
    workplace.write("scan.bin", &points.collect::<Vec<u8>>());
    workplace.succeed("detect scan.bin -d odd -P most=2").check_stdout(&["odd: 2 clusters of"]);
    workplace.succeed("gaps -d odd,simple-grid --pairs 1 --sensor vlp-16 -q -o gaps");
    assert_eq!(workplace.run("boxes -d odd").exit_code, Some(2));
    let both = workplace.read("scanbench.toml") + "[detector.served]\ncommand = [\"true\"]\n";
    workplace.write("scanbench.toml", &both);
    workplace.refuse("run -d odder", 2, &["there is no detector \"odder\"", "odd, served"]);
}

#[test]
fn lasers_and_times_of_points_are_sent_where_the_data_have_them() {
    let workplace = workplace_with("by-ring-and-time", "");
    let with = crate::readers::argoverse2::drawn().display().to_string();
    workplace.succeed(&["detect", &with, "--scan", "0", "-d", "odd"]);
    let without =
        workplace.end_with("detect street-narrow --sensor vlp-16 --scan narrow-803595/000000 -d odd", 6, &[]);
    assert!(
        without.stderr.contains("ring") && !without.stderr.contains("time_offset_s"),
        "{}",
        without.stderr
    );
}

/// A catalogue of two simulated drives of four scans, a tenth of a second apart, and a detector `odd`.
fn workplace_with_drives(behaviour: &str) -> Workplace {
    let workplace = workplace_with(behaviour, "parameters = { most = 1 }");
    let street =
        "[simulated.drives]\nstreet = \"street-main-road\"\nseed = 9001\nn_scans = 8\nturns_per_scan = 1\n";
    workplace.write("mine.toml", &format!("{street}scans_per_drive = 4\nsensor = \"vlp-16\"\n"));
    workplace
}

/// Of each scan the track and the velocity of its detections, of which there are as many as the track says.
fn motions(workplace: &Workplace, run: &str) -> Vec<(usize, String)> {
    let mut reader = csv::Reader::from_path(workplace.path(run).join("matches.csv")).unwrap();
    let mut of_scans: BTreeMap<(String, u32), Vec<(usize, String)>> = BTreeMap::new();
    for row in reader.deserialize().map(|it| -> BTreeMap<String, String> { it.unwrap() }) {
        if row["detector"] == "odd" && row["task"] == "objects" && !row["detection_id"].is_empty() {
            let velocity = ["x", "y"].map(|it| row[&format!("detection_velocity_{it}_m_per_s")].clone());
            let motion = (row["detection_track"].parse().unwrap(), velocity.join(" "));
            of_scans.entry((row["sequence"].clone(), row["scan"].parse().unwrap())).or_default().push(motion);
        }
    }
    let same = |it: Vec<(usize, String)>| {
        assert!(it.iter().all(|other| *other == it[0]) && it.len() == it[0].0, "{it:?}");
        it[0].clone()
    };
    of_scans.into_values().map(same).collect()
}

#[test]
fn scans_of_a_drive_come_in_order_with_those_before_whatever_part_is_run() {
    let workplace = workplace_with_drives("remembers");
    let run = "run drives --catalogue mine.toml --no-rrd -q";
    workplace.succeed(&format!("{run} -d odd,simple-grid --warmup 3 --repeats 2 -o whole"));
    let of_drive = [(1, "0.0000 0.0000"), (2, "1.0000 0.1000"), (3, "2.0000 0.1000"), (4, "2.0000 0.1000")];
    let expected: Vec<(usize, String)> =
        of_drive.iter().chain(&of_drive).map(|(n, it)| (*n, (*it).to_owned())).collect();
    assert_eq!(motions(&workplace, "whole"), expected);
    // Every scan is timed once, and after the warm-up.
    let mut reader = csv::Reader::from_path(workplace.path("whole/scans.csv")).unwrap();
    for row in reader.deserialize().map(|it| -> BTreeMap<String, String> { it.unwrap() }) {
        let is_timed_once = row["latency_ms"] == row["least_latency_ms"] && !row["latency_ms"].is_empty();
        assert!(is_timed_once || row["detector"] != "odd", "{row:?}");
    }
    for shard in 1..=3 {
        workplace.succeed(&format!("{run} -d odd,simple-grid --shard {shard}/3 -o parts"));
    }
    merge_whole(&workplace, "parts", "merged");
    assert_eq!(motions(&workplace, "merged"), expected);
    // Scans that are not selected are not remembered, but they are among those before.
    workplace.succeed(&format!("{run} -d odd --scans 1..8:2 -o some"));
    let some = motions(&workplace, "some");
    let expected: Vec<(usize, String)> = [(1, "1.0000 0.1000"), (2, "2.0000 0.1000")]
        .iter()
        .cycle()
        .take(4)
        .map(|(n, it)| (*n, (*it).to_owned()))
        .collect();
    assert_eq!(some, expected);
}

#[test]
fn what_a_detector_asks_for_and_the_data_lack_is_said() {
    let workplace = workplace_with_drives("remembers");
    let refuse = |workplace: &Workplace, arguments: &str, expected: &str| {
        workplace.end_with(arguments, 6, &[]).check_refusal(6, &["the detector \"odd\" failed", expected]);
    };
    refuse(
        &workplace,
        "detect drives --catalogue mine.toml --scan main-road-9001/000000 -d odd",
        "asks for the scans of a drive in order, which `scanbench run` alone gives",
    );
    let workplace = workplace_with_drives("looks-back");
    workplace.succeed("sweep drives --catalogue mine.toml -d odd -P most=1:2:1 --no-rrd -q");
    refuse(
        &workplace,
        "run street -d odd --no-rrd -q",
        "asks for 2 earlier scans in the frame of each, and street",
    );
    refuse(
        &workplace_with_drives("looks-far-back"),
        "run street -d odd --no-rrd -q",
        "asks for 101 earlier scans, more than 100",
    );
}
