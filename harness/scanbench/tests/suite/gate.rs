//! Runs judged by others: what passes, what does not, and with which exit code.

use crate::program::{Ended, Workplace};
use serde_json::Value;

/// As tight as can be, without times: those of short runs beside other tests say nothing.
const TOLERANCES: &str = r#"
[[quality]]
metrics = ["f_rate", "recall", "precision", "over_segmentation", "box_length_error_m"]
slices = ["all"]
absolute = 0.001
relative = 0.0

[[quality]]
metrics = ["recall"]
slices = ["class/*", "range/*"]
absolute = 0.001
relative = 0.0
"#;

/// Runs `pca` and the hierarchical detector on six scans of a narrow street, seen by few beams.
#[track_caller]
fn run(workplace: &Workplace, name: &str, options: &[&str]) {
    let mut arguments = vec!["run", "street-narrow", "--simulated-scans", "6", "-o", name];
    for (option, usual) in [("--sensor", "vlp-16"), ("-d", "hierarchical,pca")] {
        if !options.contains(&option) {
            arguments.extend([option, usual]);
        }
    }
    if cfg!(feature = "viewer") {
        arguments.push("--no-rrd");
    }
    arguments.extend(options);
    workplace.succeed(&arguments);
}

/// A workplace with a run, accepted as the baseline `golden`.
fn accepted() -> Workplace {
    let workplace = Workplace::new();
    workplace.write("tolerances.toml", TOLERANCES);
    run(&workplace, "first", &[]);
    workplace.succeed(&["baseline", "accept", "first", "-b", "golden", "--why", "the first"]);
    std::fs::copy(workplace.path("tolerances.toml"), workplace.path("golden/tolerances.toml"))
        .expect("it is there");
    workplace
}

#[track_caller]
fn check_gate(workplace: &Workplace, run: &str, exit_code: i32, expected: &str) -> Ended {
    let ended = workplace.run(&["gate", run, "-b", "golden", "-o", "verdict"]);
    assert_eq!(ended.exit_code, Some(exit_code), "{ended:#?}");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains(expected), "no {expected:?} in\n{said}");
    ended
}

#[test]
fn a_run_is_as_good_as_itself_and_as_its_repetition() {
    let workplace = accepted();
    check_gate(&workplace, "first", 0, "Gate: as accepted.");
    run(&workplace, "again", &["--jobs", "1", "--warmup", "0", "-d", "pca,hierarchical"]);
    let ended = check_gate(&workplace, "again", 0, "0 scans judged otherwise");
    assert!(!ended.stdout.contains("inconclusive\n"), "{}", ended.stdout);
    check_gate(&workplace, "golden/run", 0, "Gate: as accepted.");
}

/// The street of any seed against itself, run again: nothing may ever be reported.
#[test]
fn twenty_streets_run_twice_report_nothing() {
    let workplace = Workplace::new();
    workplace.write("tolerances.toml", TOLERANCES);
    for seed in 1..=20 {
        let seed = seed.to_string();
        let options = ["--seed", seed.as_str(), "--scans", "0..6:4", "--overwrite"];
        run(&workplace, "once", &options);
        run(&workplace, "twice", &[&options[..], &["--jobs", "3"]].concat());
        let arguments = ["gate", "twice", "-b", "once", "-t", "tolerances.toml"];
        let ended = workplace.succeed(&arguments);
        assert!(ended.stdout.contains(" 0 surely worse, 0 perhaps, 0 missing. 0 scans"), "{}", ended.stdout);
    }
}

/// Three parameters, each worsened a little: none goes unnoticed, and what changed is named.
#[test]
fn each_of_three_slightly_worsened_parameters_is_caught_with_the_objects_that_changed() {
    let workplace = accepted();
    for (run_name, parameter) in [
        ("larger-cells", "hierarchical.grid.cell_size_m=0.63"),
        ("more-points", "hierarchical.cluster.min_points=18"),
        ("higher-points", "hierarchical.foreground.clearance_m=0.17"),
    ] {
        run(&workplace, run_name, &["-P", parameter]);
        let ended = workplace.run(&["gate", run_name, "-b", "golden", "-o", "verdict"]);
        assert!(matches!(ended.exit_code, Some(100 | 101)), "{parameter}: {ended:#?}");
        let scan = ended.stdout.lines().position(|it| it.starts_with("street-narrow narrow-1/0000"));
        let scan = scan.unwrap_or_else(|| panic!("{parameter}: no scan is named\n{}", ended.stdout));
        let lines: Vec<&str> = ended.stdout.lines().collect();
        assert!(lines[scan].contains(", hierarchical, "), "{}", lines[scan]);
        assert!(lines[scan + 1].starts_with("  ") && lines[scan + 1].contains(" m"), "{}", lines[scan + 1]);
        assert!(!ended.stdout.contains(", pca, objects\n"), "{parameter} is none of pca's\n{}", ended.stdout);
        let verdict: Value = serde_json::from_str(&workplace.read("verdict/gate.json")).expect("JSON");
        let drift = verdict["drift"].as_array().expect("a list");
        assert!(drift.iter().all(|it| !it["changes"].as_array().expect("a list").is_empty()), "{drift:?}");
        assert!(!drift.is_empty(), "{parameter}");
    }
}

#[test]
fn what_is_surely_worse_is_a_regression() {
    let workplace = accepted();
    run(&workplace, "worse", &["-P", "hierarchical.cluster.min_points=200"]);
    check_gate(&workplace, "worse", 100, "Gate: regression.");
    let verdict: Value = serde_json::from_str(&workplace.read("verdict/gate.json")).expect("JSON");
    assert_eq!(verdict["conclusion"], "regression");
    let junit = workplace.read("verdict/junit.xml");
    assert!(junit.contains("type=\"regression\"") && junit.contains("type=\"drift\""), "{junit}");
    assert!(workplace.read("verdict/gate.md").starts_with("**Gate: regression."));
    let smaller: Value =
        serde_json::from_str(&workplace.read("verdict/custom-smaller-is-better.json")).expect("JSON");
    let is_f_rate = |it: &&Value| it["name"] == "objects/hierarchical/1 - f_rate";
    let entry = smaller.as_array().expect("a list").iter().find(is_f_rate).expect("an F-rate");
    let bencher: Value = serde_json::from_str(&workplace.read("verdict/bencher.json")).expect("JSON");
    let f_rate = bencher["objects/hierarchical"]["f_rate"]["value"].as_f64().expect("a number");
    assert_eq!(entry["value"].as_f64(), Some(1.0 - f_rate));
}

#[test]
fn a_better_run_is_no_regression_but_has_to_be_accepted() {
    let workplace = Workplace::new();
    // Of more and smaller clusters a smaller share is right.
    let other_metrics = r#", "precision", "over_segmentation", "box_length_error_m""#;
    workplace.write("tolerances.toml", &TOLERANCES.replacen(other_metrics, "", 1));
    run(&workplace, "worse", &["-P", "hierarchical.cluster.min_points=200"]);
    run(&workplace, "better", &[]);
    let accept = |name: &str, why: &str| {
        let ended = workplace.succeed(&["baseline", "accept", name, "-b", "golden", "--why", why]);
        std::fs::copy(workplace.path("tolerances.toml"), workplace.path("golden/tolerances.toml"))
            .expect("it is there");
        ended
    };
    accept("worse", "nothing better\nyet");
    check_gate(&workplace, "better", 101, "nothing is surely worse, but scans are judged otherwise");
    let ended = accept("better", "smaller clusters are objects too");
    assert!(ended.stdout.contains(" → ") && ended.stdout.contains("objects: hierarchical "), "{ended:#?}");
    check_gate(&workplace, "better", 0, "Gate: as accepted.");
    let history = workplace.read("golden/SCORES.md");
    let lines: Vec<&str> = history.lines().filter(|it| it.starts_with("- ")).collect();
    assert_eq!(lines.len(), 2, "{history}");
    assert!(lines[0].ends_with(". nothing better yet"), "{history}");
    assert!(lines[1].ends_with(". smaller clusters are objects too"), "{history}");
    let manifest: Value = serde_json::from_str(&workplace.read("golden/run/manifest.json")).expect("JSON");
    assert_eq!(manifest["argv"][0], "scanbench");
    let n_rows = |name: &str| workplace.read(name).lines().count();
    assert!(n_rows("golden/run/matches.csv") < n_rows("better/matches.csv"));
}

#[test]
fn runs_that_were_asked_for_other_things_are_not_compared() {
    let workplace = accepted();
    for (name, options, expected) in [
        ("seed", &["--seed", "7"][..], "the data of street-narrow have changed"),
        ("scans", &["--scans", "0..3"], "the scans differ: 6 before, 3 now, 3 in common"),
        ("criterion", &["--criterion", "centre"], "the matching criterion was"),
        ("range", &["-P", "matching.max_range_m=60"], "what is ignored was"),
        ("detectors", &["-d", "pca"], "hierarchical was not run"),
        ("sensor", &["--sensor", "hdl-32e", "--scans", "0"], "the data of street-narrow have changed"),
    ] {
        run(&workplace, name, options);
        check_gate(&workplace, name, 5, expected);
        let ended = workplace.run(&["compare", "first", name]);
        assert_eq!(ended.exit_code, Some(5), "{name}: {ended:#?}");
    }
    let other_version = |name: &str| {
        let path = format!("golden/run/{name}");
        let text = workplace.read(&path);
        assert!(text.contains("\"scoring_version\": 1"));
        workplace.write(&path, &text.replacen("\"scoring_version\": 1", "\"scoring_version\": 0", 1));
    };
    other_version("manifest.json");
    check_gate(&workplace, "first", 5, "the scoring version was 0 and is 1");
}

#[test]
fn damaged_files_and_wrong_usage_have_codes_of_their_own() {
    let workplace = accepted();
    check_gate(&workplace, "nowhere", 2, "there is no run directory nowhere");
    let ended = workplace.run(&["gate", "first", "-b", "nowhere"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    workplace.write("bad.toml", &TOLERANCES.replacen("f_rate", "f_rat", 1));
    let ended = workplace.run(&["gate", "first", "-b", "golden", "-t", "bad.toml"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("there is no metric \"f_rat\""), "{ended:#?}");
    let ended = workplace.run(&["baseline", "accept", "first", "-b", "golden", "--why", " "]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    let ended = workplace.run(&["compare", "first", "-d", "pca,nobody"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");

    for (name, from, to) in [
        ("matches.csv", "pair,matched", "pair,missed"),
        ("scans.csv", ",evaluated,", ",perhaps,"),
        ("report.json", "\"rows\"", "\"row\""),
        ("manifest.json", "{", ""),
    ] {
        let path = format!("first/{name}");
        let text = workplace.read(&path);
        assert!(text.contains(from), "{name}");
        workplace.write(&path, &text.replacen(from, to, 1));
        check_gate(&workplace, "first", 3, "the run first cannot be read");
        workplace.write(&path, &text);
    }
    std::fs::remove_file(workplace.path("first/scans.csv")).expect("it was there");
    check_gate(&workplace, "first", 3, "scans.csv");
    assert_eq!(workplace.run(&["compare", "first", "golden/run"]).exit_code, Some(3));
}

#[test]
fn the_summary_of_a_job_is_added_to() {
    let workplace = accepted();
    workplace.write("summary.md", "before\n");
    let mut command = workplace.command(&["gate", "first", "-b", "golden"]);
    command.env("GITHUB_STEP_SUMMARY", workplace.path("summary.md"));
    assert!(command.output().expect("it runs").status.success());
    let summary = workplace.read("summary.md");
    assert!(summary.starts_with("before\n**Gate: as accepted."), "{summary}");
    assert!(summary.contains("| objects | pca | all | f_rate"), "{summary}");
}

#[test]
fn two_detectors_are_compared_on_the_same_resamples() {
    let workplace = accepted();
    let text = workplace.succeed(&["compare", "first", "-d", "pca,hierarchical"]).stdout;
    assert!(text.contains("hierarchical − pca") && text.contains("least"), "{text}");
    let itself = workplace.succeed(&["compare", "first", "golden/run", "--slices", "--markdown"]).stdout;
    assert!(itself.contains(r"| objects | pca | range/0-15 | recall \[%] |"), "{itself}");
    assert!(itself.contains("Every scan is judged as before."), "{itself}");
}
