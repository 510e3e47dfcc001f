//! Runs judged by others: what passes, what does not, and with which exit code.

use evaluation::metrics::counts::SCORING_VERSION;
use serde_json::Value;

use crate::accepted::{TOLERANCES, accepted, check_gate, edit, run};
use crate::program::{Row, copy_folder};

/// Two detectors in another order, on one thread, three times each.
#[test]
fn a_run_is_as_good_as_itself_and_as_its_repetition() {
    let workplace = accepted();
    check_gate(&workplace, "first", 0, "PASSED\n");
    check_gate(&workplace, "golden/run", 0, "PASSED\n");
    run(&workplace, "narrow.mcap", "again", "--jobs 1 --warmup 0 --repeats 3 -d pca,hierarchical");
    let ended = check_gate(&workplace, "again", 0, "No result changed.");
    assert!(!ended.stdout.contains("inconclusive\n"), "{}", ended.stdout);
    let [first, again] = ["first", "again"].map(|run| {
        let mut matches: Vec<String> =
            workplace.read(&format!("{run}/matches.csv")).lines().map(str::to_owned).collect();
        matches.sort();
        matches
    });
    assert_eq!(first, again);
    // Repetitions have a least time, and nothing else.
    assert_eq!(workplace.json("again/manifest.json")["n_repeats"], 3);
    let times = |run: &str| -> Vec<[f64; 2]> {
        // Tasks of classes have no times of their own.
        let rows =
            workplace.table(&format!("{run}/scans.csv")).into_iter().filter(|it| it["task"] == "objects");
        let time = |row: &Row, name: &str| row[name].parse().expect("a time");
        rows.map(|it| [time(&it, "latency_ms"), time(&it, "least_latency_ms")]).collect()
    };
    assert!(times("again").iter().all(|[first, least]| least <= first), "{:?}", times("again"));
    assert!(times("first").iter().all(|[first, least]| least == first), "{:?}", times("first"));
    workplace.refuse("run --repeats 0", 2, &[]);
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
        run(&workplace, "narrow.mcap", run_name, &format!("-P {parameter}"));
        let ended = workplace.run(&["gate", run_name, "-b", "golden", "-o", "verdict", "--full"]);
        assert!(matches!(ended.exit_code, Some(100 | 101)), "{parameter}: {ended:#?}");
        let changed: Vec<&str> =
            ended.stdout.lines().filter(|it| it.starts_with("  narrow/narrow-90")).collect();
        assert!(
            changed.iter().any(|it| it.contains(" m")),
            "{parameter}: no object is named\n{}",
            ended.stdout
        );
        assert!(changed.iter().all(|it| it.contains(", hierarchical, ")), "{parameter}: {changed:?}");
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

/// The tests of `reports` have everything that may differ; here it is of real runs, and what their manifests say is heard.
#[test]
fn runs_that_were_asked_for_other_things_are_not_compared() {
    let workplace = accepted();
    run(&workplace, "narrow.mcap", "other", "--scans 0..3 -d pca");
    check_gate(&workplace, "other", 5, "the scans differ: 10 before, 3 now, 3 in common");
    let seed = "street-narrow --seed 7 --simulated-scans 1 --sensor vlp-16";
    run(&workplace, seed, "other", "-d pca --overwrite");
    check_gate(&workplace, "other", 5, "the data sets changed from narrow to street-narrow");
    run(&workplace, "narrow.mcap", "other", "-d pca --overwrite");
    check_gate(&workplace, "other", 5, "the detector hierarchical is only in the earlier run");
    workplace.refuse("compare first other", 5, &[]);
    let manifest = workplace.read("golden/run/manifest.json");
    let ours = format!("\"scoring_version\": {SCORING_VERSION}");
    let versions = format!("the scoring version of hierarchical, pca changed from 0 to {SCORING_VERSION}");
    for (from, to, expected) in [
        (ours.as_str(), "\"scoring_version\": 0", versions.as_str()),
        ("\"checksum\": \"", "\"checksum\": \"0", "the data of narrow changed"),
        (
            "\"matching_criterion\": \"points",
            "\"matching_criterion\": \"centre",
            "the matching criterion changed from",
        ),
        ("\"max_range_m\": ", "\"max_range_m\": 1", "the ignored annotations changed from"),
    ] {
        workplace.write("golden/run/manifest.json", &manifest.replace(from, to));
        check_gate(&workplace, "first", 5, expected);
    }
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

/// Thirty lines say it, as the tests of `reports` show; the command that they end with prints the rest.
#[test]
fn a_verdict_is_short_unless_all_of_it_is_asked_for() {
    let workplace = accepted();
    let print = |arguments: &str| {
        let ended = workplace.run_with(&[("COLUMNS", "80")], arguments);
        assert_eq!(ended.exit_code, Some(100), "{ended:#?}");
        assert!(ended.stdout.lines().all(|it| it.chars().count() <= 80), "{}", ended.stdout);
        ended.stdout
    };
    let brief = print("gate worse -b golden --allow-drift");
    assert!(brief.lines().count() <= 30 && brief.starts_with("FAILED: worse\n"), "{brief}");
    assert!(brief.contains(" losses, in tolerances:\n") && brief.contains("All gains:\n"), "{brief}");
    let command = "gate worse --baseline golden --allow-drift=true --full";
    let said = brief.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.ends_with(&format!(" In full: scanbench {command}")), "{brief}");
    let full = print(command);
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

/// The verdict is printed and written all the same, and a gate that has failed ends as it would without a history.
#[test]
fn a_history_that_fails_hides_no_verdict() {
    let workplace = accepted();
    workplace.write("bad.jsonl", "{\"line\":\"history\",\"schema\":1}\nnonsense\n");
    run(&workplace, "narrow.mcap", "few", "--scans 0..3");
    workplace.succeed("gate few -b few --history few.jsonl");
    let created = workplace.json("few/manifest.json")["created"].as_str().expect("a time").to_owned();
    let since_few = format!("few.jsonl --since {created}");
    for (history, exit_code, problem) in [
        ("gone/h.jsonl", 2, "cannot write \"gone/h.jsonl\""),
        ("bad.jsonl", 3, "bad.jsonl"),
        (
            "h.jsonl --since 1999",
            2,
            "--since: no run of the history has a name or a commit that begins with \"1999\"",
        ),
        (&since_few, 5, "the chosen scans of narrow changed"),
    ] {
        for (run, exit_code, first_line) in
            [("first", exit_code, "PASSED\n"), ("worse", 100, "FAILED: worse\n")]
        {
            let gate = format!("gate {run} -b golden -t tolerances.toml -o verdict --history {history}");
            let ended = workplace.end_with(&gate, exit_code, &["error: ", problem]);
            assert!(ended.stdout.starts_with(first_line), "{gate}: {ended:#?}");
            for name in ["gate.md", "gate.json"] {
                workplace.check_file(&format!("verdict/{name}"), &["History: "]);
            }
            workplace.check_file("verdict/junit.xml", &["scanbench.objects.hierarchical"]);
            std::fs::remove_dir_all(workplace.path("verdict")).expect("it was written");
        }
    }
    assert!(!workplace.path("gone").exists());
    assert!(workplace.read("bad.jsonl").ends_with("nonsense\n"));
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

/// Tolerances that are about something else: the gate does not pass, and does not call a loss a mere change either. The
/// tests of `reports` have every mistake.
#[test]
fn tolerances_that_name_nothing_never_let_a_loss_pass() {
    let workplace = accepted();
    let rule = |slices: &str| {
        format!(
            "[[quality]]\nmetrics = [\"f_rate\"]\nslices = [{slices:?}]\nabsolute = 0.005\nrelative = 0.0\n"
        )
    };
    let expected = "there is no slice \"al\" in either run; did you mean \"all\"?";
    // Beside rules that are right, too.
    for tolerances in [rule("al"), format!("{TOLERANCES}{}", rule("al"))] {
        workplace.write("golden/tolerances.toml", &tolerances);
        let ended = check_gate(&workplace, "worse", 2, expected);
        assert_eq!((ended.stdout.as_str(), ended.stderr.matches(expected).count()), ("", 1), "{tolerances}");
    }
    workplace.write("golden/tolerances.toml", &rule("all"));
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
    let expected = "f_rate of all, hierarchical, objects, narrow: missing in the run.";
    let ended = check_gate(&workplace, "unknown", 5, expected);
    assert!(ended.stdout.starts_with("FAILED: numbers are missing\n"), "{}", ended.stdout);
    let verdict = workplace.json("verdict/gate.json");
    assert_eq!(verdict["conclusion"], "incomparable");
}

/// The same loss as of ten streets, but of nine scans of nine seconds: nothing is sure, and all that is written says so.
#[test]
fn of_few_blocks_nothing_is_surely_worse() {
    let workplace = accepted();
    run(&workplace, "narrow.mcap", "once", "--scans 0..9");
    let worse = "--scans 0..9 -P hierarchical.cluster.min_points=200 --overwrite";
    run(&workplace, "narrow.mcap", "worse", worse);
    workplace.end_with("gate worse -b once -t tolerances.toml --full", 101, &[]).check_stdout(&[
        "Only 9 blocks of scans: too few to show that anything is worse.",
        "inconclusive: 9 blocks",
        "§ from fewer than 10 blocks",
    ]);
    workplace.succeed("compare once worse").check_stdout(&["§ from fewer than 10 blocks"]);
    for (file, part) in [
        ("table_objects.md", "§"),
        ("table_objects.tex", "\\S{}"),
        ("table_objects.csv", ",9,seconds,true\n"),
        ("report.html", "9 blocks of scans are too few to show which one leads"),
        ("report.json", "\"caveat\":\"interval from only 9 blocks of scans\""),
    ] {
        workplace.check_file(&format!("once/{file}"), &[part]);
    }
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

/// Detectors of others are judged by a scoring version of their own, which is no matter of the ones that both runs have.
#[test]
fn a_detector_of_others_may_join_and_is_compared_under_its_own_scoring_version() {
    let workplace = accepted();
    let command = format!(
        "[detector.mine]\ncommand = [{:?}, \"serve\", \"kd-tree\"]\n",
        env!("CARGO_BIN_EXE_scanbench")
    );
    workplace.write("scanbench.toml", &command);
    run(&workplace, "narrow.mcap", "both", "-d hierarchical,pca,mine");
    copy_folder(&workplace.path("first"), &workplace.path("joined"));
    workplace.succeed("run --add-to joined -d mine --no-rrd");
    let joins = "Not judged, because only the later run has it: mine.";
    for name in ["both", "joined"] {
        check_gate(&workplace, name, 0, joins).check_stdout(&["PASSED\n"]);
        let manifest = workplace.json(&format!("{name}/manifest.json"));
        let versions: Vec<&Value> = manifest["detectors"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|it| &it["scoring_version"])
            .collect();
        assert_eq!(
            (&manifest["scoring_version"], versions),
            (&4.into(), vec![&2.into(), &2.into(), &4.into()])
        );
    }
    workplace.succeed("gate first -b golden --history h.jsonl");
    workplace.succeed("gate both -b golden --history h.jsonl --since 20");
    let shown = workplace.succeed("history h.jsonl").stdout;
    assert!(shown.contains("2 runs") && !shown.contains("begins another line"), "{shown}");

    // Runs from before each detector had its version: their own was that of detectors of others alone.
    let manifest = workplace.json("both/manifest.json");
    let write = |version_of_run: u32, version_of_mine: Option<u32>| {
        let mut manifest = manifest.clone();
        manifest["scoring_version"] = version_of_run.into();
        for entry in manifest["detectors"].as_array_mut().expect("a list") {
            let entry = entry.as_object_mut().expect("an entry");
            entry.remove("scoring_version");
            if let Some(version) = version_of_mine.filter(|_| entry["name"] == "mine") {
                entry.insert("scoring_version".to_owned(), version.into());
            }
        }
        workplace.write("older/manifest.json", &manifest.to_string());
    };
    copy_folder(&workplace.path("both"), &workplace.path("older"));
    write(4, None);
    check_gate(&workplace, "older", 0, joins);
    workplace.succeed("gate both -b older -t tolerances.toml");
    for (version_of_run, version_of_mine) in [(2, None), (4, Some(2))] {
        write(version_of_run, version_of_mine);
        let changed = "the scoring version of mine changed from 2 to 4";
        workplace.refuse("gate both -b older -t tolerances.toml", 5, &[changed]);
        check_gate(&workplace, "older", 0, joins);
    }
}

#[test]
fn what_changed_in_a_detector_of_others_is_reported() {
    let workplace = accepted();
    let served = env!("CARGO_BIN_EXE_scanbench");
    let run = |script: &str, vehicles: &str, name: &str| {
        workplace.write("mine.sh", script);
        let configuration =
            format!("[detector.mine]\ncommand = [\"sh\", \"mine.sh\"]\nvehicles = {vehicles:?}\n");
        workplace.write("scanbench.toml", &configuration);
        run(&workplace, "narrow.mcap", name, "-d mine --scans 0..3");
    };
    let script = format!("exec {served:?} serve kd-tree\n");
    run(&script, "size", "mine");
    run(&format!("# Mine.\n{script}"), "model", "changed");
    let said = "Configuration changed: mine: vehicles: size → model; mine: mine.sh: SHA-256 ";
    for full in [&[][..], &["--full"]] {
        workplace.succeed(&("gate changed -b mine", full)).check_stdout(&[
            "PASSED",
            "No result changed.",
            said,
        ]);
    }
    workplace.succeed("compare mine changed").check_stdout(&[said]);
    workplace
        .check_file("changed/report.html", &["<code>sh mine.sh</code>", "<code>mine.sh</code> of SHA-256 "]);
    let table = workplace.read("changed/table_vehicles.md");
    let classified = "Vehicles classified by: mine: its own classes, else trees trained on kd-tree components; boxes of its own, else whole ones of ours.";
    assert!(table.contains(classified), "{table}");
}
