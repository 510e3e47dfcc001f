//! Runs judged by others: what passes, what does not, and with which exit code.

use crate::program::{Ended, Prepared, Workplace, copy_folder};
use evaluation::metrics::counts::SCORING_VERSION;
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

/// What makes hardly anything an object.
const WORSE: &str = "-P hierarchical.cluster.min_points=200";

/// Runs `pca` and the hierarchical detector on a scan of each of ten narrow streets, seen by few beams.
#[track_caller]
fn run(workplace: &Workplace, name: &str, options: &str) {
    let usual = [
        "--simulated-scans 20",
        "--scans 0..20:2",
        "--sensor vlp-16",
        "-d hierarchical,pca",
        // Those of development: what is worse there is known.
        "--seed 9001",
    ];
    let is_given = |usual: &&str| options.split(' ').any(|it| usual.split(' ').next() == Some(it));
    let usual: Vec<&str> = usual.into_iter().filter(|it| !is_given(it)).collect();
    let no_recording = if cfg!(feature = "viewer") { "--no-rrd" } else { "" };
    workplace.succeed(&(("run street-narrow -o", name), usual.join(" "), no_recording, options));
    // Whoever changes the program runs these tests before there is a commit of it.
    edit(workplace, &format!("{name}/manifest.json"), "\"dirty\": true", "\"dirty\": false");
}

/// Replaces `from`, where it is, by `to` in a file.
fn edit(workplace: &Workplace, path: &str, from: &str, to: &str) {
    let text = workplace.read(path);
    workplace.write(path, &text.replacen(from, to, 1));
}

/// A workplace with a run `first`, accepted as the baseline `golden`, and one that is `worse`.
fn accepted() -> Workplace {
    static ACCEPTED: Prepared = Prepared::new();
    ACCEPTED.workplace(|workplace| {
        workplace.write("tolerances.toml", TOLERANCES);
        run(workplace, "first", "");
        run(workplace, "worse", WORSE);
        workplace.succeed(&["baseline", "accept", "first", "-b", "golden", "--why", "the first"]);
        workplace.write("golden/tolerances.toml", TOLERANCES);
    })
}

#[track_caller]
fn check_gate(workplace: &Workplace, run: &str, exit_code: i32, expected: &str) -> Ended {
    let ended = workplace.end_with(&["gate", run, "-b", "golden", "-o", "verdict", "--full"], exit_code, &[]);
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains(expected), "no {expected:?} in\n{said}");
    ended
}

#[test]
fn a_run_is_as_good_as_itself_and_as_its_repetition() {
    let workplace = accepted();
    check_gate(&workplace, "first", 0, "PASSED\n");
    run(&workplace, "again", "--jobs 1 --warmup 0 -d pca,hierarchical");
    let ended = check_gate(&workplace, "again", 0, "No result changed.");
    assert!(!ended.stdout.contains("inconclusive\n"), "{}", ended.stdout);
    check_gate(&workplace, "golden/run", 0, "PASSED\n");
}

/// The street of any seed against itself, run again: nothing may ever be reported.
#[test]
fn streets_run_twice_report_nothing() {
    let workplace = Workplace::new();
    workplace.write("tolerances.toml", TOLERANCES);
    for seed in 1..=3 {
        let options = format!("--seed {seed} --scans 0..4:2 --overwrite");
        run(&workplace, "once", &options);
        run(&workplace, "twice", &format!("{options} --jobs 3"));
        workplace.succeed("gate twice -b once -t tolerances.toml").check_stdout(&[
            " 0 worse, 0 inconclusive, 0 missing. No result changed.",
            "Only 2 blocks of scans: too few to show that anything is worse.",
        ]);
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
        run(&workplace, run_name, &format!("-P {parameter}"));
        let ended = workplace.run(&["gate", run_name, "-b", "golden", "-o", "verdict", "--full"]);
        assert!(matches!(ended.exit_code, Some(100 | 101)), "{parameter}: {ended:#?}");
        let scan = ended.stdout.lines().position(|it| it.starts_with("street-narrow narrow-90"));
        let scan = scan.unwrap_or_else(|| panic!("{parameter}: no scan is named\n{}", ended.stdout));
        let lines: Vec<&str> = ended.stdout.lines().collect();
        assert!(lines[scan].contains(", hierarchical, "), "{}", lines[scan]);
        assert!(lines[scan + 1].starts_with("  ") && lines[scan + 1].contains(" m"), "{}", lines[scan + 1]);
        assert!(!ended.stdout.contains(", pca, objects\n"), "{parameter} is none of pca's\n{}", ended.stdout);
        let verdict = workplace.json("verdict/gate.json");
        let drift = verdict["drift"].as_array().expect("a list");
        assert!(drift.iter().all(|it| !it["changes"].as_array().expect("a list").is_empty()), "{drift:?}");
        assert!(!drift.is_empty(), "{parameter}");
    }
}

#[test]
fn what_is_surely_worse_is_a_regression() {
    let workplace = accepted();
    check_gate(&workplace, "worse", 100, "FAILED: worse\n");
    // A loss is one, whatever is allowed.
    workplace.end_with("gate worse -b golden --allow-drift", 100, &[]);
    let verdict = workplace.json("verdict/gate.json");
    assert_eq!(verdict["conclusion"], "regression");
    workplace.check_file("verdict/junit.xml", &["type=\"regression\"", "type=\"drift\""]);
    assert!(workplace.read("verdict/gate.md").starts_with("**FAILED: worse**\n"));
    let smaller = workplace.json("verdict/custom-smaller-is-better.json");
    let is_f_rate = |it: &&Value| it["name"] == "objects/hierarchical/1 - f_rate";
    let entry = smaller.as_array().expect("a list").iter().find(is_f_rate).expect("an F-rate");
    let bencher = workplace.json("verdict/bencher.json");
    let f_rate = bencher["objects/hierarchical"]["f_rate"]["value"].as_f64().expect("a number");
    assert_eq!(entry["value"].as_f64(), Some(1.0 - f_rate));
}

#[test]
fn a_better_run_is_no_regression_but_has_to_be_accepted() {
    let workplace = accepted();
    std::fs::remove_dir_all(workplace.path("golden")).expect("it was accepted");
    // Of more and smaller clusters a smaller share is right.
    let other_metrics = r#", "precision", "over_segmentation", "box_length_error_m""#;
    workplace.write("tolerances.toml", &TOLERANCES.replacen(other_metrics, "", 1));
    let accept = |name: &str, why: &str| {
        let ended = workplace.succeed(&["baseline", "accept", name, "-b", "golden", "--why", why]);
        std::fs::copy(workplace.path("tolerances.toml"), workplace.path("golden/tolerances.toml"))
            .expect("it is there");
        ended
    };
    accept("worse", "nothing better\nyet");
    check_gate(&workplace, "first", 101, "FAILED: results changed\n");
    let tolerances = workplace.read("golden/tolerances.toml");
    for (drift, option, exit_code) in [
        ("", "--allow-drift", 0),
        ("drift = \"warn\"\n", "-q", 0),
        ("drift = \"fail\"\n", "--allow-drift", 0),
        ("drift = \"fail\"\n", "-q", 101),
        ("drift = \"warn\"\n", "--allow-drift=false", 101),
    ] {
        workplace.write("golden/tolerances.toml", &format!("{drift}{tolerances}"));
        let ended = workplace.end_with(&("gate first -b golden", option), exit_code, &[]);
        let headline = ended.stdout.lines().next().unwrap_or_default();
        assert_eq!(headline.ends_with(" scans (allowed)"), exit_code == 0, "{headline}");
        let error = if exit_code == 0 { "" } else { "error: gate FAILED: results changed\n" };
        assert_eq!(ended.stderr, error, "{drift} {option}");
    }
    workplace.write("golden/tolerances.toml", &tolerances);
    let ended = accept("first", "smaller clusters are objects too");
    ended.check_stdout(&[" → ", "objects: hierarchical "]);
    check_gate(&workplace, "first", 0, "PASSED\n");
    let history = workplace.read("golden/SCORES.md");
    let lines: Vec<&str> = history.lines().filter(|it| it.starts_with("- ")).collect();
    assert_eq!(lines.len(), 2, "{history}");
    assert!(lines[0].ends_with(". nothing better yet."), "{history}");
    assert!(lines[1].ends_with(". smaller clusters are objects too."), "{history}");
    let manifest = workplace.json("golden/run/manifest.json");
    assert_eq!(manifest["argv"][0], "scanbench");
    let n_rows = |name: &str| workplace.read(name).lines().count();
    assert!(n_rows("golden/run/matches.csv") < n_rows("first/matches.csv"));
}

/// A worse run is accepted only by whoever says so, having seen what is worse.
#[test]
fn a_worse_run_is_accepted_only_by_name() {
    let workplace = accepted();
    let history = workplace.read("golden/SCORES.md");
    let accept = ["baseline", "accept", "worse", "-b", "golden", "--why", "fewer is more"];
    let ended = workplace.end_with(&accept, 100, &[]);
    ended.check_stdout(&[" losses:\n- ", ": worse\n"]);
    assert!(!ended.stdout.contains("FAILED") && !ended.stdout.contains("PASSED"), "{ended:#?}");
    ended.check_stderr(&["--worse accepts the run all the same"]);
    assert_eq!(workplace.read("golden/SCORES.md"), history, "nothing was accepted");
    check_gate(&workplace, "first", 0, "PASSED\n");
    workplace.succeed(&(&accept, "--worse")).check_stdout(&[": worse\n", ". fewer is more."]);
    check_gate(&workplace, "worse", 0, "PASSED\n");
    // The way back is a gain, and needs no word.
    let back = ["baseline", "accept", "first", "-b", "golden", "--why", "more is more"];
    let ended = workplace.run(&back);
    let n_worse = ended.stdout.matches(": worse").count() + ended.stdout.matches(": inconclusive").count();
    assert_eq!(ended.exit_code, Some(if n_worse == 0 { 0 } else { 100 }), "{ended:#?}");
    ended.check_stdout(&[": better\n"]);
}

/// What `baseline init` writes is about the detectors and tasks of the run, gates it, and names what a changed run did.
#[test]
fn a_first_baseline_gates_the_run_that_it_was_made_of() {
    let workplace = Workplace::new();
    run(&workplace, "first", "-P pca.cluster.min_points=15");
    let ended = workplace.succeed(&["baseline", "init", "first", "-o", "a b/ci/"]);
    ended.check_stdout(&["mv 'a b/ci'/scanbench.yml .github/workflows/"]);
    // It names the run that was written, and says what its scans can show.
    ended.check_stdout(&[
        "scanbench gate first --baseline 'a b/ci' ",
        "These scans cannot show a loss smaller than about this",
        "\n  hierarchical, objects: ",
    ]);
    let names: Vec<String> = ["run/manifest.json", "SCORES.md", "tolerances.toml", "scanbench.yml"]
        .map(|it| format!("a b/ci/{it}"))
        .into();
    assert!(names.iter().all(|it| workplace.path(it).is_file()), "{:?}", workplace.names());
    let tolerances = workplace.read("a b/ci/tolerances.toml");
    let parts = ["detectors = [\"hierarchical\", \"pca\"]", "tasks = [\"objects\", \"vehicles\"]", "[speed]"];
    workplace.check_file("a b/ci/tolerances.toml", &parts);
    assert!(tolerances.lines().any(|it| it.starts_with("# Recall, TP / NO")), "{tolerances}");
    let workflow = workplace.read("a b/ci/scanbench.yml");
    let again = "\n          scanbench run street-narrow --simulated-scans 20 ";
    assert!(workflow.contains(again), "{workflow}");
    assert!(workflow.contains(" -P pca.cluster.min_points=15 -o runs/gate\n"), "{workflow}");
    assert!(workflow.contains("scanbench gate runs/gate --baseline 'a b/ci' -o verdict\n"), "{workflow}");
    let ended = workplace.succeed(&["gate", "first", "--baseline", "a b/ci"]);
    assert!(ended.stdout.starts_with("PASSED") && !ended.stdout.contains("built in"), "{ended:#?}");
    workplace.refuse(&("baseline init first -o", ["a b/ci"]), 2, &["run\" exists; name another folder"]);
    // Words of the template.
    workplace.succeed("baseline init first -o RUN/BASELINE");
    workplace.check_file(
        "RUN/BASELINE/scanbench.yml",
        &[again, "scanbench gate runs/gate --baseline RUN/BASELINE -o verdict\n"],
    );
}

#[test]
fn a_first_baseline_is_written_whole_or_not_at_all() {
    let workplace = Workplace::new();
    run(&workplace, "first", "--scans 0..2:2");
    edit(&workplace, "first/manifest.json", "\"dirty\": false", "\"dirty\": true");
    let names = workplace.names();
    let is_of_a_commit = workplace.read("first/manifest.json").contains("\"dirty\"");
    if is_of_a_commit {
        workplace.refuse("baseline init first -o deep/ci", 2, &[]);
    }
    workplace.refuse("baseline init nowhere -o deep/ci", 2, &[]);
    assert_eq!(workplace.names(), names);
}

/// Any run is a baseline. What is tolerated is printed then, because it stands in no file.
#[test]
fn built_in_tolerances_are_printed() {
    let workplace = accepted();
    let ended = workplace.succeed("gate first --baseline first");
    let said = ended.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("Tolerances: built in,") && said.contains("rates: 1.00 points;"), "{said}");
    assert!(said.contains("; time: 50 %."), "{said}");
    workplace.end_with("gate worse --baseline first", 100, &[]);
    workplace.refuse("gate first", 2, &["there is no baseline reports/golden; name a run with --baseline"]);
}

#[test]
fn runs_that_were_asked_for_other_things_are_not_compared() {
    let workplace = accepted();
    for (name, options, expected) in [
        ("seed", "--seed 7", "the data of street-narrow changed"),
        ("scans", "--scans 0..6:2", "the scans differ: 10 before, 3 now, 3 in common"),
        ("criterion", "--criterion centre", "the matching criterion changed from"),
        ("range", "-P matching.max_range_m=60", "the ignored annotations changed from"),
        ("detectors", "-d pca", "the detector hierarchical is only in the earlier run"),
        ("sensor", "--sensor hdl-32e --scans 0", "the data of street-narrow changed"),
    ] {
        run(&workplace, name, options);
        check_gate(&workplace, name, 5, expected);
        workplace.refuse(&["compare", "first", name], 5, &[]);
    }
    let ours = format!("\"scoring_version\": {SCORING_VERSION}");
    edit(&workplace, "golden/run/manifest.json", &ours, "\"scoring_version\": 0");
    check_gate(&workplace, "first", 5, &format!("the scoring version changed from 0 to {SCORING_VERSION}"));
}

#[test]
fn damaged_files_and_wrong_usage_have_codes_of_their_own() {
    let workplace = accepted();
    check_gate(&workplace, "nowhere", 2, "there is no run directory nowhere");
    workplace.refuse("gate first -b nowhere", 2, &[]);
    workplace.write("bad.toml", &TOLERANCES.replacen("f_rate", "f_rat", 1));
    workplace.refuse("gate first -b golden -t bad.toml", 2, &["there is no metric \"f_rat\""]);
    workplace.refuse(&["baseline", "accept", "first", "-b", "golden", "--why", " "], 2, &[]);
    workplace.refuse("compare first -d pca,nobody", 2, &[]);

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
    assert_eq!(workplace.run("compare first golden/run").exit_code, Some(3));
}

/// Thirty lines say it; the command that they end with prints the rest.
#[test]
fn a_verdict_is_short_unless_all_of_it_is_asked_for() {
    let workplace = accepted();
    let print = |arguments: &[&str]| {
        let ended = workplace.run_with(&[("COLUMNS", "80")], arguments);
        assert_eq!(ended.exit_code, Some(100), "{ended:#?}");
        assert!(ended.stdout.lines().all(|it| it.chars().count() <= 80), "{}", ended.stdout);
        ended.stdout
    };
    let brief = print(&["gate", "worse", "-b", "golden", "--allow-drift"]);
    assert!(brief.lines().count() <= 30 && brief.starts_with("FAILED: worse\n"), "{brief}");
    // Five losses and all gains, each with its interval and what is tolerated.
    let losses_and_gains =
        brief.split_once(" losses:\n").and_then(|(_, rest)| rest.split_once("All gains:\n"));
    let (losses, gains) = losses_and_gains.unwrap_or_else(|| panic!("{brief}"));
    let count =
        |text: &str, part: &str| text.split_whitespace().collect::<Vec<_>>().join(" ").matches(part).count();
    assert_eq!((count(losses, "(95 % "), count(losses, ", tolerated 0.10)")), (5, 5), "{losses}");
    let n_gains = gains.lines().filter(|it| it.starts_with("- ")).count();
    assert!((1..=5).contains(&n_gains), "{brief}");
    assert_eq!((count(losses, ": worse"), count(gains, ": better")), (5, n_gains), "{brief}");
    assert!(count(&brief, "are called worse by chance, on average") == 1, "{brief}");
    let command = "scanbench gate worse --baseline golden --allow-drift=true --full";
    let said = brief.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.ends_with(&format!(" In full: {command}")), "{brief}");
    let full = print(&command.split(' ').skip(1).collect::<Vec<_>>());
    assert!(full.lines().count() > 100 && full.starts_with("FAILED: worse\n"), "{full}");
}

#[test]
fn the_summary_of_a_job_is_added_to() {
    let workplace = accepted();
    workplace.write("summary.md", "before\n");
    let mut command = workplace.command("gate first -b golden");
    command.env("GITHUB_STEP_SUMMARY", workplace.path("summary.md"));
    assert!(command.output().expect("it runs").status.success());
    let summary = workplace.read("summary.md");
    assert!(summary.starts_with("before\n**PASSED**\n"), "{summary}");
    assert!(summary.contains("| objects | pca | all | f_rate"), "{summary}");
}

#[test]
fn two_detectors_are_compared_on_the_same_resamples() {
    let workplace = accepted();
    let text = workplace.succeed("compare first -d pca,hierarchical").stdout;
    assert!(text.contains("hierarchical − pca") && text.contains("detectable"), "{text}");
    let itself = workplace.succeed("compare first golden/run --slices --markdown").stdout;
    assert!(itself.contains(r"| objects | pca | range/0-15 | recall \[%] |"), "{itself}");
    assert!(itself.contains("No result of a scan changed."), "{itself}");
}

/// A loss of fifteen points of F-rate and more, and tolerances that are about something else: whatever it is, the gate does
/// not pass, and does not call it a mere change either.
#[test]
fn tolerances_that_name_nothing_never_let_a_loss_pass() {
    let workplace = accepted();
    let f_rate = |name: &str| -> f64 {
        let report = workplace.json(&format!("{name}/report.json"));
        let is_headline = |row: &&Value| {
            [("metric", "f_rate"), ("task", "objects"), ("detector", "hierarchical"), ("slice", "all")]
                .iter()
                .all(|(key, value)| row[*key] == *value)
        };
        let row = report["rows"].as_array().expect("a list").iter().find(is_headline);
        row.expect("a row")["value"].as_f64().expect("a number")
    };
    assert!(f_rate("first") - f_rate("worse") > 0.15, "{} {}", f_rate("first"), f_rate("worse"));
    let rule = |metrics: &str, slices: &str, more: &str| {
        let sizes = if more.contains("relative") { "" } else { "absolute = 0.005\nrelative = 0.0\n" };
        format!("[[quality]]\nmetrics = [{metrics}]\nslices = [{slices}]\n{sizes}{more}\n")
    };
    let all = "\"all\"";
    // The tests of `reports` have every mistake; here a mistake fails the gate.
    for (tolerances, expected) in [
        (rule("\"f_rate\"", all, "slice = 1"), "unknown field `slice`"),
        (rule("\"f_rate\"", "\"al\"", ""), "there is no slice \"al\" in either run; did you mean \"all\"?"),
        (
            rule("\"precision\"", "\"class/*\"", ""),
            "the rule has no effect on precision of \"class/*\": neither run has it",
        ),
        (
            rule("\"f_rate\"", all, "absolute = 0.9\nrelative = 0.0"),
            "absolute = 0.9 would pass nearly everything",
        ),
    ] {
        workplace.write("golden/tolerances.toml", &tolerances);
        let ended = check_gate(&workplace, "worse", 2, expected);
        assert_eq!(ended.stdout, "", "{tolerances}");
        assert_eq!(ended.stderr.matches(expected).count(), 1, "{}", ended.stderr);
        // Beside a rule that is right, too.
        workplace.write("golden/tolerances.toml", &format!("{TOLERANCES}{tolerances}"));
        check_gate(&workplace, "worse", 2, expected);
    }
    workplace.write("golden/tolerances.toml", &rule("\"f_rate\"", all, "tasks = [\"objects\"]"));
    check_gate(&workplace, "worse", 100, "FAILED: worse\n");
}

#[test]
fn a_number_that_is_missing_in_the_run_is_named_with_its_subject() {
    let workplace = accepted();
    copy_folder(&workplace.path("first"), &workplace.path("unknown"));
    // As if false objects could not be known: a scan without their number.
    let text = workplace.read("unknown/scans.csv");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let fo = lines[0].split(',').position(|it| it == "fo").expect("a column");
    let mut cells: Vec<&str> = lines[1].split(',').collect();
    assert_eq!((cells[4], cells[5]), ("hierarchical", "objects"));
    cells[fo] = "";
    lines[1] = cells.join(",");
    workplace.write("unknown/scans.csv", &(lines.join("\n") + "\n"));
    let expected = "f_rate of all, hierarchical, objects, street-narrow: missing in the run.";
    let ended = check_gate(&workplace, "unknown", 5, expected);
    assert!(ended.stdout.starts_with("FAILED: numbers are missing\n"), "{}", ended.stdout);
    let verdict = workplace.json("verdict/gate.json");
    assert_eq!(verdict["conclusion"], "incomparable");
}

/// The same loss as of ten streets, but of nine scans of nine seconds: nothing is sure.
#[test]
fn of_few_blocks_nothing_is_surely_worse() {
    let workplace = Workplace::new();
    workplace.write("tolerances.toml", TOLERANCES);
    let nine = "--simulated-scans 18 --scans 0..18:2";
    run(&workplace, "once", nine);
    run(&workplace, "worse", &format!("{nine} {WORSE}"));
    workplace.end_with("gate worse -b once -t tolerances.toml --full", 101, &[]).check_stdout(&[
        "Only 9 blocks of scans: too few to show that anything is worse.",
        "inconclusive: 9 blocks",
        "§ from fewer than 10 blocks",
    ]);
    let text = workplace.succeed("compare once worse").stdout;
    assert!(text.contains('§') && text.contains("§ from fewer than 10 blocks"), "{text}");
    let table = workplace.read("once/table_objects.md");
    assert!(table.contains('§'), "{table}");
    workplace.check_file("once/table_objects.tex", &["\\S{}"]);
    let csv = workplace.read("once/table_objects.csv");
    assert!(csv.lines().nth(1).expect("a row").ends_with(",9,seconds,true"), "{csv}");
    workplace.check_file("once/report.html", &["9 blocks of scans are too few to show which one leads"]);
    workplace.check_file("once/report.json", &["\"caveat\":\"interval from only 9 blocks of scans\""]);
}

#[test]
fn times_are_held_against_the_reference_on_the_same_processor_alone() {
    let workplace = accepted();
    let speed = "\n[speed]\nreference = \"grid-write\"\nrelative = 0.1\n";
    workplace.write("golden/tolerances.toml", &format!("{TOLERANCES}{speed}"));
    let ended = check_gate(&workplace, "first", 0, "grid-write");
    assert!(!ended.stdout.contains("Speed was not compared"), "{}", ended.stdout);
    // Every detection of pca takes half as long again, and only that is seen.
    copy_folder(&workplace.path("first"), &workplace.path("slower"));
    let text = workplace.read("first/scans.csv");
    let slower = text.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if cells[4] == "pca" {
            cells[11] = format!("{:.3}", 1.5 * cells[11].parse::<f64>().expect("a time"));
        }
        cells.join(",") + "\n"
    });
    assert_eq!(text.lines().next().expect("a head").split(',').nth(11), Some("least_latency_ms"));
    workplace.write("slower/scans.csv", &slower.collect::<String>());
    let ended = check_gate(&workplace, "slower", 100, "FAILED: worse\n");
    ended.check_stdout(&[" 1 worse,"]);
    let verdict = workplace.json("verdict/gate.json");
    let slowdown = verdict["speeds"][1]["slowdown"].as_f64().expect("a number");
    assert!((slowdown - 0.5).abs() < 0.01 && verdict["speeds"][1]["detector"] == "pca", "{verdict}");
    // On another processor that says nothing, and the verdict says so at once.
    edit(&workplace, "slower/manifest.json", "\"cpu_model\": \"", "\"cpu_model\": \"Another ");
    let ended = check_gate(&workplace, "slower", 0, "PASSED\n");
    let third = ended.stdout.lines().nth(2).expect("a line");
    assert!(
        third.starts_with("Speed was not compared: the processor changed from ")
            && third.contains("Another "),
        "{third}"
    );
    // The report has what a verdict is made of.
    let report = workplace.json("first/report.json");
    for metric in ["reference_ms", "time_over_reference"] {
        let has = |row: &Value| row["metric"] == metric && row["value"].as_f64().is_some_and(|it| it > 0.0);
        assert!(report["rows"].as_array().expect("a list").iter().any(has), "{metric}");
    }
}

#[test]
fn repetitions_change_no_number_but_the_least_time() {
    let workplace = Workplace::new();
    workplace.write("tolerances.toml", TOLERANCES);
    run(&workplace, "once", "--scans 0..4:2");
    run(&workplace, "thrice", "--scans 0..4:2 --repeats 3");
    workplace.succeed("gate thrice -b once -t tolerances.toml");
    assert_eq!(workplace.read("once/matches.csv"), workplace.read("thrice/matches.csv"));
    let manifest = workplace.json("thrice/manifest.json");
    assert_eq!(manifest["n_repeats"], 3);
    let scans = workplace.read("thrice/scans.csv");
    let times = scans.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        [10, 11].map(|it| cells[it].parse::<f64>().expect("a time"))
    });
    let times: Vec<[f64; 2]> = times.collect();
    assert!(times.iter().all(|[first, least]| least <= first), "{times:?}");
    assert!(workplace.read("once/scans.csv").lines().skip(1).all(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        cells[10] == cells[11]
    }));
    assert_eq!(workplace.run("run --repeats 0").exit_code, Some(2));
}

#[test]
fn what_cannot_be_made_again_or_compared_is_not_accepted() {
    let workplace = accepted();
    copy_folder(&workplace.path("first"), &workplace.path("changed"));
    edit(&workplace, "changed/manifest.json", "\"dirty\": false", "\"dirty\": true");
    let history = workplace.read("golden/SCORES.md");
    let accept = |name: &str, more: &[&str], code: i32, expected: &str| {
        let ended = workplace.end_with(
            &(["baseline", "accept", name, "-b", "golden", "--why", "x"], more),
            code,
            &[],
        );
        assert!(ended.stderr.contains(expected) || ended.stdout.contains(expected), "{ended:#?}");
    };
    if workplace.read("changed/manifest.json").contains("\"dirty\"") {
        for more in [&[][..], &["--new-baseline"]] {
            accept("changed", more, 2, "with uncommitted changes after commit");
        }
    }
    run(&workplace, "seed", "--seed 7");
    accept("seed", &[], 5, "the data of street-narrow changed");
    accept("seed", &[], 5, "--new-baseline");
    assert_eq!(workplace.read("golden/SCORES.md"), history, "nothing was accepted");
    check_gate(&workplace, "first", 0, "PASSED\n");
    accept("seed", &["--new-baseline"], 0, "New baseline: the run cannot be compared with the accepted one");
    check_gate(&workplace, "seed", 0, "PASSED\n");
    // One that cannot be read is no baseline either.
    workplace.write("golden/run/scans.csv", "damaged\n");
    accept("seed", &[], 5, "cannot read the accepted run golden/run");
    accept("seed", &["--new-baseline"], 0, "cannot read the accepted run golden/run");
    check_gate(&workplace, "seed", 0, "PASSED\n");
}

#[test]
fn what_changed_in_a_detector_of_others_is_reported() {
    let workplace = Workplace::new();
    let served = env!("CARGO_BIN_EXE_scanbench");
    let run = |script: &str, vehicles: &str, name: &str| {
        workplace.write("mine.sh", script);
        let configuration =
            format!("[detector.mine]\ncommand = [\"sh\", \"mine.sh\"]\nvehicles = {vehicles:?}\n");
        workplace.write("scanbench.toml", &configuration);
        run(&workplace, name, "-d mine");
    };
    let script = format!("exec {served:?} serve kd-tree\n");
    run(&script, "size", "first");
    run(&format!("# Mine.\n{script}"), "model", "second");
    let said = "Configuration changed: mine: vehicles: size → model; mine: mine.sh: SHA-256 ";
    for full in [&[][..], &["--full"]] {
        workplace.succeed(&("gate second -b first", full)).check_stdout(&["PASSED\n", said]);
    }
    workplace.succeed("compare first second").check_stdout(&[said]);
    workplace
        .check_file("second/report.html", &["<code>sh mine.sh</code>", "<code>mine.sh</code> of SHA-256 "]);
    let table = workplace.read("second/table_vehicles.md");
    let classified = "Vehicles classified by: mine: its own classes, else trees trained on kd-tree components; boxes of its own, else whole ones of ours.";
    assert!(table.contains(classified), "{table}");
}
