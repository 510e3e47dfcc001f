//! `scanbench partial`: what an object is of which a part has been seen.

use std::fmt::Write as _;
use std::path::Path;

use test_data::test_data;

use crate::program::{Ended, Workplace};

fn rows(workplace: &Workplace, path: &str) -> Vec<Vec<String>> {
    let text = workplace.read(path);
    text.lines().skip(1).map(|it| it.split(',').map(str::to_owned).collect()).collect()
}

/// The names of files of the result in `out` that have some content.
#[track_caller]
fn check_files(workplace: &Workplace, names: &[&str]) {
    for name in names {
        assert!(std::fs::metadata(workplace.path("out").join(name)).is_ok_and(|it| it.len() > 200), "{name}");
    }
}

#[test]
fn the_shipped_model_classifies_objects_and_the_same_comes_out_again() {
    let workplace = Workplace::new();
    let arguments = ["partial", "objects-vlp-16", "--per-class", "4", "--others", "-o"];
    let ended = workplace.succeed(&[&arguments[..], &["out"]].concat());
    let title = "Partial clouds: objects-vlp-16 (simulated), classified by the shipped model";
    assert!(ended.stdout.starts_with(title), "{ended:#?}");
    for part in ["claims of the paper", "None of these", "strangers"] {
        assert!(ended.stdout.contains(part), "no {part} in {ended:#?}");
    }
    let found = rows(&workplace, "out/partial.csv");
    // Five classes of four objects, ten steps from two ends.
    assert_eq!(found.len(), 5 * 4 * 10 * 2);
    workplace.succeed(&[&arguments[..], &["again"]].concat());
    assert_eq!(workplace.read("out/partial.csv"), workplace.read("again/partial.csv"));
    check_files(&workplace, &["partial.md", "partial.tex", "accuracy.svg", "accuracy.pdf", "report.html"]);
    #[cfg(feature = "viewer")]
    check_files(&workplace, &["partial.rrd"]);
    let page = workplace.read("out/report.html");
    std::fs::remove_file(workplace.path("out/report.html")).unwrap();
    workplace.succeed(&["report", "out"]);
    assert_eq!(workplace.read("out/report.html"), page);
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    let set = &manifest["sets"][0];
    assert_eq!((&set["judged"]["simulated"], &set["model"]["name"]), (&true.into(), &"shipped".into()));
}

#[test]
fn methods_are_trained_where_objects_are_named_for_it() {
    let workplace = Workplace::new();
    let arguments =
        ["partial", "objects-vlp-16", "--train", "objects-vlp-16", "--per-class", "4", "--no-rrd"];
    let ended = workplace.succeed(&[&arguments[..], &["-o", "out"]].concat());
    let title = "Partial clouds: objects-vlp-16 (simulated), learned from";
    assert!(ended.stdout.starts_with(title), "{ended:#?}");
    let found = rows(&workplace, "out/partial.csv");
    // Four classes of four objects, ten steps from two ends, five methods, trained in two ways.
    assert_eq!(found.len(), 4 * 4 * 10 * 2 * 5 * 2);
    assert!(!workplace.path("out/partial.rrd").exists());
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    let set = &manifest["sets"][0];
    assert_eq!((&set["judged"]["simulated"], &set["halves"]), (&true.into(), &false.into()));
    assert_ne!(set["judged"]["simulation"], set["learned_from"]["simulation"], "no object is in both");
    let compared = workplace.succeed(&["compare", "out", "-d", "extents,bag of graphs", "--markdown"]);
    assert!(compared.stdout.contains("bag of graphs − extents"), "{compared:#?}");
    let refused = workplace.run(&["compare", "out", "-d", "extents,esf"]);
    assert!(refused.exit_code == Some(2) && refused.stderr.contains("no method \"esf\""), "{refused:#?}");
}

#[test]
fn drives_show_more_and_more_and_the_ablation_has_a_row_for_each_part() {
    let workplace = Workplace::new();
    let arguments = [
        "partial",
        "objects-approach",
        "--train",
        "objects-approach",
        "--drives",
        "--ablation",
        "--trained-on",
        "whole",
        "--per-class",
        "3",
    ];
    workplace.succeed(&[&arguments[..], &["-o", "out"]].concat());
    let found = rows(&workplace, "out/partial.csv");
    assert!(found.iter().all(|it| it[2] == "drive"), "{:?}", found[0]);
    let methods: std::collections::BTreeSet<&str> = found.iter().map(|it| it[4].as_str()).collect();
    assert!(methods.contains("without graphs") && methods.len() > 8, "{methods:?}");
}

/// Runs `arguments` in a workplace with a folder of one car, and expects these words and exit code 2.
#[track_caller]
fn check_refused(arguments: &[&str], words: &str) {
    let workplace = Workplace::new();
    std::fs::create_dir_all(workplace.path("mine/car")).expect("the workplace is ours");
    std::fs::write(workplace.path("mine/car/1.bin"), [0; 64]).expect("the workplace is ours");
    let refused = workplace.run(&[arguments, &["-o", "x"]].concat());
    assert!(refused.exit_code == Some(2) && refused.stderr.contains(words), "{refused:#?}");
    assert!(!workplace.path("x").exists());
}

#[test]
fn options_that_say_nothing_about_the_objects_are_refused() {
    for verb in [&["partial"][..], &["data", "objects"]] {
        let with = |rest: &[&'static str]| [verb, rest].concat();
        for name in ["objects-around", "mine"] {
            check_refused(&with(&[name, "--seed", "7"]), "--seed is for data sets, and none is given");
            check_refused(&with(&[name, "--sensor", "vlp-16"]), "--sensor is for data sets");
            check_refused(&with(&[name, "--sensor-height", "1.7"]), "--sensor-height is for data sets");
            check_refused(&with(&[name, "--format", "kitti-tracking"]), "--format is for data sets");
            check_refused(&with(&[name, "--class", "boat=misc"]), "--class is for data sets");
            check_refused(&with(&[name, "--registered"]), "--registered is for data sets");
        }
        check_refused(&with(&["mine", "--part", "judging"]), "--part is for simulated objects");
        check_refused(&with(&["mine", "--per-class", "9"]), "--per-class is for simulated objects");
        check_refused(&with(&["objects-nowhere"]), "objects-nowhere");
    }
    // It would be of the objects that are learned from, which are of the training part in any case.
    let train = ["partial", "mine", "--train", "objects-around", "--part", "judging"];
    check_refused(&train, "--part is for simulated objects");
}

#[test]
fn what_needs_training_or_a_drive_is_refused_without() {
    check_refused(&["partial", "objects-around", "--drives"], "--drives is for objects-approach");
    check_refused(&["partial", "--ablation"], "--train <OBJECTS>");
    check_refused(&["partial", "--trained-on", "whole"], "--train <OBJECTS>");
    check_refused(&["partial", "--model", "no.toml"], "cannot use the model no.toml");
    check_refused(&["partial", "--model", "mine/car/1.bin"], "cannot use the model");
    check_refused(
        &["partial", "objects-air", "objects-around", "--peer-results", "a=b"],
        "of one set of objects",
    );
    check_refused(&["train", "partial", "streets"], "unexpected argument");
    check_refused(&["train", "partial", "--nu", "0.1"], "unexpected argument");
    check_refused(&["train", "partial", "--objects", "mine", "--per-class", "3"], "--per-class is for");
}

#[test]
fn a_model_is_trained_to_the_byte_with_any_number_of_threads_and_classifies_objects() {
    let train = ["train", "partial", "--objects", "objects-vlp-16,objects-approach", "--per-class", "3"];
    let [one, three] = ["1", "3"].map(|n_threads| {
        let workplace = Workplace::new();
        let mut command = workplace.command(&[&train[..], &["-o", "model"]].concat());
        let ended = Ended::from(command.env("RAYON_NUM_THREADS", n_threads).output().expect("it starts"));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        workplace
    });
    let model = one.read_bytes("model/partial.model");
    assert!(model == three.read_bytes("model/partial.model"));
    let command = format!("command = \"scanbench {}\"", train.join(" "));
    assert!(String::from_utf8_lossy(&model).contains(&command));
    let judge = [
        "partial",
        "objects-vlp-16",
        "--per-class",
        "3",
        "--model",
        "model/partial.model",
        "--no-rrd",
        "-o",
        "out",
    ];
    let ended = one.succeed(&judge);
    assert!(ended.stdout.contains("classified by the model model/partial.model"), "{ended:#?}");
}

#[test]
fn results_are_compared_and_gated_object_by_object() {
    let workplace = Workplace::new();
    let judge = ["partial", "objects-vlp-16", "--per-class", "10", "--no-rrd", "-o"];
    workplace.succeed(&[&judge[..], &["before"]].concat());
    let same = workplace.succeed(&["gate", "before", "--baseline", "before"]);
    assert!(same.stdout.contains("PASSED"), "{same:#?}");
    // All trees and poles are classified as cars from step 3 on.
    let changed = |is_changed: &dyn Fn(&str) -> bool, name: &str| {
        let text = workplace.read("before/partial.csv");
        let lines = text.lines().map(|line| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if is_changed(line) {
                cells[7] = "car";
            }
            cells.join(",") + "\n"
        });
        std::fs::create_dir(workplace.path(name)).unwrap();
        workplace.write(&format!("{name}/partial.csv"), &lines.collect::<String>());
        std::fs::copy(workplace.path("before/manifest.json"), workplace.path(name).join("manifest.json"))
            .unwrap();
    };
    changed(&|it| it.contains(",tree,tree,") || it.contains(",pole,pole,"), "worse");
    let worse = workplace.run(&["gate", "worse", "--baseline", "before", "-o", "verdict"]);
    assert_eq!(worse.exit_code, Some(100), "{worse:#?}");
    assert!(
        workplace.read("verdict/gate.json").contains("regression")
            && workplace.path("verdict/gate.md").exists()
    );
    let xml = workplace.read("verdict/junit.xml");
    assert!(xml.contains("type=\"regression\"") && xml.contains("type=\"drift\""), "{xml}");
    changed(&|it| it.contains("tree-0003,below,9"), "other");
    let other = workplace.run(&["gate", "other", "--baseline", "before"]);
    assert!(other.exit_code == Some(101) && other.stdout.contains("tree-0003 at step 9"), "{other:#?}");
    workplace.succeed(&["gate", "other", "--baseline", "before", "--allow-drift"]);
    let compared = workplace.succeed(&["compare", "before", "worse", "-o", "comparison"]);
    assert!(compared.stdout.contains("Predictions changed"), "{compared:#?}");
    assert!(workplace.read("comparison/comparison.csv").contains("mean_recall"));
    workplace.succeed(&["partial", "objects-vlp-16", "--per-class", "9", "--no-rrd", "-o", "fewer"]);
    for verb in [&["gate", "fewer", "--baseline", "before"][..], &["compare", "before", "fewer"]] {
        let refused = workplace.run(verb);
        assert!(refused.exit_code == Some(5) && refused.stderr.contains("not the same"), "{refused:#?}");
    }
    workplace.write("strict.toml", "mean_recall = 2");
    let refused = workplace.run(&["gate", "before", "--baseline", "before", "-t", "strict.toml"]);
    assert!(refused.exit_code == Some(2) && refused.stderr.contains("strict.toml"), "{refused:#?}");
}

#[test]
fn a_first_baseline_holds_later_results_to_it() {
    let workplace = Workplace::new();
    let judge = ["partial", "objects-vlp-16", "--per-class", "3", "--no-rrd", "-o"];
    workplace.succeed(&[&judge[..], &["first"]].concat());
    // As a program without uncommitted changes makes it.
    let manifest = workplace.read("first/manifest.json").replace("\"dirty\": true", "\"dirty\": false");
    workplace.write("first/manifest.json", &manifest);
    workplace.succeed(&["baseline", "init", "first", "-o", "ci"]);
    let workflow = workplace.read("ci/scanbench.yml");
    let again = "\n          scanbench partial objects-vlp-16 --per-class 3 --no-rrd -o runs/gate\n";
    assert!(workflow.contains(again) && !workflow.contains("DATA"), "{workflow}");
    let same = workplace.succeed(&["gate", "first", "--baseline", "ci"]);
    assert!(same.stdout.starts_with("PASSED"), "{same:#?}");
    let twice = workplace.run(&["baseline", "init", "first", "-o", "ci"]);
    assert!(twice.exit_code == Some(2) && twice.stderr.contains("exists; name another folder"), "{twice:#?}");
    // The file beside the baseline counts.
    let lenient = workplace.read("ci/tolerances.toml").replace("drift = \"fail\"", "drift = \"warn\"");
    workplace.write("ci/tolerances.toml", &lenient);
    let rows = workplace.read("first/partial.csv").replacen(",tree,tree,", ",tree,pole,", 1);
    workplace.write("first/partial.csv", &rows);
    let allowed = workplace.succeed(&["gate", "first", "--baseline", "ci"]);
    assert!(allowed.stdout.starts_with("PASSED, results changed"), "{allowed:#?}");
    let accept = ["baseline", "accept", "first", "-b", "ci", "--why", "a tree less"];
    let refused = workplace.run(&accept);
    assert_eq!(refused.exit_code, Some(100), "{refused:#?}");
    assert!(refused.stderr.contains("1 number is worse than tolerated"), "{refused:#?}");
    assert!(!refused.stdout.contains("PASSED") && refused.stdout.contains("inconclusive"), "{refused:#?}");
    let accepted = workplace.succeed(&[&accept[..], &["--worse"]].concat()).stdout;
    let line = accepted.lines().last().expect("a line of the history");
    assert!(
        line.contains("objects-vlp-16 from below")
            && workplace.read("ci/SCORES.md").ends_with(&format!("{line}\n")),
        "{accepted}"
    );
    workplace.succeed(&["partial", "objects-air", "--per-class", "3", "--no-rrd", "-o", "other"]);
    let manifest = workplace.read("other/manifest.json").replace("\"dirty\": true", "\"dirty\": false");
    workplace.write("other/manifest.json", &manifest);
    let refused = workplace.run(&["baseline", "accept", "other", "-b", "ci", "--why", "another"]);
    assert!(refused.exit_code == Some(5) && refused.stderr.contains("--new-baseline"), "{refused:#?}");
}

#[test]
fn results_of_others_stand_beside_ours_if_they_are_of_the_same_parts() {
    let workplace = Workplace::new();
    let judge = ["partial", "objects-vlp-16", "--per-class", "3", "--no-rrd"];
    workplace.succeed(&[&judge[..], &["-o", "ours"]].concat());
    let mut table = "object,class,from,step,n_points,predicted\n".to_owned();
    for row in rows(&workplace, "ours/partial.csv") {
        writeln!(table, "{}/{}.npy,{},{},{},{},tree", row[6], row[1], row[6], row[2], row[3], row[8])
            .unwrap();
    }
    workplace.write("esf.csv", &table);
    let ended = workplace.succeed(&[&judge[..], &["--peer-results", "esf=esf.csv", "-o", "out"]].concat());
    assert!(ended.stdout.contains("esf") && ended.stdout.contains("elsewhere"), "{ended:#?}");
    assert_eq!(rows(&workplace, "out/partial.csv").len(), 2 * 4 * 3 * 20);
    let cut = table.lines().take(5).collect::<Vec<_>>().join("\n");
    workplace.write("cut.csv", &cut);
    let refused = workplace.run(&[&judge[..], &["--peer-results", "esf=cut.csv", "-o", "x"]].concat());
    assert!(refused.exit_code == Some(3) && refused.stderr.contains("says nothing of tree-"), "{refused:#?}");
    let name = "bag of graphs=esf.csv";
    let refused = workplace.run(&[&judge[..], &["--peer-results", name, "-o", "x"]].concat());
    assert!(
        refused.exit_code == Some(2) && refused.stderr.contains("two methods are called"),
        "{refused:#?}"
    );
    assert!(!workplace.path("x").exists());
}

#[test]
#[ignore = "needs data/object_clouds in SCANBENCH_TEST_DATA"]
fn of_recorded_objects_half_is_learned_from_and_the_others_are_judged() {
    let workplace = Workplace::new();
    let folder = test_data("data/object_clouds");
    let folder = Path::new(&folder).to_str().unwrap();
    let ended =
        workplace.succeed(&["partial", folder, "--train", folder, "--trained-on", "whole", "-o", "out"]);
    assert!(ended.stdout.contains("learned from object_clouds, the other half of it"), "{ended:#?}");
    let found = rows(&workplace, "out/partial.csv");
    let ours: Vec<_> = found.iter().filter(|it| it[4] == "bag of graphs" && it[3] == "10").collect();
    // 25 of each of the three classes that are learned, from two ends.
    assert_eq!(ours.len(), 150);
    let n_right = ours.iter().filter(|it| it[6] == it[7]).count();
    assert!(n_right > 130, "{n_right} of 150");
}
