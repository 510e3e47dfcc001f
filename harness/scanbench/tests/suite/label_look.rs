//! Labels that do not lie where the points are, or that a detector made, are heard before anything rests on them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use crate::program::{Prepared, Workplace, copy_folder};

/// Simulated scans with boxes, as if they were recorded: no file says where they come from.
fn recorded() -> Workplace {
    static RECORDED: Prepared = Prepared::new();
    RECORDED.workplace(|workplace| {
        let simulate =
            "data simulate street-main-road --seed 9001 --simulated-scans 5 --to kitti-tracking -o drive";
        workplace.succeed(simulate);
        std::fs::remove_file(workplace.path("drive/training/scanbench.json")).unwrap();
    })
}

/// Rewrites the numbers of every line of KITTI's labels: height, width, length, x, y, z and yaw.
fn rewrite(workplace: &Workplace, change: impl Fn(&mut [f64])) {
    rewrite_in(&workplace.path("drive/training/label_02"), change);
}

/// The same of all files in a folder.
fn rewrite_in(folder: &Path, change: impl Fn(&mut [f64])) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let line = |line: &str| {
            let (head, numbers): (Vec<&str>, Vec<&str>) = {
                let mut words: Vec<&str> = line.split(' ').collect();
                let numbers = words.split_off(10);
                (words, numbers)
            };
            let mut numbers: Vec<f64> = numbers.iter().map(|it| it.parse().unwrap()).collect();
            change(&mut numbers);
            let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            format!("{} {}\n", head.join(" "), numbers.join(" "))
        };
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.lines().map(line).collect::<String>()).unwrap();
    }
}

const RUN: &str = "run drive -d pca,simple-grid --no-rrd -o out --overwrite";

#[test]
fn swapped_sides_are_heard_and_no_verdict_is_drawn() {
    let workplace = recorded();
    let ended = workplace.succeed(RUN);
    let sound = &workplace.json("out/manifest.json")["datasets"][0];
    assert!(!ended.stderr.contains("suspect") && sound["doubts"].is_null(), "{ended:#?}");
    assert_eq!(sound["label_points"]["class"], "car", "{sound:#}");
    workplace.check_file("out/report.html", &["points in labelled boxes, from above and from the side"]);
    assert!(workplace.path("out/figures/labels_drive.svg").is_file());
    workplace.succeed("data check drive").check_stdout(&["boxes of vehicles", "they fit their points"]);

    rewrite(&workplace, |it| it.swap(1, 2));
    let ended = workplace.succeed(RUN);
    ended.check_stderr(&[
        "warning: the labels of \"drive\" are suspect: the points of",
        "swap length and width in the labels",
    ]);
    ended.check_stdout(&["no verdict, since frame or labels of drive are suspect."]);
    workplace.check_file("out/report.html", &["it looks as if length and width are swapped"]);
    ended.check_stderr(&["if they are right, say so with --labels-are-right"]);
    // The user has the last word, and everybody is told.
    let ended = workplace.succeed(&(RUN, "--labels-are-right"));
    ended.check_stderr(&["swap length and width in the labels"]);
    assert!(!ended.stderr.contains("say so with"), "{ended:#?}");
    ended.check_stdout(&["Doubts about the labels of drive were overruled."]);
    assert!(!ended.stdout.contains("no verdict"), "{ended:#?}");
    let overruled = &workplace.json("out/manifest.json")["datasets"][0];
    assert!(overruled["doubts"].is_null(), "{overruled:#}");
    assert_eq!(overruled["overruled_doubts"].as_array().map(Vec::len), Some(1), "{overruled:#}");
    let said = "The labels of drive are right, says the user (--labels-are-right), though the points of";
    workplace.check_file("out/report.html", &[said]);
    workplace.succeed("gate out -b out -o verdict").check_stdout(&[said]);
    workplace.check_file("verdict/gate.json", &["says the user (--labels-are-right)"]);
    workplace.check_file("verdict/gate.md", &[said]);
    let checked = workplace.succeed("data check drive").stdout;
    assert!(checked.contains("it looks as if length and width are swapped"), "{checked}");
}

#[test]
fn boxes_that_stand_in_the_road_or_beside_their_vehicles_are_heard() {
    let workplace = recorded();
    // KITTI has the bottom of a box, and its y is down.
    rewrite(&workplace, |it| it[4] += 0.5 * it[0]);
    let checked = workplace.succeed("data check drive").stdout;
    assert!(checked.contains("add half the height of each box"), "{checked}");
    rewrite(&workplace, |it| {
        it[4] -= 0.5 * it[0];
        it[5] += 1.0;
    });
    let checked = workplace.succeed("data check drive").stdout;
    assert!(checked.contains("it looks as if boxes are off by (+1.0"), "{checked}");
}

#[test]
fn labels_that_a_detector_made_do_not_judge_it() {
    let workplace = Workplace::new();
    workplace.succeed("data prelabel street-main-road --scans 0..2 -o project --to kitti");
    let run = "run project -d pca --no-rrd -o out --overwrite";
    let ended = workplace.succeed(run);
    ended.check_stderr(&["boxes are as a detector proposed them (proposals.csv)", "so correct them first"]);
    ended.check_stdout(&["no verdict, since frame or labels of project are suspect."]);
    workplace.succeed("data check project").check_stdout(&["as a detector proposed them"]);
    for entry in std::fs::read_dir(workplace.path("project/label_2")).unwrap() {
        let path = entry.unwrap().path();
        // Somebody has touched the boxes: they are a little higher.
        let raised = |line: &str| {
            let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            words[8] = (words[8].parse::<f64>().unwrap() + 0.1).to_string();
            words.join(" ") + "\n"
        };
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.lines().map(raised).collect::<String>()).unwrap();
    }
    let ended = workplace.succeed(run);
    assert!(!ended.stderr.contains("suspect"), "{ended:#?}");
}

/// Results that lie as labels do, damaged by `change`: what is said of them has all `parts`; without any, nothing is said.
#[track_caller]
fn check_results(workplace: &Workplace, change: impl Fn(&mut [f64]), parts: &[&str]) {
    let found = workplace.path("found");
    if found.exists() {
        std::fs::remove_dir_all(&found).unwrap();
    }
    copy_folder(&workplace.path("drive/training/label_02"), &found);
    rewrite_in(&found, change);
    let run = "run drive -d simple-grid --detections net=found --no-rrd -o out --overwrite";
    let ended = workplace.succeed(run);
    let entry = &workplace.json("out/manifest.json")["detectors"];
    let doubts = entry.as_array().unwrap().iter().find(|it| it["name"] == "net").unwrap()["doubts"].clone();
    if parts.is_empty() {
        assert!(!ended.stderr.contains("suspect") && doubts.is_null(), "{ended:#?} {doubts}");
        return;
    }
    ended.check_stderr(&["warning: the boxes of the detector \"net\" are suspect: on drive, "]);
    ended.check_stderr(parts);
    for part in parts {
        assert!(doubts.to_string().contains(part), "{part}: {doubts}");
    }
    workplace.check_file("out/report.html", &["The boxes of net are suspect: on drive, "]);
}

#[test]
fn results_get_the_look_that_labels_get() {
    let workplace = recorded();
    check_results(&workplace, |_| {}, &[]);
    check_results(&workplace, |it| it[6] = it[6].to_degrees(), &["as if they were degrees"]);
    check_results(&workplace, |it| it[4] += 0.5 * it[0], &["add half the height of each box"]);
    check_results(&workplace, |it| it.swap(1, 2), &["swap length and width in the results", "times as well"]);
    // Boxes that are merely bad: a little too large, turned and off.
    let bad = |it: &mut [f64]| {
        it[1] *= 1.2;
        it[2] *= 1.15;
        it[3] += 0.2;
        it[5] -= 0.3;
        it[6] += 0.1;
    };
    check_results(&workplace, bad, &[]);
}

/// A camera's view was labelled, and no file says so.
#[test]
fn labels_reach_as_far_ahead_as_the_user_says() {
    let workplace = recorded();
    let n_objects =
        |workplace: &Workplace| workplace.column("out/table_vehicles.csv", "no")[0].parse::<u32>().unwrap();
    workplace.succeed("run drive -d pca --no-rrd -o whole");
    workplace.succeed("run drive -d pca --no-rrd -o out");
    let n_all_round = n_objects(&workplace);
    let run = "run drive -d pca --no-rrd -o out --overwrite --labels-ahead 40";
    workplace.succeed(run).check_stdout(&["drive"]);
    let n_ahead = n_objects(&workplace);
    assert!(0 < n_ahead && n_ahead < n_all_round / 2, "{n_ahead} of {n_all_round}");
    let said =
        "The labels of drive reach 40 degrees to either side of forward, says the user (--labels-ahead).";
    workplace.check_file("out/report.html", &[said]);
    assert_eq!(workplace.json("out/manifest.json")["datasets"][0]["labels_ahead_deg"], 40.0);
    let changed = "how far to either side of forward the labels of drive reach changed (--labels-ahead)";
    workplace.refuse("compare whole out", 5, &[changed]);
    workplace.refuse("run drive --labels-ahead 0", 2, &["--labels-ahead", "not within 0 to 180 degrees"]);
}
