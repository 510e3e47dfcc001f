//! Runs of others: nothing is written elsewhere, nothing is waited for, and nothing that they say is obeyed.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{Ended, Prepared, Words, Workplace};

/// A workplace with a run `run`, and what is not to be touched in `elsewhere`.
fn small_run() -> Workplace {
    static SMALL: Prepared = Prepared::new();
    SMALL.workplace(|workplace| {
        let no_recording = if cfg!(feature = "viewer") { "--no-rrd" } else { "" };
        let run = "run street-narrow --simulated-scans 4 --sensor vlp-16 -d simple-grid,pca -o run";
        workplace.succeed(&(run, no_recording));
        std::fs::remove_dir_all(workplace.path("run/figures")).unwrap();
        workplace.write("elsewhere/theirs", "theirs");
    })
}

/// Puts a link `name` in the place of what is there.
fn link(workplace: &Workplace, name: &str, to: impl AsRef<Path>) {
    let _ = std::fs::remove_file(workplace.path(name));
    symlink(to, workplace.path(name)).unwrap();
}

/// Puts a pipe that nobody writes to in the place of what is there.
fn pipe(workplace: &Workplace, name: &str) {
    let path = workplace.path(name);
    let _ = std::fs::remove_file(&path);
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
}

/// Runs the program, which must not take a minute.
#[track_caller]
fn run_soon(workplace: &Workplace, arguments: &(impl Words + ?Sized)) -> Ended {
    let mut command = workplace.command(arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > Duration::from_mins(1) {
            child.kill().unwrap();
            panic!("{:?} hangs", arguments.words());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ended::from(child.wait_with_output().unwrap())
}

#[test]
fn nothing_is_written_through_a_link() {
    let workplace = small_run();
    let elsewhere = workplace.path("elsewhere");
    link(&workplace, "run/figures", &elsewhere);
    let problem = "cannot write \"run/figures\": it is a link, and nothing is written through one";
    workplace.end_with("report run", 2, &[problem]);
    std::fs::remove_file(workplace.path("run/figures")).unwrap();
    link(&workplace, "run/report.html", elsewhere.join("theirs"));
    workplace.succeed("report run");
    assert!(workplace.path("run/report.html").symlink_metadata().unwrap().is_file());
    if cfg!(feature = "viewer") {
        link(&workplace, "run/worst.rrd", elsewhere.join("theirs"));
        workplace.succeed("view run --task objects --worst 1");
        assert!(workplace.path("run/worst.rrd").symlink_metadata().unwrap().is_file());
        // A link that the user has named stays one.
        link(&workplace, "mine.rrd", elsewhere.join("mine.rrd"));
        workplace.write("elsewhere/mine.rrd", "before");
        workplace.succeed("view run --task objects --worst 1 --save-rrd=mine.rrd");
        assert!(workplace.n_bytes("elsewhere/mine.rrd") > 1000);
        std::fs::remove_file(workplace.path("elsewhere/mine.rrd")).unwrap();
    }
    // The directory that the user has named may be a link.
    std::fs::rename(workplace.path("run"), workplace.path("moved")).unwrap();
    link(&workplace, "run", "moved");
    workplace.succeed("report run");
    assert!(workplace.path("moved/figures").is_dir());
    // What is kept of work that is not finished lies beside its directory.
    link(&workplace, "new.unfinished", &elsewhere);
    let run = "run street-narrow --simulated-scans 1 -d pca -o new";
    workplace.end_with(run, 2, &["new.unfinished\": it is a link"]);
    std::fs::remove_file(workplace.path("new.unfinished")).unwrap();
    std::fs::create_dir(workplace.path("new.unfinished")).unwrap();
    for name in ["journal", "recording"] {
        link(&workplace, &format!("new.unfinished/{name}"), elsewhere.join("theirs"));
    }
    workplace.end_with(run, 2, &["new.unfinished/journal\": it is a link"]);
    std::fs::remove_file(workplace.path("new.unfinished/journal")).unwrap();
    if cfg!(feature = "viewer") {
        workplace.end_with(run, 2, &["new.unfinished/recording\": it is a link"]);
    }
    // That has removed the link; without a viewer it is removed with the rest.
    workplace.succeed(run);
    link(&workplace, ".other.lock", elsewhere.join("lock"));
    workplace.end_with("run street-narrow --simulated-scans 1 -d pca -o other", 2, &["it is a link"]);
    let names: Vec<_> = std::fs::read_dir(&elsewhere).unwrap().map(|it| it.unwrap().file_name()).collect();
    assert_eq!((names, workplace.read("elsewhere/theirs")), (vec!["theirs".into()], "theirs".to_owned()));
}

#[test]
fn pipes_and_devices_are_no_files_of_a_run() {
    const VERBS: [&str; 4] =
        ["report run", "compare run run", "gate run --baseline run", "view run --task objects --no-rrd"];
    let workplace = small_run();
    let whole = workplace.path("run");
    for name in ["manifest.json", "report.json", "scans.csv", "matches.csv"] {
        let kept = std::fs::read(whole.join(name)).unwrap();
        for device in ["", "/dev/zero", "/dev/full"] {
            if device.is_empty() {
                pipe(&workplace, &format!("run/{name}"));
            } else {
                link(&workplace, &format!("run/{name}"), device);
            }
            let mut n_refused = 0;
            for verb in VERBS {
                let ended = run_soon(&workplace, verb);
                // What a verb does not read does not end it.
                let is_refused = ended.exit_code == Some(3) && ended.stderr.contains("not a file");
                assert!(is_refused || ended.exit_code == Some(0), "{name} {device} {verb}: {ended:#?}");
                n_refused += usize::from(is_refused);
            }
            assert!(n_refused > 0, "{name} {device} is read by none");
        }
        std::fs::remove_file(whole.join(name)).unwrap();
        std::fs::write(whole.join(name), kept).unwrap();
    }
    // A claim of a size costs nothing either.
    let rows = std::fs::File::options().write(true).open(whole.join("matches.csv")).unwrap();
    rows.set_len(1 << 40).unwrap();
    run_soon(&workplace, "compare run run").check_refusal(3, &["matches.csv", "a line with more"]);
}

#[test]
fn settings_that_the_user_names_may_come_from_a_pipe_and_from_no_device() {
    let workplace = small_run();
    pipe(&workplace, "pipe");
    for (arguments, exit_code) in [
        ("gate run --baseline run --tolerances", 2),
        ("run street-narrow -d pca -o x --blocks", 2),
        ("run street-narrow -d pca -o x -c", 2),
        ("run street-narrow -d pca -o x --transform", 3),
    ] {
        for (path, problem) in [("pipe", "a pipe that gives nothing"), ("/dev/zero", "a device or a socket")]
        {
            run_soon(&workplace, &(arguments, path)).check_refusal(exit_code, &[problem]);
        }
    }
    let script = format!(
        "exec {} run street-narrow --simulated-scans 1 -d pca -o piped -c <(echo '[pca]')",
        env!("CARGO_BIN_EXE_scanbench")
    );
    let mut shell = std::process::Command::new("bash");
    let output = shell.args(["-c", &script]).current_dir(workplace.folder()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

/// What a terminal would obey.
fn is_obeyed(text: &str) -> bool {
    text.chars().any(|it| it.is_control() && it != '\n' && it != '\t' || it == '\u{202e}')
}

#[test]
fn what_a_run_says_is_not_obeyed() {
    const EVIL: &str = r"street\u001b]0;evil\u0007\u202e";
    let workplace = small_run();
    for name in ["manifest.json", "report.json"] {
        let text = workplace.read(&format!("run/{name}"));
        workplace.write(&format!("run/{name}"), &text.replace("street-narrow", EVIL));
    }
    for verb in ["report run", "compare run run", "gate run --baseline run", "view run --task objects"] {
        let ended = run_soon(&workplace, verb);
        assert_eq!(ended.exit_code, Some(3), "{verb}: {ended:#?}");
        assert!(!is_obeyed(&ended.stderr) && !is_obeyed(&ended.stdout), "{verb}: {ended:#?}");
        ended.check_stderr(&[r"street\u{1b}]0;evil\u{7}\u{202e}"]);
    }
    workplace.write("classes.toml", "[classes]\n\"a\\u001b[31m\\u202e\" = \"nothing\"\n");
    let ended = run_soon(&workplace, "run street-narrow -d pca -o x -c classes.toml");
    assert!(ended.exit_code == Some(2) && !is_obeyed(&ended.stderr), "{ended:#?}");
}

#[cfg(feature = "viewer")]
#[test]
fn what_a_run_names_is_neither_fetched_nor_started_unasked() {
    let workplace = small_run();
    let text = workplace.read("run/manifest.json");
    let with_argv = |argv: &str| {
        let begin = text.find("\"argv\": [").unwrap();
        let end = begin + text[begin..].find(']').unwrap();
        format!("{}\"argv\": [{argv}{}", &text[..begin], &text[end..])
    };
    workplace.write(
        "run/manifest.json",
        &with_argv(r#""scanbench", "run", "http://127.0.0.1:9/a/", "-d", "pca""#),
    );
    workplace.end_with(
        "view run --task objects",
        2,
        &["\"http://127.0.0.1:9/a/\", which is not fetched", "--trust"],
    );
    workplace.end_with("view run --task objects --trust", 3, &["cannot fetch"]);
    workplace.write("theirs.toml", "[detector.mine]\ncommand = [\"touch\", \"started\"]\n");
    workplace.write(
        "run/manifest.json",
        &with_argv(r#""scanbench", "run", "street-narrow", "-d", "mine", "-c", "theirs.toml""#),
    );
    workplace.end_with("view run --task objects", 2, &["\"mine\" of \"theirs.toml\"", "--trust"]);
    assert!(!workplace.path("started").exists());
    for word in ["x\\n      - run: evil", "${{ github.token }}"] {
        workplace.write("run/manifest.json", &with_argv(&format!(r#""scanbench", "run", "{word}""#)));
        workplace.refuse("baseline init run -o ci", 2, &["which cannot stand in a workflow"]);
    }
}

#[test]
fn results_that_nobody_takes_are_an_error() {
    let workplace = small_run();
    let shell = |line: &str| {
        let line = line.replace("scanbench", env!("CARGO_BIN_EXE_scanbench"));
        let mut shell = std::process::Command::new("bash");
        Ended::from(shell.args(["-c", &line]).current_dir(workplace.folder()).output().unwrap())
    };
    for verb in ["compare run run", "data list", "params pca", "completions bash"] {
        for (stream, problem) in [(">&-", "it is closed"), ("> /dev/full", "No space left")] {
            if stream == ">&-" && !cfg!(target_os = "linux") {
                continue;
            }
            let ended = shell(&format!("scanbench {verb} {stream}"));
            assert_eq!(ended.exit_code, Some(7), "{verb} {stream}: {ended:#?}");
            ended.check_stderr(&["cannot write to stdout", problem]);
        }
        let ended = shell(&format!("scanbench {verb} > /dev/null"));
        assert_eq!(ended.exit_code, Some(0), "{verb}: {ended:#?}");
        // A reader that has seen enough.
        let ended = shell(&format!("scanbench {verb} | head -c 1 > /dev/null; exit ${{PIPESTATUS[0]}}"));
        assert_eq!(ended.exit_code, Some(0), "{verb}: {ended:#?}");
    }
}
