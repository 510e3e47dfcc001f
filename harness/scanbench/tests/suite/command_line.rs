//! What the command line says, and on which stream.

use std::collections::BTreeSet;
use std::process::Command;

use test_data::test_data;

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Ended, Workplace};

/// What the program says to `arguments`, which ask for help.
#[track_caller]
fn help(arguments: &str) -> String {
    let ended = Workplace::new().succeed(arguments);
    assert_eq!(ended.stderr, "", "{arguments}");
    ended.stdout
}

#[test]
fn help_says_what_there_is() {
    let said = |arguments: &str| help(arguments).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said("detect --help").contains("simple-grid, or one of scanbench.toml"));
    assert!(said("run --help").contains("Without -d, the default detectors run as well."));
    let help_of_all = help("--help");
    for line in
        ["0    success", "1    internal", "2    wrong usage", "3    data", "4    nothing", "130  interrupted"]
    {
        assert!(help_of_all.contains(&format!("\n  {line}")), "{line} in {help_of_all}");
    }
    let of_run = help("run --help");
    for flag in ["--save-rrd", "--no-rrd", "--connect", "--spawn", "--serve", "--rerun-every", "--blueprint"]
    {
        assert_eq!(of_run.contains(flag), cfg!(feature = "viewer"), "{flag}");
    }
    assert_eq!(help("--version"), format!("scanbench {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn parameters_are_printed_as_a_file_that_is_read_again() {
    let workplace = Workplace::new();
    let of_all = workplace.succeed("params").stdout;
    for detector in ["hierarchical", "paper", "kd-tree", "pca"] {
        let printed = workplace.succeed(&["params", detector]).stdout;
        assert!(of_all.contains(printed.trim_end()), "{printed}");
        workplace.write("mine.toml", &printed);
        // Read before what is not there is looked for.
        workplace.refuse(&["detect", "gone.bin", "-c", "mine.toml", "-d", detector], 3, &[]);
    }
    let of_paper = workplace.succeed("params paper").stdout;
    assert!(
        of_paper.contains("[paper.walls.hough]") && of_paper.contains("; paper, section 3.1"),
        "{of_paper}"
    );
    for absent in ["regrouping", "completion", "vehicle_bounds", "hierarchical"] {
        assert!(!of_paper.contains(absent), "{of_paper}");
    }
}

#[test]
fn nothing_asked_for_is_answered_with_help_and_wrong_usage() {
    let ended = Workplace::new().run("");
    assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(2), ""));
    ended.check_stderr(&["Usage: scanbench [OPTIONS] <COMMAND>"]);
}

#[test]
fn completions_know_the_verbs_of_every_shell() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = Workplace::new().succeed(format!("completions {shell}").as_str()).stdout;
        for word in ["selftest", "detectors", "ablation", "sensor-height"] {
            assert!(script.contains(word), "{shell}: {script}");
        }
        let has_names = script.contains("street-narrow") && script.contains("kd-tree-tree");
        assert!(has_names || ["elvish", "powershell"].contains(&shell), "{shell}: {script}");
    }
}

#[test]
fn every_verb_has_a_page_of_the_manual() {
    let workplace = Workplace::new();
    workplace.succeed("completions --man a/man");
    for (page, word) in
        [("", "selftest"), ("-run", "\\-\\-scans"), ("-baseline-init", "Folder of the baseline")]
    {
        let text = workplace.read(&format!("a/man/scanbench{page}.1"));
        assert!(text.starts_with(".ie") && text.contains(word), "{text}");
    }
    assert!(!workplace.path("a/man/scanbench-supervise.1").exists());
    workplace.write("file", "");
    workplace.refuse("completions --man file", 2, &["cannot write"]);
}

#[test]
fn bash_completes_verbs_data_sets_and_detectors() {
    let script = Workplace::new().succeed("completions bash").stdout;
    let lines = [
        ("self", "selftest"),
        ("run street-narrow-a", "street-narrow-ahead"),
        ("run -d simp", "simple-grid"),
    ];
    for (line, completed) in lines {
        let (n_words, last) = (line.split(' ').count(), line.split(' ').next_back().unwrap());
        let before = line.split(' ').rev().nth(1).unwrap_or("scanbench");
        let complete = format!(
            "COMP_WORDS=(scanbench {line}); COMP_CWORD={n_words}; _scanbench scanbench {last} {before}; echo \"${{COMPREPLY[@]}}\""
        );
        let Ok(output) = Command::new("bash").args(["-c", &format!("{script}\n{complete}")]).output() else {
            eprintln!("skipped bash_completes_verbs_data_sets_and_detectors: no bash");
            return;
        };
        assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), completed, "{line}: {output:?}");
    }
}

#[test]
fn results_are_on_stdout_and_the_rest_is_on_stderr_unless_quiet() {
    let workplace = Workplace::with_drive(2);
    let ended = workplace.succeed("run street -d hierarchical,pca -o out");
    assert!(ended.stdout.starts_with("Task objects on street"), "{ended:#?}");
    ended.check_stdout(&["\nTask vehicles on street"]);
    let paths = "Run directory: out\nPage: out/report.html\nRecording: rerun out/recording\n";
    assert_eq!(ended.stderr, paths);
    assert!(ended.stdout.lines().count() <= 45, "{ended:#?}");
    // It ends with who leads and who is faster, or that the machine was too busy to say so.
    let (_, summary) = ended.stdout.rsplit_once("\n\nTask objects: ").expect("a summary");
    assert!(summary.contains("Task vehicles: "), "{summary}");
    let compared = [" × faster than ", " about as fast as "].iter().any(|it| summary.contains(it));
    let is_said = summary.contains(" ms for a scan (mean), ") && compared;
    assert_ne!(is_said, summary.contains("Times are unreliable: "), "{summary}");
    let quiet = workplace.succeed("-q run street -d pca -o quiet");
    assert_eq!(quiet.stderr, "");
    assert_eq!(quiet.stdout, "quiet\n");
}

#[test]
fn verbose_says_every_scan() {
    let workplace = Workplace::with_drive(2);
    let verbose = workplace.succeed("run street -d pca -o verbose -v");
    let lines: Vec<&str> = verbose.stderr.lines().collect();
    assert!(lines[0].starts_with("street: 2 of 2 scans, sensor "), "{verbose:#?}");
    let of_scans: Vec<&&str> = lines.iter().filter(|it| it.starts_with("street 0000/")).collect();
    assert_eq!(of_scans.len(), 2, "{verbose:#?}");
    assert!(of_scans[0].contains(" points; pca ") && of_scans[0].contains(" ms, "), "{verbose:#?}");
    verbose.check_stdout(&["Times of detection only", "\nTask objects on street"]);
}

#[test]
fn tables_fold_where_there_are_few_columns() {
    let workplace = Workplace::with_drive(1);
    let longest = |columns: Option<&str>, name: &str| {
        let variables: Vec<_> = columns.map(|it| ("COLUMNS", it)).into_iter().collect();
        let ended = workplace.run_with(&variables, &("run street -o", name));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        ended.stdout.lines().map(|it| it.chars().count()).max()
    };
    assert!(longest(Some("60"), "narrow") <= Some(60));
    // Nobody looks at a pipe: as wide as on most terminals.
    let usual = longest(None, "usual");
    assert!(usual > Some(60) && usual <= Some(100), "{usual:?}");
}

#[test]
fn a_page_is_made_again_of_the_directory_alone() {
    let workplace = Workplace::with_drive(2);
    workplace.succeed("run street -o out");
    let first = workplace.read("out/report.html");
    assert!(first.contains("<svg class=\"plot\"") && first.len() < 2_000_000, "{first}");
    let moved = workplace.path("moved here");
    std::fs::rename(workplace.path("out"), &moved).expect("it moves");
    std::fs::remove_dir_all(workplace.path("street")).expect("the data go");
    std::fs::remove_file(moved.join("report.html")).expect("the page goes");
    let ended = workplace.succeed(&["report", "moved here"]);
    let paths =
        "Run directory: moved here\nPage: moved here/report.html\nRecording: rerun 'moved here/recording'\n";
    assert_eq!(ended.stderr, paths);
    assert!(ended.stdout.starts_with("Task objects on street"), "{ended:#?}");
    assert_eq!(workplace.read("moved here/report.html"), first);
    std::fs::remove_file(moved.join("scans.csv")).expect("a file goes");
    workplace.refuse(&["report", "moved here"], 3, &["scans.csv"]);
    assert_eq!(workplace.run("report nowhere").exit_code, Some(2));
}

#[test]
fn the_drawn_cars_are_found() {
    let workplace = Workplace::new();
    DrawnDataset::objects(workplace.folder(), 2);
    let report = workplace.succeed("run street -d hierarchical -o out -v");
    let row = report.stdout.lines().find(|line| line.contains("street") && line.contains(" hierarchical "));
    let words: Vec<&str> = row.expect("a row").split_whitespace().collect();
    // Data set, detector, scans, NO, TP, MO.
    assert_eq!(words[..6], ["street", "hierarchical", "2", "4", "4", "0"], "{}", report.stdout);
}

#[test]
fn a_selftest_is_exact() {
    let workplace = Workplace::with_drive(2);
    let ended = workplace.succeed("selftest street");
    // Four criteria in two tasks; two tasks and a class through a process, and through files of CSV and of KITTI.
    assert_eq!(ended.stdout.lines().count(), 8 + 3 * 3, "{ended:#?}");
    assert_eq!(ended.stdout.matches("car by centre, through ").count(), 3, "{ended:#?}");
    for line in ended.stdout.lines() {
        assert!(line.starts_with("ok ") && line.contains("recall 1, "), "{line}");
        assert!(line.ends_with("over 4 annotations, largest cost 0"), "{line}");
    }
    assert_eq!(ended.stderr, "");
}

#[test]
fn a_list_says_what_is_there_and_what_is_not() {
    let workplace = Workplace::with_drive(2);
    let mut command = workplace.command("data list");
    command.env("KITTI_TRACKING_ROOT", "street").env("KITTI_OBJECT_ROOT", "gone");
    let ended = Ended::from(command.output().expect("it starts"));
    assert_eq!((ended.exit_code, ended.stderr.as_str()), (Some(0), ""));
    let line_of =
        |id: &str| ended.stdout.lines().find(|line| line.starts_with(id)).expect("a line").to_owned();
    let second_column =
        |line: &str| line.len() - line.split_once(' ').map_or("", |it| it.1).trim_start().len();
    let columns: BTreeSet<usize> = ended.stdout.lines().map(second_column).collect();
    assert_eq!(columns.len(), 1, "not below each other: {ended:#?}");
    assert!(line_of("kitti-tracking ").contains(" 2 scans, kitti-tracking"), "{ended:#?}");
    assert!(
        line_of("kitti-object ").contains("not available: \"kitti-object\" is not at \"gone\""),
        "{ended:#?}"
    );
}

#[test]
fn a_catalogue_may_be_named_by_the_environment() {
    let workplace = Workplace::new();
    workplace.write("mine.toml", "");
    let ended = workplace.run_with(&[("SCANBENCH_DATASETS", "mine.toml")], "data list");
    assert_eq!((ended.exit_code, ended.stdout.as_str(), ended.stderr.as_str()), (Some(0), "", ""));
}

#[test]
fn colours_are_asked_for_and_refused_by_the_environment() {
    let is_coloured = |variables: &[(&str, &str)]| {
        let workplace = Workplace::new();
        let mut command = workplace.command("run --help");
        let ended = Ended::from(command.envs(variables.iter().copied()).output().expect("it starts"));
        ended.stdout.contains('\u{1b}')
    };
    assert!(!is_coloured(&[]));
    assert!(is_coloured(&[("CLICOLOR_FORCE", "1")]));
    assert!(!is_coloured(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
}

/// A pipe whose reader is gone.
fn closed_pipe() -> std::io::PipeWriter {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error_and_hears_no_complaint() {
    let workplace = Workplace::with_drive(1);
    for (arguments, exit_code) in [
        ("params", 0),
        ("completions bash", 0),
        ("selftest street", 0),
        ("detect street --scan 0 -o -", 0),
        ("run street -d pca -o out", 0),
        ("run nowhere", 2),
    ] {
        let mut command = workplace.command(arguments);
        let status = command.stdout(closed_pipe()).stderr(closed_pipe()).status().expect("it starts");
        assert_eq!(status.code(), Some(exit_code), "{arguments:?}");
    }
    assert!(workplace.path("out/report.json").is_file());
    let mut command = workplace.command("params");
    let ended = Ended::from(command.stdout(closed_pipe()).output().expect("it starts"));
    assert_eq!(ended.stderr, "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error_and_the_run_is_there_all_the_same() {
    let workplace = Workplace::with_drive(1);
    let mut command = workplace.command("run street -d pca -o out");
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a device");
    let ended = Ended::from(command.stdout(full).output().expect("it starts"));
    assert_eq!(ended.exit_code, Some(7), "{ended:#?}");
    ended.check_stderr(&["Run directory: out\n", "error: cannot write to stdout: No space left"]);
    assert!(workplace.path("out/report.json").is_file());
}

#[cfg(feature = "viewer")]
#[test]
fn a_viewer_that_is_not_there_is_warned_about_once() {
    let workplace = Workplace::with_drive(2);
    // Nothing listens on the port of a listener that is gone.
    let port =
        std::net::TcpListener::bind("127.0.0.1:0").and_then(|it| it.local_addr()).expect("a port").port();
    let url = format!("rerun+http://127.0.0.1:{port}/proxy");
    let ended = workplace.succeed(&["run", "street", "-d", "pca", "-o", "out", "--connect", &url]);
    assert_eq!(
        ended.stderr.matches("warning: lost the connection to the viewer (no viewer at ").count(),
        1,
        "{ended:#?}"
    );
    assert!(workplace.path("out/recording").is_dir());
}

#[test]
#[ignore = "needs data/kitti_tracking and data/kitti_object in SCANBENCH_TEST_DATA"]
fn real_scans_are_run() {
    for name in ["kitti_tracking", "kitti_object"] {
        let root = test_data(&format!("data/{name}"));
        let root = root.to_str().expect("a readable path");
        let workplace = Workplace::new();
        workplace
            .succeed(&["run", root, "-d", "hierarchical,pca", "--scans", "0..2", "-o", "out"])
            .check_stdout(&[name]);
        let selftest = workplace.succeed(&["selftest", root, "--scans", "0..2"]);
        assert!(selftest.stdout.lines().all(|line| line.starts_with("ok ")), "{selftest:#?}");
    }
}
