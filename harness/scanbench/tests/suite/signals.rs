//! Ctrl-C and requests to terminate: whatever the program is doing, it ends soon and leaves nothing half-written.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::program::{Ended, Words, Workplace, send};

/// A second, and what a busy machine takes to notice.
const SOON: Duration = Duration::from_millis(2500);
/// What a busy machine takes to notice, and to remove what is unfinished.
const AT_ONCE: Duration = Duration::from_millis(1500);

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
    arguments: &(impl Words + ?Sized),
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

/// A signal, or two, and of which kind: in turn.
const SIGNALS: [(&[&str], i32, Duration); 4] = [
    (&["-INT"], 130, SOON),
    (&["-TERM", "-TERM"], 143, AT_ONCE),
    (&["-TERM"], 143, SOON),
    (&["-INT", "-INT"], 130, AT_ONCE),
];

/// It ends in time with the code of the `turn`th of the [`SIGNALS`], and only `left` is there.
#[track_caller]
fn check(workplace: &Workplace, arguments: &str, turn: usize, left: &[&str]) {
    let (signals, exit_code, limit) = SIGNALS[turn % SIGNALS.len()];
    let pause = Duration::from_millis(ChaCha8Rng::seed_from_u64(turn as u64).random_range(50..400));
    let (ended, time) = interrupted(workplace, arguments, pause, signals);
    let said = format!("{arguments} and {signals:?} after {pause:?}: {time:?}, {ended:#?}");
    assert_eq!(ended.exit_code, Some(exit_code), "{said}");
    assert!(time < limit, "{said}");
    ended.check_stderr(&["error: interrupted"]);
    let names = workplace.top_names();
    // What has not begun leaves nothing to go on with.
    assert!(names.iter().all(|it| left.contains(&it.as_str())), "{names:?}: {said}");
}

/// The same for each of these commands, in which `ENDLESS` is a street without end, and what each may leave.
#[track_caller]
fn check_each(commands: &[(&str, &[&str])]) {
    for (turn, (command, left)) in commands.iter().enumerate() {
        let arguments = command.replace("ENDLESS", "street-narrow --simulated-scans 100000");
        check(&Workplace::new(), &arguments, turn, left);
    }
}

#[test]
fn runs_and_studies_end_soon() {
    let unfinished = &["out.unfinished"];
    check_each(&[
        ("run ENDLESS --mcap -o deep/out", &[]),
        ("run ENDLESS", &[]),
        ("run ENDLESS -o out", unfinished),
        ("sweep ENDLESS -P cell_size_m=0.4:0.8:0.2 -o out", unfinished),
        ("ablation ENDLESS -o out", unfinished),
        ("robustness --scans 1000 -o out", unfinished),
        ("boxes ENDLESS -o out", &[]),
        ("selftest ENDLESS", &[]),
        ("gaps --pairs 1000 -o out", &[]),
    ]);
}

#[test]
fn verbs_about_data_end_soon() {
    check_each(&[
        ("data check ENDLESS", &[]),
        ("data realism ENDLESS --against street-main-road -o out", &[]),
        ("data simulate ENDLESS --to mcap -o out.mcap", &[]),
        ("data simulate ENDLESS --to kitti-tracking -o out", &[]),
        ("data simulate ENDLESS --to semantic-kitti -o out", &[]),
        ("data simulate streets --simulated-scans 1000 --to mcap -o deep/out", &[]),
        ("data prelabel ENDLESS --to labelcloud -o out", &[]),
        ("init deep/mine", &[]),
    ]);
}

#[test]
fn training_ends_soon() {
    check_each(&[
        ("train groupings streets --seed 7 --simulated-scans 1000 -o out", &[]),
        ("train rivals streets --seed 7 --simulated-scans 1000 -o out", &[]),
        ("train paper streets --seed 7 --simulated-scans 1000 -o out", &[]),
        ("fit-density ENDLESS -o out.toml", &[]),
    ]);
}

/// A data set `dense` of one scan of two million points within reach of each other, among which a kd-tree searches for
/// minutes.
fn with_dense_scan() -> Workplace {
    const N_POINTS: usize = 2_000_000;
    let workplace = Workplace::new();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut bytes = Vec::with_capacity(N_POINTS * 16);
    for _ in 0..N_POINTS {
        for half_side_m in [10.0_f32, 10.0, 1.0] {
            bytes.extend(random.random_range(-half_side_m..half_side_m).to_le_bytes());
        }
        bytes.extend(0.5_f32.to_le_bytes());
    }
    workplace.write("dense/000000.bin", &bytes);
    workplace
}

#[test]
fn the_kd_tree_ends_soon_in_the_middle_of_two_million_points() {
    let workplace = with_dense_scan();
    let detect = "detect dense/000000.bin -d kd-tree -P foreground=all -P neighbors=tree -o clusters.u32";
    let in_the_middle = Duration::from_millis(1500);
    for signals in [&["-INT"][..], &["-TERM", "-INT"]] {
        let (ended, time) = interrupted(&workplace, detect, in_the_middle, signals);
        assert!(ended.exit_code.is_some_and(|it| it > 128) && time < SOON, "{time:?}, {ended:#?}");
        assert_eq!(workplace.top_names(), ["dense"]);
    }
    // A sweep keeps what it has.
    let sweep = "sweep dense -d kd-tree -P foreground=all -P neighbors=tree -L tolerance_m=0.5,0.6 -o out";
    let (ended, time) = interrupted(&workplace, sweep, in_the_middle, &["-INT"]);
    assert!(time < SOON && ended.exit_code == Some(130), "{time:?}, {ended:#?}");
    ended.check_stderr(&["is kept in out.unfinished; to continue, give the same command again"]);
    assert_eq!(workplace.top_names(), ["dense", "out.unfinished"]);
}

#[test]
fn a_reader_that_waits_for_ever_ends_soon() {
    let workplace = Workplace::new();
    // A pipe of settings into which nobody writes, though somebody could.
    let pipe = workplace.path("settings.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let _writer = std::fs::File::options().read(true).write(true).open(&pipe).unwrap();
    for turn in 0..SIGNALS.len() {
        check(&workplace, "run street-narrow -c settings.toml", turn, &["settings.toml"]);
    }
}

#[test]
fn a_result_that_nobody_takes_ends_soon() {
    let workplace = Workplace::new();
    workplace.write("many.bin", &vec![0_u8; 16 * 200_000]);
    for signals in [&["-TERM"][..], &["-TERM", "-TERM"]] {
        let mut command = workplace.command("detect many.bin -o -");
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
fn a_recording_is_served_until_it_is_enough_and_everything_is_written_before() {
    use std::io::{BufRead as _, BufReader};
    use std::process::Stdio;

    for signal in ["-INT", "-TERM"] {
        let workplace = Workplace::with_drive(2);
        let mut command = workplace.command("run street -d pca -o out --serve=0");
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        let url = lines
            .find_map(|it| Some(it.strip_prefix("Serving the recording until Ctrl-C: rerun ")?.to_owned()))
            .unwrap();
        assert!(
            workplace.path("out/recording/layout.rrd").is_file()
                && workplace.path("out/report.json").is_file()
        );
        let address = url.trim_start_matches("rerun+http://").trim_end_matches("/proxy");
        assert!(std::net::TcpStream::connect(address).is_ok(), "nobody listens at {url}");
        send(&child, signal);
        let sent = Instant::now();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{signal}");
        assert!(sent.elapsed() < SOON, "{:?}", sent.elapsed());
        assert_eq!(workplace.top_names(), ["out", "street"]);
    }
}
