//! `scanbench partial`: what an object is of which a part has been seen.

use std::path::Path;

use test_data::{needs_test_data, test_data};

use crate::program::Workplace;

fn rows(workplace: &Workplace, path: &str) -> Vec<Vec<String>> {
    let text = workplace.read(path);
    text.lines().skip(1).map(|it| it.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn objects_are_uncovered_and_told_and_the_same_comes_out_again() {
    let workplace = Workplace::new();
    let arguments = ["partial", "objects-vlp-16", "--per-class", "4", "-o"];
    let ended = workplace.succeed(&[&arguments[..], &["out"]].concat());
    assert!(
        ended.stdout.starts_with("Partial clouds: objects-vlp-16 (simulated), learned from"),
        "{ended:#?}"
    );
    assert!(ended.stdout.contains("claims of the paper"), "{ended:#?}");
    let found = rows(&workplace, "out/partial.csv");
    // Four classes of four objects, ten steps from two ends, five methods, trained in two ways.
    assert_eq!(found.len(), 4 * 4 * 10 * 2 * 5 * 2);
    workplace.succeed(&[&arguments[..], &["again"]].concat());
    assert_eq!(workplace.read("out/partial.csv"), workplace.read("again/partial.csv"));
    for name in ["partial.md", "partial.tex", "accuracy.svg", "accuracy.pdf", "calibration.svg"] {
        assert!(std::fs::metadata(workplace.path("out").join(name)).is_ok_and(|it| it.len() > 200), "{name}");
    }
    let manifest: serde_json::Value = serde_json::from_str(&workplace.read("out/manifest.json")).unwrap();
    let set = &manifest["sets"][0];
    assert_eq!((&set["judged"]["simulated"], &set["halves"]), (&true.into(), &false.into()));
    assert_ne!(set["judged"]["simulation"], set["learned_from"]["simulation"], "no object is in both");
}

#[test]
fn drives_show_more_and_more_and_the_ablation_has_a_row_for_each_part() {
    let workplace = Workplace::new();
    let arguments = [
        "partial",
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
    let refused = workplace.run(&["partial", "objects-around", "--drives", "-o", "x"]);
    assert!(refused.exit_code == Some(2) && refused.stderr.contains("objects-approach"), "{refused:#?}");
    for verb in [&["partial"][..], &["data", "objects"]] {
        let seeded = [verb, &["objects-around", "--seed", "7", "-o", "x"]].concat();
        let refused = workplace.run(&seeded);
        assert!(
            refused.exit_code == Some(2) && refused.stderr.contains("--seed is for data sets"),
            "{refused:#?}"
        );
    }
    let refused = workplace.run(&["partial", "objects-nowhere", "-o", "x"]);
    assert_eq!(refused.exit_code, Some(2), "{refused:#?}");
    assert!(!workplace.path("x").exists());
}

#[needs_test_data("data/object_clouds")]
fn of_recorded_objects_half_is_learned_from_and_the_others_are_judged() {
    let workplace = Workplace::new();
    let folder = test_data!("data/object_clouds");
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
