//! Detectors that are programs of their own: served ones, and ones that misbehave in every way that the protocol names.
//!
//! The misbehaving program is this test program itself: asked for the one test [`as_a_detector`], it behaves as its
//! arguments say.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use evaluation::process::message::{Answer, Introduction, Question, ResultLine, line_of, parse_line};

use crate::program::{Ended, Workplace};

const QUIET: &str = "--no-rrd -q -o out";
/// The scan at which they misbehave, from 1: warmed up on the first before.
const GUILTY: u64 = 5;

/// A drawn drive of eleven scans and a detector `odd` that behaves as `behaviour` says.
fn workplace_with(behaviour: &str, more: &str) -> Workplace {
    let workplace = Workplace::with_drive(11);
    let program = std::env::current_exe().unwrap().display().to_string();
    let words = [program.as_str(), "foreign_detectors::as_a_detector", "--exact", "--nocapture", behaviour];
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

/// `behaviour` ends a run with exit code 6 and a sentence that has `expected`, and loses no earlier scan; with `skip`, one
/// scan counts as nothing found, and nothing else is different.
#[track_caller]
fn check_misbehaviour(behaviour: &str, expected: &str) {
    let workplace = workplace_with(behaviour, "time_limit_s = 0.5");
    let stopped = run_odd(&workplace, "");
    stopped.check_refusal(6, &["the detector \"odd\" failed at scan", expected]);
    assert!(workplace.read("out.unfinished/scans.csv").lines().count() > 1, "{behaviour}");
    assert!(!workplace.path("out").exists());

    std::fs::remove_file(workplace.path("misbehaved")).unwrap();
    let skipped = run_odd(&workplace, "--on-detector-failure skip");
    assert_eq!(skipped.exit_code, Some(0), "{behaviour}: {skipped:#?}");
    let rows = workplace.table("out/scans.csv");
    let of_objects = rows.iter().filter(|it| it["task"] == "objects");
    let failed: Vec<_> = of_objects.clone().filter(|it| it["status"] == "failed").collect();
    assert_eq!((of_objects.count(), failed.len()), (22, 1), "{behaviour}: {rows:?}");
    assert_eq!(failed[0]["detector"], "odd");
    assert_eq!(skipped.stdout, "out\n");
    let said = "odd gave no answer to 1 of 11 scans, which count as nothing found.";
    workplace.check_file("out/table_objects.md", &[said]);
    let reported = "odd failed at 1 of 11 scans. They count as nothing found. The first was street";
    workplace.check_file("out/report.html", &[reported]);
    // Nothing of a failed scan is a mistake about its objects.
    let matches = workplace.read("out/matches.csv");
    let with_reason = matches.lines().filter(|it| it.contains(",detector failed,"));
    let scans: BTreeSet<&str> = with_reason.map(|it| it.split(',').nth(2).unwrap()).collect();
    assert_eq!(scans.len(), 1, "{behaviour}: {scans:?}");
    check_gone(behaviour);
}

#[test]
fn crashes_and_errors_are_reported_and_counted() {
    for (behaviour, expected) in [
        ("exit", "it ended with exit code 3"),
        ("abort", "it was ended by signal 6"),
        ("error", "it reports an error: out of ideas"),
        ("end", "it ended with exit code 0"),
    ] {
        check_misbehaviour(behaviour, expected);
    }
}

#[test]
fn silence_is_not_waited_for() {
    for (behaviour, expected) in [
        ("silent", "it gave no whole answer to scan within 0.5 s"),
        ("half", "it gave no whole answer to scan within 0.5 s"),
        ("half-and-end", "it ended with exit code 4"),
        ("stdout", "result to the wrong place"),
    ] {
        check_misbehaviour(behaviour, expected);
    }
}

#[test]
fn answers_that_break_the_protocol_are_refused() {
    for (behaviour, expected) in [
        ("too-few-ids", "payload_bytes is"),
        ("nan", "not all of them finite"),
        ("huge", "the size [100000.0"),
        ("another-number", "it is to scan number 4711"),
        ("no-json", "a line is not JSON"),
        ("endless-line", "a line is longer than 1 MiB"),
        // Noticed before the next scan, which is skipped.
        ("too-much", "it says more than it was asked"),
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

#[test]
fn what_is_served_finds_the_same() {
    let workplace = Workplace::new();
    let served = env!("CARGO_BIN_EXE_scanbench");
    let names = ["hierarchical", "paper", "kd-tree", "pca", "simple-grid"];
    let tables = names.map(|it| format!("[detector.x-{it}]\ncommand = [{served:?}, \"serve\", {it:?}]\n"));
    workplace.write("scanbench.toml", &tables.concat());
    let both: Vec<String> = names.iter().flat_map(|it| [format!("x-{it}"), (*it).to_owned()]).collect();
    workplace.succeed(&("run street-narrow --simulated-scans 3 --sensor vlp-16 -d", &both.join(","), QUIET));
    let matches = workplace.read("out/matches.csv");
    for name in names {
        let of = |name: &str| -> Vec<String> {
            let rows = matches.lines().filter(|it| it.contains(&format!(",{name},")));
            rows.map(|it| it.replacen(name, "", 1)).collect()
        };
        assert!(of(name).len() > 100);
        assert_eq!(of(&format!("x-{name}")), of(name), "{name}");
    }
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

/// Not a test unless somebody started it as a detector.
#[test]
fn as_a_detector() {
    let Some(behaviour) =
        std::env::args().next_back().filter(|_| std::env::var_os("SCANBENCH_READ_FD").is_some())
    else {
        return;
    };
    let mut odd = Odd::begin(&behaviour);
    while odd.answer() {}
    std::process::exit(0);
}

/// A detector that takes the first points for small objects, and misbehaves.
struct Odd {
    behaviour: String,
    reading: BufReader<File>,
    writing: File,
    most: usize,
    n_asked: u64,
}

impl Odd {
    fn begin(behaviour: &str) -> Self {
        let end = |name: &str, how: &OpenOptions| {
            how.open(format!("/proc/self/fd/{}", std::env::var(name).unwrap())).unwrap()
        };
        Self {
            behaviour: behaviour.to_owned(),
            reading: BufReader::new(end("SCANBENCH_READ_FD", OpenOptions::new().read(true))),
            writing: end("SCANBENCH_WRITE_FD", OpenOptions::new().write(true)),
            most: 1,
            n_asked: 0,
        }
    }

    fn say(&mut self, bytes: &[u8]) {
        self.writing.write_all(bytes).unwrap();
    }

    /// Answers one question; false at the end.
    fn answer(&mut self) -> bool {
        let mut line = Vec::new();
        if self.reading.read_until(b'\n', &mut line).unwrap() == 0 {
            return self.outlive();
        }
        match parse_line::<Question>(&line).unwrap().0 {
            Question::Hello { .. } => self.hello(),
            Question::Configure(_) if self.behaviour == "error-configure" => {
                let answer = Answer::Error { text: "never heard of it".to_owned() };
                self.say(&line_of(&answer, 0).unwrap());
            }
            Question::Configure(configuration) => {
                let most = configuration.parameters.get("most").and_then(serde_json::Value::as_u64);
                self.most = most.unwrap_or(1) as usize;
                self.say(&line_of(&Answer::Configured, 0).unwrap());
            }
            Question::Scan(scan) => {
                self.n_asked += 1;
                let is_first_life = !std::path::Path::new("misbehaved").exists();
                let guilty = if self.behaviour == "exit-at-first" { 1 } else { GUILTY };
                let is_guilty = self.behaviour == "always" || (self.n_asked == guilty && is_first_life);
                let line = ResultLine { number: scan.number, clusters: true, ..ResultLine::default() };
                let ids: Vec<u8> = (1..=scan.n_points)
                    .flat_map(|it| if it <= self.most { it as u32 } else { 0 }.to_le_bytes())
                    .collect();
                let has =
                    |name: &str, kind: &str| scan.columns.iter().any(|it| it.name == name && it.kind == kind);
                if self.behaviour == "by-ring-and-time"
                    && !(has("ring", "u16") && has("time_offset_s", "f32"))
                {
                    self.say(&line_of(&Answer::Error { text: format!("{:?}", scan.columns) }, 0).unwrap());
                    return true;
                }
                let behaviour = self.behaviour.clone();
                if is_guilty
                    && !["fine", "child", "deaf-to-quit", "by-ring-and-time"].contains(&behaviour.as_str())
                {
                    let _ = File::create("misbehaved");
                    self.misbehave(&behaviour, line, &ids);
                    // A run that stops leaves the next one as guilty as it was.
                    return true;
                }
                self.say(&message(line, &ids));
            }
            Question::Quit => return self.outlive(),
        }
        true
    }

    #[expect(clippy::zombie_processes, reason = "a child is left behind on purpose")]
    fn hello(&mut self) {
        if self.behaviour == "silent-start" {
            std::thread::sleep(Duration::from_secs(100));
        }
        if self.behaviour == "child" {
            let mut child = Command::new("sleep");
            child.args(["100"]).env("LC_ALL", "C").stdin(Stdio::null());
            child.spawn().unwrap();
        }
        let protocol = if self.behaviour == "another-protocol" { 99 } else { 1 };
        let answer = Answer::Hello(Introduction { protocol, name: "odd".to_owned(), version: None });
        self.say(&line_of(&answer, 0).unwrap());
    }

    fn misbehave(&mut self, behaviour: &str, line: ResultLine, ids: &[u8]) {
        let boxed = |numbers: [f32; 7]| {
            let payload: Vec<u8> = numbers.iter().flat_map(|it| it.to_le_bytes()).collect();
            message(ResultLine { clusters: false, n_boxes: 1, ..line.clone() }, &payload)
        };
        match behaviour {
            "exit-255" => std::process::exit(255),
            "exit-126" => std::process::exit(126),
            "kill-supervisor" => {
                let parent = std::os::unix::process::parent_id().to_string();
                Command::new("kill").args(["-s", "KILL", &parent]).status().unwrap();
                std::thread::sleep(Duration::from_secs(100));
            }
            "exit" | "exit-at-first" | "always" => {
                say_aloud("my last words\n");
                std::process::exit(3);
            }
            "abort" => std::process::abort(),
            "error" => self.say(&line_of(&Answer::Error { text: "out of ideas".to_owned() }, 0).unwrap()),
            "end" => std::process::exit(0),
            "silent" => std::thread::sleep(Duration::from_secs(100)),
            "half" => {
                let whole = message(line, ids);
                self.say(&whole[..whole.len() / 2]);
                std::thread::sleep(Duration::from_secs(100));
            }
            "half-and-end" => {
                let whole = message(line, ids);
                self.say(&whole[..whole.len() / 2]);
                std::process::exit(4);
            }
            "stdout" => {
                say_aloud("result to the wrong place\n");
                std::thread::sleep(Duration::from_secs(100));
            }
            "too-few-ids" => self.say(&message(line, &ids[4..])),
            "nan" => self.say(&boxed([8.0, f32::NAN, 0.0, 4.0, 2.0, 1.5, 0.0])),
            "huge" => self.say(&boxed([8.0, 0.0, 0.0, 1e5, 2.0, 1.5, 0.0])),
            "another-number" => self.say(&message(ResultLine { number: 4711, ..line }, ids)),
            "no-json" => self.say(b"here you are\n"),
            "endless-line" => {
                let _ = self.writing.write_all(&vec![b'x'; 3 << 20]);
            }
            "too-much" => self.say(&[message(line, ids), b"more".to_vec()].concat()),
            _ => {
                // Immortal: deaf to the end of its pipe.
                File::create("asked").unwrap();
                loop {
                    std::thread::sleep(Duration::from_secs(100));
                }
            }
        }
    }

    /// What comes after the last question.
    fn outlive(&self) -> bool {
        if self.behaviour == "deaf-to-quit" {
            std::thread::sleep(Duration::from_secs(100));
        }
        false
    }
}

fn say_aloud(words: &str) {
    std::io::stdout().write_all(words.as_bytes()).unwrap();
}

fn message(line: ResultLine, payload: &[u8]) -> Vec<u8> {
    let mut message = line_of(&Answer::Result(line), payload.len()).unwrap();
    message.extend_from_slice(payload);
    message
}
