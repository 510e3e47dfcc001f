//! Whatever ends the program, and whatever the disk takes: what was asked for is there whole, or what was there before is.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::made::scans;
use super::{open, try_open};
use crate::program::{Ended, Words, Workplace};

const SMALL: &str = "--simulated-scans 3 --sensor vlp-16";

/// What writes, and the file or folder that it leaves.
const WRITERS: [(&str, &str); 8] = [
    ("data simulate street-narrow --to mcap -o", "out.mcap"),
    ("data simulate street-narrow --to kitti-tracking -o", "tracking"),
    ("data simulate street-narrow --to kitti-object -o", "object"),
    ("data simulate street-narrow --to semantic-kitti -o", "semantic"),
    ("data prelabel street-narrow --to kitti -o", "kitti"),
    ("data prelabel street-narrow --to labelcloud -o", "labelcloud"),
    ("data prelabel street-narrow --to sustechpoints -o", "sustech"),
    (RUN, "run"),
];
const RUN: &str = "run street-narrow -d pca --no-rrd --mcap -o";

/// Nothing, or something whole: a data set with all its scans, or a run with all its files.
#[track_caller]
fn check_nothing_or_whole(path: &Path) -> bool {
    if !path.exists() {
        return false;
    }
    if path.ends_with("run") {
        for file in ["manifest.json", "report.json", "scans.csv", "matches.csv", "table_times.md"] {
            assert!(path.join(file).is_file(), "{} is not whole: {file}", path.display());
        }
        assert_eq!(open(&path.join("run.mcap")).scan_ids().len(), 3);
        return true;
    }
    let dataset = try_open(path).unwrap_or_else(|error| panic!("{} is not whole: {error}", path.display()));
    assert_eq!(scans(&*dataset).len(), 3, "{} is not whole", path.display());
    true
}

/// Ends what writes a file, a folder, a folder for a tool, and a run; the other formats write as one of these does.
#[cfg(target_os = "linux")]
#[test]
fn ended_at_any_moment_a_writer_leaves_nothing_or_all() {
    use std::os::unix::process::ExitStatusExt as _;

    let mut random = ChaCha8Rng::seed_from_u64(7);
    for (writer, name) in WRITERS.into_iter().step_by(2).chain([(RUN, "run")]) {
        let arguments = (writer, name, SMALL);
        let (workplace, whole_ms) = timed(&arguments);
        let (mut n_killed, mut n_whole) = (0, 0);
        for attempt in 0..6 {
            remove_all(&workplace);
            let mut command = workplace.command(&arguments);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            // The last one well after the end, for the other outcome.
            let pause_ms = if attempt < 5 { random.random_range(0..=whole_ms) } else { 20 * whole_ms };
            let deadline = std::time::Instant::now() + Duration::from_millis(pause_ms);
            while std::time::Instant::now() < deadline && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
            // Signals that are asked for come once or twice.
            let signals = [&["-KILL"][..], &["-TERM"], &["-INT", "-INT"], &["-KILL"]][attempt % 4];
            for signal in signals {
                // It may have ended.
                let id = child.id().to_string();
                let _ = std::process::Command::new("kill")
                    .args([*signal, id.as_str()])
                    .stderr(Stdio::null())
                    .status();
            }
            // Without a code before it listens, when nothing is written yet.
            let status = child.wait().unwrap();
            let is_whole = check_nothing_or_whole(&workplace.path(name));
            assert!(is_whole || status.code() != Some(0), "{name}");
            let is_killed = status.signal() == Some(9);
            n_killed += usize::from(is_killed);
            n_whole += usize::from(is_whole);
            // What is killed cannot clean up.
            let expected: &[&str] = if is_whole { &[name] } else { &[] };
            assert!(is_killed || workplace.top_names() == expected, "{name} after {signals:?}");
        }
        assert!(n_killed > 0 && n_whole > 0, "{name}: {n_killed} killed, {n_whole} whole");
    }
}

/// A workplace in which the program has run with `arguments`, and the milliseconds that it took.
fn timed(arguments: &impl Words) -> (Workplace, u64) {
    let workplace = Workplace::new();
    let started = std::time::Instant::now();
    workplace.succeed(arguments);
    (workplace, started.elapsed().as_millis() as u64)
}

fn remove_all(workplace: &Workplace) {
    for name in workplace.top_names() {
        let path = workplace.path(&name);
        if path.is_dir() {
            std::fs::remove_dir_all(path).unwrap();
        } else {
            std::fs::remove_file(path).unwrap();
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn killed_while_a_run_is_replaced_the_one_or_the_other_is_there() {
    let workplace = Workplace::new();
    let run = (RUN, "run --overwrite", SMALL);
    workplace.succeed(&run);
    let started = std::time::Instant::now();
    workplace.succeed(&run);
    let whole_ms = started.elapsed().as_millis() as u64;
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for attempt in 0..6 {
        // Most moments near the end, when names change.
        let from_ms = if attempt % 3 == 0 { 0 } else { whole_ms * 3 / 4 };
        let pause_ms = random.random_range(from_ms..=whole_ms);
        let mut child = workplace.command(&run).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(pause_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(check_nothing_or_whole(&workplace.path("run")), "there is no run at all");
    }
}

/// The program under a limit of the size of its files, as on a disk that is full.
#[cfg(unix)]
fn run_with_full_disk(workplace: &Workplace, arguments: &impl Words) -> Ended {
    // Blocks of a kilobyte: less than a scan.
    let limited = "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\"";
    let program = workplace.command("").get_program().to_owned();
    let mut command = std::process::Command::new("bash");
    command.args(["-c", limited]).arg(program).args(arguments.words()).current_dir(workplace.folder());
    Ended::from(command.env_remove("SCANBENCH_DATASETS").output().unwrap())
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_and_is_said() {
    for (writer, name) in WRITERS {
        let workplace = Workplace::new();
        let ended = run_with_full_disk(&workplace, &(writer, name, SMALL));
        ended.check_refusal(7, &["cannot write"]);
        assert!(ended.stderr.to_lowercase().contains("file too large"), "{name}: {ended:#?}");
        assert!(workplace.names().is_empty(), "{name}: {:?}", workplace.names());
    }
}

#[cfg(unix)]
#[test]
fn a_run_is_not_replaced_where_the_disk_is_full() {
    let workplace = Workplace::new();
    let run = (RUN, "run --overwrite", SMALL);
    workplace.succeed(&run);
    let (before, names) = (workplace.read("run/manifest.json"), workplace.names());
    run_with_full_disk(&workplace, &run).check_refusal(7, &[]);
    assert_eq!((workplace.read("run/manifest.json"), workplace.names()), (before, names));
}

/// A path where nothing can be written, whoever asks: below a file.
#[test]
fn where_nothing_can_be_written_nothing_is_left() {
    let workplace = Workplace::new();
    workplace.write("file", "");
    for (writer, name) in WRITERS {
        let ended = workplace.run(&(writer, format!("file/{name}"), SMALL));
        assert!([Some(1), Some(2)].contains(&ended.exit_code), "{ended:#?}");
        ended.check_stderr(&["file"]);
        assert_eq!(workplace.top_names(), ["file"]);
    }
}
