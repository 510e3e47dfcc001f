//! Ctrl-C and requests to terminate: whatever the program is doing, it ends soon and leaves nothing half-written.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::io::Write as _;
#[cfg(feature = "viewer")]
use std::process::Stdio;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

#[cfg(feature = "viewer")]
use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

/// A second, and what a busy machine takes to notice.
const SOON: Duration = Duration::from_millis(2500);
/// What a busy machine takes to notice, and to remove what is unfinished.
const AT_ONCE: Duration = Duration::from_millis(1500);

const ENDLESS_STREET: [&str; 3] = ["street-narrow", "--simulated-scans", "100000"];

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}

/// Waits until the program would hear of an interruption.
fn wait_until_it_listens(child: &Child) {
    const SIGTERM: u32 = 15;
    let started = Instant::now();
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|it| it.strip_prefix("SigCgt:")).unwrap();
        if u64::from_str_radix(caught.trim(), 16).unwrap() >> (SIGTERM - 1) & 1 == 1 {
            return;
        }
        assert!(started.elapsed() < Duration::from_mins(1), "it never listens");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Starts the program, lets it work for `pause`, sends it the signals a moment apart, and returns how it ended, and how long
/// after the last signal.
fn interrupted(
    workplace: &Workplace,
    arguments: &[&str],
    pause: Duration,
    signals: &[&str],
) -> (Ended, Duration) {
    let child = workplace.start(arguments);
    wait_until_it_listens(&child);
    std::thread::sleep(pause);
    for (signal_idx, signal) in signals.iter().enumerate() {
        if signal_idx > 0 {
            std::thread::sleep(Duration::from_millis(20));
        }
        send(&child, signal);
    }
    let sent = Instant::now();
    let ended = Ended::from(child.wait_with_output().unwrap());
    (ended, sent.elapsed())
}

/// One signal of each kind, and two: it ends in time with the signal's code, and only `left` is there.
#[track_caller]
fn check(workplace: &Workplace, arguments: &[&str], left: &[&str]) {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for (signals, exit_code, limit) in [
        (&["-INT"][..], 130, SOON),
        (&["-TERM"], 143, SOON),
        (&["-INT", "-INT"], 130, AT_ONCE),
        (&["-TERM", "-TERM"], 143, AT_ONCE),
    ] {
        let pause = Duration::from_millis(random.random_range(50..500));
        let (ended, time) = interrupted(workplace, arguments, pause, signals);
        let said = format!("{arguments:?} and {signals:?} after {pause:?}: {time:?}, {ended:#?}");
        assert_eq!(ended.exit_code, Some(exit_code), "{said}");
        assert!(time < limit, "{said}");
        assert!(ended.stderr.contains("error: interrupted"), "{said}");
        let names = workplace.top_names();
        // What has not begun leaves nothing to go on with.
        assert!(names.iter().all(|it| left.contains(&it.as_str())), "{names:?}: {said}");
    }
}

#[track_caller]
fn check_on_a_street(verb: &[&str], more: &[&str], left: &[&str]) {
    check(&Workplace::new(), &[verb, &ENDLESS_STREET, more].concat(), left);
}

#[test]
fn a_run_ends_soon() {
    check_on_a_street(&["run"], &["--mcap", "-o", "deep/out"], &[]);
    check_on_a_street(&["run"], &[], &[]);
    check_on_a_street(&["run"], &["-o", "out"], &["out.unfinished"]);
}

#[test]
fn a_sweep_ends_soon_and_keeps_what_is_done() {
    let more = ["-P", "cell_size_m=0.4:0.8:0.2", "-o", "out"];
    check_on_a_street(&["sweep"], &more, &["out.unfinished"]);
    // Ended in the middle of a result as well.
    let workplace = Workplace::new();
    write_dense_scan(&workplace);
    let sweep = ["sweep", "dense", "-d", "kd-tree", "-P", "foreground=all", "-L", "tolerance_m=0.5,0.6"];
    let (ended, time) = interrupted(
        &workplace,
        &[&sweep[..], &["-o", "out"]].concat(),
        Duration::from_millis(1500),
        &["-INT"],
    );
    assert!(time < SOON && ended.exit_code == Some(130), "{time:?}, {ended:#?}");
    assert!(
        ended
            .stderr
            .contains("is kept in out.unfinished: to go on with the others, give the same command again"),
        "{ended:#?}"
    );
    assert_eq!(workplace.top_names(), ["dense", "out.unfinished"]);
}

#[test]
fn experiments_end_soon() {
    check_on_a_street(&["ablation"], &["-o", "out"], &["out.unfinished"]);
    check_on_a_street(&["boxes"], &["-o", "out"], &[]);
    check_on_a_street(&["selftest"], &[], &[]);
    check(&Workplace::new(), &["gaps", "--pairs", "1000", "-o", "out"], &[]);
    check(&Workplace::new(), &["robustness", "--scans", "1000", "-o", "out"], &["out.unfinished"]);
}

#[test]
fn verbs_about_data_end_soon() {
    check_on_a_street(&["data", "check"], &[], &[]);
    check_on_a_street(&["data", "realism"], &["--against", "street-main-road", "-o", "out"], &[]);
    for (format, output) in [("mcap", "out.mcap"), ("kitti-tracking", "out"), ("semantic-kitti", "out")] {
        check_on_a_street(&["data", "simulate"], &["--to", format, "-o", output], &[]);
    }
    let several =
        ["data", "simulate", "streets", "--simulated-scans", "1000", "--to", "mcap", "-o", "deep/out"];
    check(&Workplace::new(), &several, &[]);
    check(&Workplace::new(), &["init", "deep/mine"], &[]);
    check_on_a_street(&["data", "prelabel"], &["--to", "labelcloud", "-o", "out"], &[]);
}

#[test]
fn training_ends_soon() {
    let streets = ["streets", "--seed", "7", "--simulated-scans", "1000"];
    for model in ["groupings", "rivals", "paper"] {
        check(&Workplace::new(), &[&["train", model][..], &streets, &["-o", "out"]].concat(), &[]);
    }
    check(&Workplace::new(), &[&["fit-density"][..], &ENDLESS_STREET, &["-o", "out.toml"]].concat(), &[]);
}

/// A data set `dense` of one scan of five million points, among which a kd-tree searches for minutes.
fn write_dense_scan(workplace: &Workplace) {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut bytes = Vec::with_capacity(5_000_000 * 16);
    for _ in 0..5_000_000 {
        for half_side_m in [20.0_f32, 20.0, 1.0] {
            bytes.extend(random.random_range(-half_side_m..half_side_m).to_le_bytes());
        }
        bytes.extend(0.5_f32.to_le_bytes());
    }
    std::fs::create_dir(workplace.path("dense")).unwrap();
    std::fs::write(workplace.path("dense/000000.bin"), bytes).unwrap();
}

#[test]
fn the_kd_tree_ends_soon_in_the_middle_of_five_million_points() {
    let workplace = Workplace::new();
    write_dense_scan(&workplace);
    let detect =
        ["detect", "dense/000000.bin", "-d", "kd-tree", "-P", "foreground=all", "-o", "clusters.u32"];
    check(&workplace, &detect, &["dense"]);
    for signals in [&["-INT"][..], &["-TERM", "-INT"]] {
        let (ended, time) = interrupted(&workplace, &detect, Duration::from_secs(3), signals);
        assert!(ended.exit_code.is_some_and(|it| it > 128) && time < SOON, "{time:?}, {ended:#?}");
        assert_eq!(workplace.top_names(), ["dense"]);
    }
}

#[test]
fn a_reader_that_waits_for_ever_ends_soon() {
    let workplace = Workplace::new();
    // A pipe into which nobody writes.
    assert!(Command::new("mkfifo").arg(workplace.path("scan.bin")).status().unwrap().success());
    check(&workplace, &["detect", "scan.bin"], &["scan.bin"]);
}

#[test]
fn a_result_that_nobody_takes_ends_soon() {
    let workplace = Workplace::new();
    let mut points = std::fs::File::create(workplace.path("many.bin")).unwrap();
    points.write_all(&vec![0; 16 * 200_000]).unwrap();
    for signals in [&["-TERM"][..], &["-TERM", "-TERM"]] {
        let mut command = workplace.command(&["detect", "many.bin", "-o", "-"]);
        let (full, writer) = std::io::pipe().unwrap();
        command.stdout(writer.try_clone().unwrap()).stderr(writer);
        let mut child = command.spawn().unwrap();
        drop(command);
        wait_until_it_listens(&child);
        std::thread::sleep(Duration::from_millis(500));
        assert!(child.try_wait().unwrap().is_none(), "it is not stuck");
        for signal in signals {
            send(&child, signal);
        }
        let sent = Instant::now();
        assert_eq!(child.wait().unwrap().code(), Some(143));
        assert!(sent.elapsed() < SOON, "{:?}", sent.elapsed());
        drop(full);
    }
}

#[cfg(feature = "viewer")]
#[test]
fn a_request_to_terminate_ends_serving_and_the_run_is_there() {
    use std::io::{BufRead as _, BufReader};

    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 2);
    let mut command = workplace.command(&["run", "street", "-d", "pca", "-o", "out", "--serve=0"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|it| it.starts_with("Serving the recording until Ctrl-C")));
    send(&child, "-TERM");
    let sent = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(sent.elapsed() < SOON, "{:?}", sent.elapsed());
    assert!(workplace.path("out/report.json").is_file());
    assert_eq!(workplace.top_names(), ["out", "street"]);
}
