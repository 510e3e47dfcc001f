//! `scanbench view`.

use std::collections::BTreeSet;

use crate::program::{Prepared, Workplace};

fn small_run() -> Workplace {
    static SMALL: Prepared = Prepared::new();
    SMALL.workplace(|workplace| {
        let run = "run street-narrow --simulated-scans 4 --sensor vlp-16 -d hierarchical,pca --no-rrd -o run";
        workplace.succeed(run);
    })
}

#[test]
fn the_worst_come_first_and_can_be_chosen() {
    let workplace = small_run();
    let listed = |options: &[&str]| -> Vec<(String, u64)> {
        let ended = workplace.succeed(&("view run --task objects --no-rrd", options));
        let lines = ended.stdout.lines().skip(1).map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            // Rank, address, class, points.
            (words[1].to_owned(), words[3].parse().expect("a number of points"))
        });
        lines.collect()
    };
    let all = listed(&[]);
    assert_eq!(all.len(), 10);
    assert!(all.windows(2).all(|pair| pair[0].1 >= pair[1].1), "{all:?}");
    assert_eq!(listed(&["--worst", "3"]), all[..3]);
    assert!(listed(&["--outcome", "missed"]).iter().all(|it| it.0.contains("/missed-")));
    // An address finds its object again, and that of a scan all of its mistakes.
    assert_eq!(listed(&["--at", &all[0].0]), all[..1]);
    let scan = all[0].0.rsplit_once('/').expect("an address").0;
    let of_scan = listed(&["--at", scan, "--worst", "100"]);
    assert!(of_scan.contains(&all[0]) && of_scan.iter().all(|it| it.0.starts_with(scan)), "{of_scan:?}");
    assert_ne!(listed(&["-d", "pca"]), all);
}

#[test]
#[cfg(feature = "viewer")]
fn their_scans_are_recorded_in_the_run_directory_or_elsewhere() {
    let workplace = small_run();
    workplace.succeed("view run --task objects --worst 2").check_stderr(&["worst.rrd"]);
    assert!(workplace.path("run/worst.rrd").metadata().unwrap().len() > 100_000);
    workplace.succeed("view run --task objects --worst 1 --save-rrd=one.rrd");
    assert!(workplace.path("one.rrd").exists());
}

#[test]
fn what_cannot_be_viewed_is_said() {
    let workplace = small_run();
    for (arguments, code, message) in [
        (&["view", "nowhere"][..], 2, "there is no run directory nowhere"),
        (&["view", "."], 2, "to see scans and labels, record them: `scanbench run . --scans 0`"),
        (
            &["view", "run", "-d", "kd-tree"],
            2,
            "the run has no detector \"kd-tree\"; its detectors are hierarchical, pca",
        ),
        (&["compare", ".", "run"], 2, ". is not the directory of a run: it has no manifest.json"),
        (&["report", "."], 2, ". is not the directory of a run: it has no manifest.json"),
        (&["view", "run", "--class", "boat"], 2, "the run has no class \"boat\""),
        (&["view", "run", "--class", "tram"], 4, "the run has no mistakes of this kind"),
        (&["view", "run", "--at", "street-narrow/a/000099"], 4, "of this kind at street-narrow/a/000099"),
        (
            &["view", "run", "--task", "car"],
            2,
            "the run has no task \"car\"; its tasks are objects, vehicles",
        ),
    ] {
        workplace.end_with(arguments, code, &[message]);
    }
}

#[test]
#[cfg(feature = "viewer")]
fn scans_that_would_not_be_the_same_are_not_recorded() {
    let workplace = small_run();
    let manifest = workplace.read("run/manifest.json");
    for (from, to, message) in [
        ("\"simulator_version\": ", "\"simulator_version\": 9", "differ from those of the run"),
        ("\"cell_size_m\": 0.6", "\"cell_size_m\": 0.7", "the parameters differ from those of the run"),
    ] {
        assert!(manifest.contains(from), "{manifest}");
        workplace.write("run/manifest.json", &manifest.replace(from, to));
        // The list of mistakes does not need the scans.
        workplace.end_with("view run --task objects", 2, &[message]);
        assert!(!workplace.path("run/worst.rrd").exists());
    }
}

#[test]
fn two_runs_are_shown_by_what_changed_between_them() {
    let workplace = small_run();
    let before = "run street-narrow --simulated-scans 4 --sensor vlp-16 -d hierarchical --no-rrd";
    workplace.succeed(&(before, "-o before"));
    workplace.succeed(&(before, "-P cell_size_m=1.0 -o after"));
    let recorded = if cfg!(feature = "viewer") { "" } else { "--no-rrd" };
    let ended = workplace.succeed(&("view before after --task objects --worst 1000", recorded));
    ended.check_stderr(&["hierarchical, vehicles: ", "-d hierarchical --task vehicles lists them"]);
    let mut lines = ended.stdout.lines();
    let head = lines.next().expect("a head");
    assert!(head.starts_with("hierarchical, objects: ") && head.contains(" lost, "), "{head}");
    let kinds: Vec<&str> = lines.skip(2).map(|it| it.split_whitespace().nth(1).expect("a kind")).collect();
    let order = ["lost", "new-false", "other-class", "found", "no-longer-false"];
    let places: Vec<usize> =
        kinds.iter().map(|it| order.iter().position(|kind| kind == it).expect("a kind")).collect();
    assert!(places.is_sorted() && places.contains(&0) && places.contains(&4), "{kinds:?}");
    // As many as the gate counts.
    let n_lost = kinds.iter().filter(|it| **it == "lost").count();
    assert!(head.contains(&format!("{n_lost} object")), "{head}");
    let rows = |run: &str| workplace.table(&format!("{run}/matches.csv"));
    let found = |run: &str| -> std::collections::BTreeSet<String> {
        let of_objects =
            rows(run).into_iter().filter(|it| it["task"] == "objects" && it["outcome"] == "matched");
        let pairs = of_objects.filter(|it| it["kind"] == "pair");
        pairs.map(|it| format!("{}/{}/{}", it["sequence"], it["scan"], it["annotation_id"])).collect()
    };
    let missed = |run: &str| -> std::collections::BTreeSet<String> {
        let of_objects =
            rows(run).into_iter().filter(|it| it["task"] == "objects" && it["outcome"] == "missed");
        of_objects.map(|it| format!("{}/{}/{}", it["sequence"], it["scan"], it["annotation_id"])).collect()
    };
    assert_eq!(found("before").intersection(&missed("after")).count(), n_lost);
    if cfg!(feature = "viewer") {
        ended.check_stderr(&["after/changes.rrd"]);
        assert!(workplace.path("after/changes.rrd").metadata().expect("it is there").len() > 100_000);
    }
    let first = ended.stdout.lines().nth(3).expect("a change").split_whitespace().nth(2).expect("an address");
    let one = workplace.succeed(&("view before after --task objects --no-rrd --at", [first]));
    assert!(one.stdout.lines().skip(3).all(|it| it.contains(first)), "{}", one.stdout);
    let seen = "scanbench view before after -d hierarchical --task objects";
    workplace.succeed("compare before after").check_stderr(&[seen]);
    assert!(!workplace.succeed("compare before before").stderr.contains("scanbench view"));
    let none = workplace.succeed("view before before");
    none.check_stdout(&["hierarchical, vehicles: no object has another outcome"]);
    workplace.refuse("view before after --class car", 2, &["cannot be used with"]);
    workplace.refuse("view run after", 5, &["the detector pca is only in the earlier run"]);
}

#[test]
fn labels_that_all_detectors_contradict_are_listed_with_what_is_wrong() {
    let workplace = Workplace::with_drive(12);
    // The second car is longer by 2 m in the labels of the fourth scan, and there is none in those of the sixth.
    let path = "street/training/label_02/0000.txt";
    let labels = workplace.read(path);
    let changed = labels.lines().filter_map(|line| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        match (words[0].as_str(), words[1].as_str()) {
            ("5", "1") => return None,
            ("3", "1") => words[12] = (words[12].parse::<f64>().expect("a length") + 2.0).to_string(),
            _ => {}
        }
        Some(words.join(" ") + "\n")
    });
    workplace.write(path, &changed.collect::<String>());
    // Both networks find both cars where they are.
    let header = "class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad";
    for (name, off_m) in [("a", 0.05), ("b", -0.05)] {
        for number in 0..12 {
            let ahead_m = 12.0 + 0.5 * f64::from(number) + off_m;
            let boxes = [[ahead_m, -1.5], [18.0 + off_m, 4.5]];
            let lines = boxes.map(|[x_m, y_m]| format!("vehicle,0.9,{x_m},{y_m},-0.98,4.2,1.8,1.5,0\n"));
            workplace
                .write(&format!("{name}/0000/{number:06}.csv"), &format!("{header}\n{}", lines.concat()));
        }
    }
    let run =
        "run street -d pca --criterion centre --detections net-a=a --detections net-b=b --no-rrd -o run";
    workplace.succeed(run);
    let recorded = if cfg!(feature = "viewer") { "" } else { "--no-rrd" };
    let ended = workplace.succeed(&("suspects run -d net-a,net-b --task vehicles", recorded));
    let rows = workplace.table("run/suspects.csv");
    let kinds: Vec<(&str, &str)> = rows.iter().map(|it| (it["scan"].as_str(), it["kind"].as_str())).collect();
    assert_eq!(kinds.len(), 2, "{kinds:?}");
    assert!(kinds.contains(&("3", "size")) && kinds.contains(&("5", "not-labelled")), "{kinds:?}");
    ended.check_stdout(&[
        "m shorter than labelled",
        "all 2 detectors find an object here, and none is labelled",
    ]);
    if cfg!(feature = "viewer") {
        assert!(workplace.path("run/suspects.rrd").metadata().expect("it is there").len() > 50_000);
    }
    for (tool, file) in [("kitti", "label_2/"), ("labelcloud", "labels/"), ("sustechpoints", "label/")] {
        let project = format!("suspects run -d net-a,net-b --task vehicles --no-rrd --to {tool} -o {tool}");
        workplace.succeed(&project).check_stderr(&["2 suspects in 2 scans"]);
        let rows = workplace.table(&format!("{tool}/suspects.csv"));
        let kinds: BTreeSet<&str> = rows.iter().map(|it| it["kind"].as_str()).collect();
        assert_eq!(kinds, ["not-labelled", "size"].into());
        for row in &rows {
            assert!(row["file"].starts_with(file) && workplace.path(tool).join(&row["file"]).is_file());
        }
        // What nobody has labelled is a proposal.
        assert_eq!(workplace.read(&format!("{tool}/proposals.csv")).lines().count(), 2);
        workplace.succeed(&format!("data check {tool}"));
        workplace.end_with(&project, 2, &[tool]);
    }
    workplace.refuse("suspects run -d net-a,net-a", 2, &["name two or more with -d"]);
    workplace.refuse("suspects run -d net-a,nett", 2, &["the run has no detector \"nett\""]);
    workplace.refuse("suspects run --task car", 2, &["the run has no task \"car\""]);
}
