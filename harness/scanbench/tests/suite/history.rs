//! Histories: runs added to a file, what changed when, and what was lost since.

use crate::program::{Workplace, copy_folder};

/// Runs `pca` with this least height difference, as if it had been on this day of January.
fn run_of(workplace: &Workplace, day: u32, min_height_m: f64) -> String {
    let name = format!("run-{day:02}");
    let made = format!("made-{min_height_m}");
    if !workplace.path(&made).exists() {
        workplace.succeed(&format!(
            "run streets --scans 0..20:10 -d pca -P pca.occupancy.min_height_difference_m={min_height_m} --no-rrd -o {made}"
        ));
    }
    copy_folder(&workplace.path(&made), &workplace.path(&name));
    let manifest = workplace.read(&format!("{name}/manifest.json"));
    let created =
        workplace.json(&format!("{name}/manifest.json"))["created"].as_str().expect("a time").to_owned();
    let manifest = manifest.replace(&created, &format!("2026-01-{day:02}T12:00:00Z"));
    workplace.write(&format!("{name}/manifest.json"), &manifest);
    name
}

#[test]
fn the_run_is_found_at_which_numbers_changed_and_what_changed_then() {
    let workplace = Workplace::new();
    let runs: Vec<String> =
        (1..=14).map(|day| run_of(&workplace, day, if day < 8 { 0.2 } else { 0.5 })).collect();
    for run in &runs {
        workplace.succeed(&format!("gate {run} --baseline {run} --history h.jsonl"));
    }
    let history = workplace.read("h.jsonl");
    assert!(history.starts_with("{\"line\":\"history\",\"schema\":1}\n"));
    assert_eq!(history.matches("\"line\":\"run\"").count(), 14);
    assert_eq!(history.matches("\"line\":\"settings\"").count(), 2);
    // A run that is there already is not counted twice, wherever its page is.
    workplace.succeed("gate run-01 --baseline run-01 --history linked.jsonl --link https://ci.example/1");
    workplace.succeed("gate run-01 --baseline run-01 --history linked.jsonl --link https://ci.example/2");
    let linked = workplace.read("linked.jsonl");
    assert_eq!(linked.matches("\"line\":\"run\"").count(), 1, "{linked}");
    assert!(linked.contains("https://ci.example/2") && !linked.contains("https://ci.example/1"), "{linked}");
    // Names of runs in old files had the link in them.
    let name_of = |history: &str| {
        let line = history.lines().find(|it| it.contains("\"line\":\"run\"")).expect("a run");
        line.split('"').nth(7).expect("a name").to_owned()
    };
    let named = name_of(&linked);
    let old = linked.replace(&named, &format!("{}0123456789ab", &named[..named.len() - 12]));
    workplace.write("old.jsonl", &old.replace("example/2", "example/0"));
    workplace.succeed("gate run-01 --baseline run-01 --history old.jsonl --link https://ci.example/2");
    assert_eq!(workplace.read("old.jsonl"), old);
    workplace.write("twice.jsonl", &format!("{linked}{old}"));
    for files in ["old.jsonl linked.jsonl", "twice.jsonl", "run-01 old.jsonl"] {
        workplace.succeed(&format!("history {files}")).check_stdout(&["1 runs"]);
    }
    // Nor does it change anything, and neither does the order of lines, or a line twice.
    workplace.succeed("gate run-01 --baseline run-01 --history h.jsonl");
    assert_eq!(workplace.read("h.jsonl"), history);
    let mut lines: Vec<&str> = history.lines().rev().collect();
    lines.push(lines[3]);
    workplace.write("mixed.jsonl", &(lines.join("\n") + "\n"));
    workplace.succeed("gate run-01 --baseline run-01 --history mixed.jsonl");
    assert_eq!(workplace.read("mixed.jsonl"), history);

    let shown = workplace.succeed("history h.jsonl -o page");
    shown.check_stdout(&[
        "14 runs, 2026-01-01T12:00:00Z to 2026-01-14T12:00:00Z",
        "Run 8, 2026-01-08T12:00:00Z",
        "pca: occupancy.min_height_difference_m: 0.2 → 0.5",
        "f_rate of objects, pca, overall",
    ]);
    assert_eq!(shown.stdout.matches("\nRun ").count(), 1, "{}", shown.stdout);
    workplace.check_file("page/history.html", &["History of 14 runs", "Run 8,", "<svg"]);
    assert_eq!(workplace.read("page/history.jsonl"), history);
    // Run directories give what a history of them gives.
    let of_runs = workplace.succeed(&format!("history {}", runs.join(" ")));
    assert_eq!(of_runs.stdout, shown.stdout);
}

#[test]
fn a_slow_loss_is_a_loss_since_an_earlier_run() {
    let workplace = Workplace::new();
    let runs: Vec<String> = [0.2, 0.5, 0.8]
        .into_iter()
        .zip(1..)
        .map(|(height_m, day)| run_of(&workplace, day, height_m))
        .collect();
    workplace.write(
        "wide.toml",
        "[[quality]]\nmetrics = [\"recall\"]\nslices = [\"all\"]\ntasks = [\"objects\"]\nabsolute = 0.06\nrelative = 0.0\n",
    );
    let recall = |run: &str| {
        let report = workplace.json(&format!("{run}/report.json"));
        let rows = report["overall"].as_array().unwrap().clone();
        let is_asked = |it: &&serde_json::Value| {
            it["metric"] == "recall" && it["task"] == "objects" && it["slice"] == "all"
        };
        rows.iter().find(is_asked).unwrap()["value"].as_f64().unwrap()
    };
    let recalls: Vec<f64> = runs.iter().map(|it| recall(it)).collect();
    assert!(recalls[0] - recalls[2] > 0.06, "{recalls:?}");
    let gate = "--tolerances wide.toml --allow-drift --history h.jsonl";
    workplace.succeed(&format!("gate run-01 --baseline run-01 {gate}"));
    workplace.run(&format!("gate run-03 --baseline run-02 {gate}"));
    let ended = workplace.run(&format!("gate run-03 --baseline run-03 {gate} --since 2026-01-01"));
    assert_eq!(ended.exit_code, Some(100), "{ended:?}");
    let closed = "FAILED: worse than an earlier run of the history";
    ended.check_stdout(&[closed, "Since 2026-01-01T12:00:00Z", "recall of objects, all, pca, overall"]);
    // All files of the verdict say so.
    workplace.run(&format!("gate run-03 --baseline run-03 {gate} --since 2026-01-01 -o verdict"));
    workplace.check_file("verdict/gate.md", &[closed, "Since 2026-01-01T12:00:00Z"]);
    workplace.check_file("verdict/gate.json", &["\"conclusion\": \"worse-since\"", "\"since\": ["]);
    workplace.check_file("verdict/junit.xml", &["scanbench.since", "failures=\"1\""]);
    workplace.succeed(&format!("gate run-03 --baseline run-03 {gate} --since 2026-01-03"));
    workplace.end_with(
        &format!("gate run-03 --baseline run-03 {gate} --since 2025"),
        2,
        &["--since: no run of the history has a name or a commit that begins with \"2025\"; it has 2 runs"],
    );
}

#[test]
fn runs_that_cannot_be_compared_are_on_separate_lines() {
    let workplace = Workplace::new();
    for (name, scans) in [("a", "0..20:10"), ("b", "0..20:5")] {
        workplace.succeed(&format!("run streets --scans {scans} -d pca --no-rrd -o {name}"));
    }
    let ended = workplace.succeed("history a b");
    ended.check_stdout(&["begins another line: the chosen scans of street-main-road changed"]);
    // Nor by a run between them that lacks the detector that was judged by other rules.
    workplace.succeed("run streets --scans 0..20:10 -d pca,simple-grid --no-rrd -o c");
    copy_folder(&workplace.path("c"), &workplace.path("d"));
    for (name, day, version) in [("c", 1, 1), ("a", 2, 2), ("d", 3, 2)] {
        let path = format!("{name}/manifest.json");
        let mut manifest = workplace.json(&path);
        manifest["created"] = format!("2026-01-{day:02}T12:00:00Z").into();
        let detectors = manifest["detectors"].as_array_mut().expect("a list");
        detectors.last_mut().expect("a detector")["scoring_version"] = version.into();
        workplace.write(&path, &manifest.to_string());
    }
    let ended = workplace.succeed("history a c d");
    ended.check_stdout(&["begins another line: the scoring version of simple-grid changed from 1 to 2"]);
    workplace.refuse("history a --metric beauty", 2, &["\"beauty\" is no metric that a history keeps"]);
    workplace.write("h.jsonl", "{\"line\":\"history\",\"schema\":1}\nnonsense\n");
    workplace.refuse("history h.jsonl", 3, &["h.jsonl", "line 2: expected"]);
    workplace.write("h.jsonl", "{\"line\":\"history\",\"schema\":9}\n");
    workplace.refuse("history h.jsonl", 3, &["schema 9 is not that of this program, 1"]);
}

/// The commit of a run is that of the repository that it was made in.
#[test]
fn runs_are_told_apart_by_the_commits_of_a_project() {
    let workplace = Workplace::new();
    let git = |arguments: &[&str]| {
        let mut command = std::process::Command::new("git");
        command.args(["-c", "user.name=me", "-c", "user.email=me@example.org"]).args(arguments);
        let ended = command.current_dir(workplace.folder()).output().expect("git starts");
        assert!(ended.status.success(), "{ended:?}");
        String::from_utf8(ended.stdout).expect("text").trim().to_owned()
    };
    git(&["init", "-q"]);
    workplace.write("note", "1");
    git(&["add", "note"]);
    git(&["commit", "-q", "-m", "first"]);
    let first = git(&["rev-parse", "HEAD"]);
    let run = "run street-narrow --simulated-scans 1 --sensor vlp-16 -d pca --no-rrd -o";
    workplace.succeed(&(run, "a"));
    let project = &workplace.json("a/manifest.json")["project"];
    assert_eq!((&project["commit"], &project["dirty"]), (&first.as_str().into(), &false.into()));
    workplace.check_file("a/report.html", &[&first]);
    workplace.write("note", "2");
    workplace.succeed(&(run, "b"));
    assert_eq!(workplace.json("b/manifest.json")["project"]["dirty"], true);
    workplace.succeed("gate a --baseline a --history h.jsonl");
    let since = format!("gate b --baseline a --history h.jsonl --since {}", &first[..7]);
    workplace.succeed(&since).check_stdout(&["none of", "is worse than tolerated; times are"]);
    let history = workplace.read("h.jsonl");
    assert_eq!(history.matches(&format!("\"commit\":\"{first}\"")).count(), 2, "{history}");
    workplace.succeed("history h.jsonl").check_stdout(&["No number", "2 runs"]);
}
