//! Baselines: how the first is made, and which runs replace it.

use crate::accepted::{TOLERANCES, accepted, check_gate, edit, run};
use crate::program::{Workplace, copy_folder};

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
    ended.check_stdout(&[" losses, in tolerances:\n- ", ": worse\n"]);
    assert!(!ended.stdout.contains("FAILED") && !ended.stdout.contains("PASSED"), "{ended:#?}");
    ended.check_stderr(&["--worse accepts the run all the same"]);
    assert_eq!(workplace.read("golden/SCORES.md"), history, "nothing was accepted");
    check_gate(&workplace, "first", 0, "PASSED\n");
    let ended = workplace.succeed(&(&accept, "--worse"));
    ended.check_stdout(&[": worse\n", ". fewer is more."]);
    // A workflow still has the command without it.
    ended.check_stderr(&["The command of the run has changed. ", " -o runs/gate\n"]);
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
    let streets = "street-narrow --simulated-scans 20 --scans 0..20:2 --sensor vlp-16 --seed 9001";
    run(&workplace, streets, "first", "-P pca.cluster.min_points=15");
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
    let workplace = accepted();
    edit(&workplace, "first/manifest.json", "\"dirty\": false", "\"dirty\": true");
    let names = workplace.names();
    let is_of_a_commit = workplace.read("first/manifest.json").contains("\"dirty\"");
    if is_of_a_commit {
        workplace.refuse("baseline init first -o deep/ci", 2, &[]);
    }
    workplace.refuse("baseline init nowhere -o deep/ci", 2, &[]);
    assert_eq!(workplace.names(), names);
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
    run(&workplace, "street-narrow --seed 7 --simulated-scans 2 --sensor vlp-16", "seed", "");
    accept("seed", &[], 5, "the data sets changed from narrow to street-narrow");
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
