//! Training the vehicle model.

use crate::program::{Ended, Workplace};

/// Three simulated drives, of which the last is held out.
const TRAIN: [&str; 12] = [
    "train",
    "streets",
    "--seed",
    "7",
    "--simulated-scans",
    "4",
    "-d",
    "kd-tree",
    "--nu",
    "0.3",
    "-o",
    "model",
];
/// The same drives for the model of the other detector.
const TRAIN_PCA: [&str; 8] =
    ["train", "streets", "--seed", "7", "--simulated-scans", "4", "--detector", "pca"];
/// But for the manifest, which has a date.
const FILES: [&str; 6] =
    ["curves.csv", "curves.svg", "importance.csv", "model.toml", "objects.csv", "prototypes.toml"];

/// A workplace with a trained model in `model`.
fn trained() -> (Workplace, Ended) {
    let workplace = Workplace::new();
    let ended = workplace.succeed(&TRAIN);
    (workplace, ended)
}

#[test]
fn a_model_says_what_it_was_made_of_and_what_was_held_out() {
    let (workplace, ended) = trained();
    let model: toml::Table = workplace.read("model/model.toml").parse().expect("it is TOML");
    let made = &model["made"];
    let command = "scanbench train streets --seed 7 --simulated-scans 4 --detector kd-tree --vehicles 3000 --others 1.5 --gamma 0.054 --nu 0.3";
    assert_eq!(made["command"].as_str(), Some(command));
    assert_eq!(made["data"][0].as_str(), Some("street-main-road (simulated, seeds from 7)"));
    let split = made["split"].as_str().expect("text");
    let held_out = split.strip_prefix("held out: ").expect("it says what was held out");
    assert!(ended.stdout.contains(&format!("Held out 1 drives: {held_out}\n")), "{ended:#?}");
    let drive = held_out.split(": ").nth(1).expect("data set and drive");
    // Nothing of any other drive was judged, and the curves are of as many objects.
    let objects = workplace.read("model/objects.csv");
    let n_objects = objects.lines().skip(1).count();
    assert!(n_objects > 20, "{n_objects}");
    assert!(objects.lines().skip(1).all(|it| it.split(',').nth(1) == Some(drive)), "{objects}");
    let curves = workplace.read("model/curves.csv");
    let last: Vec<usize> = curves
        .lines()
        .last()
        .expect("a row")
        .split(',')
        .skip(1)
        .take(4)
        .map(|it| it.parse().expect("a count"))
        .collect();
    assert_eq!(last[0] + last[1], n_objects);
    assert_eq!(last[..2], last[2..], "at the lowest threshold everything is told a vehicle");
    assert_eq!(workplace.read("model/importance.csv").lines().count(), 29);
    assert!(workplace.read("model/curves.svg").contains("Held-out drives (simulated)"));
}

#[test]
fn the_same_scans_give_the_same_bytes_with_any_number_of_threads() {
    let [one, three] = ["1", "3"].map(|n_threads| {
        let workplace = Workplace::new();
        let mut command = workplace.command(&TRAIN);
        let ended = Ended::from(command.env("RAYON_NUM_THREADS", n_threads).output().expect("it starts"));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        FILES.map(|it| workplace.read(&format!("model/{it}")))
    });
    assert!(one == three);
}

#[test]
fn a_run_takes_the_model() {
    let (workplace, _) = trained();
    let run = ["run", "street-narrow", "--simulated-scans", "2", "-d", "kd-tree", "--no-rrd"];
    let matches = |options: &[&str], name: &str| {
        workplace.succeed(&[&run[..], options, &["-o", name]].concat());
        workplace.read(&format!("{name}/matches.csv"))
    };
    let shipped = matches(&[], "shipped");
    assert_ne!(matches(&["-P", "vehicle_model.directory=model"], "trained"), shipped);
    let table = workplace.read("trained/table_vehicles.md");
    let said = "Vehicles classified by: kd-tree: SVM of grid clusters from \"model\".";
    assert!(table.contains(said), "{table}");
}

#[test]
fn a_model_that_no_chosen_detector_reads_is_refused_by_name() {
    let workplace = Workplace::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params/vehicle_model");
    workplace.write("mine.toml", &format!("[vehicle_model]\ndirectory = {shipped:?}"));
    let of_clusters = format!("vehicle_model.directory={shipped}");
    let switched_off = [of_clusters.as_str(), "-P", "vehicle_model.enabled=false"];
    for (options, reads) in [
        (
            &["-d", "hierarchical", "-P", &of_clusters][..],
            "hierarchical reads vehicle_model.groupings_directory",
        ),
        (&["-d", "hierarchical,pca", "-c", "mine.toml"], "pca reads vehicle_model.pca_directory"),
        (&[&["-d", "kd-tree", "-P"][..], &switched_off].concat(), "kd-tree reads no model"),
    ] {
        let ended = workplace.run(&[&["run", "street-narrow", "-o", "out"], options].concat());
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        let said = format!("vehicle_model.directory = {shipped:?}: no chosen detector reads it; ");
        assert!(ended.stderr.contains(&said) && ended.stderr.contains(reads), "{ended:#?}");
        assert!(!workplace.path("out").exists());
    }
    // Some of the variants read it.
    let ablation =
        ["ablation", "street-narrow", "--simulated-scans", "1", "-q", "-o", "ablation", "-P", &of_clusters];
    workplace.succeed(&ablation);
    let sweep = ["sweep", "street-narrow", "-d", "hierarchical", "-P", &of_clusters, "-P"];
    let ended = workplace.run(&[&sweep[..], &["object_cost=0.3:0.4:0.1"]].concat());
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("no chosen detector reads it"), "{ended:#?}");
}

#[test]
fn a_damaged_model_is_named() {
    let (workplace, _) = trained();
    let whole = workplace.read("model/model.toml");
    let run = ["run", "street-narrow", "-P", "vehicle_model.directory=model", "-o", "out"];
    for (damaged, said) in [
        (
            whole.replace("version = 2", "version = 9"),
            "model.toml: line 2: the format has version 9, but this program reads version 2",
        ),
        (whole.replace("nu = 0.3", "nu = 3.0"), "model.toml: line 14: nu = 3 is not within"),
        (whole[..whole.len() / 2].to_owned(), "vehicle_model.directory"),
    ] {
        workplace.write("model/model.toml", &damaged);
        let ended = workplace.run(&run);
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        assert!(ended.stderr.contains(said), "{ended:#?}");
    }
    workplace.write("model/model.toml", &whole);
    let prototypes = workplace.read("model/prototypes.toml");
    workplace.write("model/prototypes.toml", &prototypes.replacen("car 1", "car 9", 1));
    let ended = workplace.run(&run);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(
        ended.stderr.contains(
            "model.toml: line 4: the features of the model were computed with prototypes of SHA-256"
        ),
        "{ended:#?}"
    );
    let ended = workplace.run(&["run", "-P", "vehicle_model.directory=nowhere", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("prototypes.toml"), "{ended:#?}");
}

#[test]
fn the_detector_of_the_papers_has_a_model_of_eight_values() {
    let workplace = Workplace::new();
    // Not the nu of the paper, which takes all steps that training has.
    let train = ["train", "streets", "--seed", "7", "--simulated-scans", "4", "-d", "paper", "--nu", "0.3"];
    workplace.succeed(&[&train[..], &["-o", "model"]].concat());
    let model: toml::Table = workplace.read("model/model.toml").parse().expect("it is TOML");
    let command = "scanbench train streets --seed 7 --simulated-scans 4 --detector paper --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.3";
    assert_eq!(model["made"]["command"].as_str(), Some(command));
    assert_eq!(model["svm"]["features"].as_array().map(Vec::len), Some(8));
    assert_eq!(workplace.read("model/importance.csv").lines().count(), 9);
    let run = ["run", "street-narrow", "--simulated-scans", "2", "-d", "paper", "--no-rrd"];
    for (option, name) in [
        ("vehicle_model.enabled=false", "by-size"),
        ("vehicle_model.paper_directory=model", "mine"),
        ("vehicle_model.enabled=true", "shipped"),
    ] {
        workplace.succeed(&[&run[..], &["-P", option, "-o", name]].concat());
    }
    let [by_size, mine, shipped] =
        ["by-size", "mine", "shipped"].map(|name| workplace.read(&format!("{name}/matches.csv")));
    assert!(by_size != mine && mine != shipped && shipped != by_size);
    // It is no model for the other.
    let ended = workplace.run(&["run", "-P", "vehicle_model.directory=model", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(
        ended.stderr.contains("model.toml: line 16: the model was trained on the features"),
        "{ended:#?}"
    );
}

#[test]
fn pca_has_a_model_of_its_own() {
    let workplace = Workplace::new();
    workplace.succeed(&[&TRAIN_PCA[..], &["-o", "model"]].concat());
    let model: toml::Table = workplace.read("model/model.toml").parse().expect("it is TOML");
    let command = "scanbench train streets --seed 7 --simulated-scans 4 --detector pca --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.2";
    assert_eq!(model["made"]["command"].as_str(), Some(command));
    assert!(!workplace.path("model/prototypes.toml").exists());
    let header = workplace.read("model/objects.csv").lines().next().expect("a header").to_owned();
    assert!(header.contains(",decision,height_m,length_m,width_m,scatterness_from_0,"), "{header}");
    let run = ["run", "street-narrow", "--simulated-scans", "2", "-d", "pca", "--no-rrd"];
    for (option, name) in [
        ("vehicle_model.enabled=false", "by-size"),
        ("vehicle_model.pca_directory=model", "mine"),
        ("vehicle_model.enabled=true", "shipped"),
    ] {
        workplace.succeed(&[&run[..], &["-P", option, "-o", name]].concat());
    }
    let [by_size, mine, shipped] =
        ["by-size", "mine", "shipped"].map(|name| workplace.read(&format!("{name}/matches.csv")));
    assert!(by_size != mine && mine != shipped && shipped != by_size);
    // Each is no model for the other.
    let ended = workplace.run(&["run", "-P", "vehicle_model.directory=model", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("vehicle_model.directory = \"model\": prototypes.toml"), "{ended:#?}");
}

#[test]
fn more_kinds_of_objects_may_be_trained_with() {
    let workplace = Workplace::new();
    let trained = |options: &[&str], name: &str| {
        let ended = workplace.succeed(&[&TRAIN_PCA[..], options, &["-o", name]].concat());
        let model: toml::Table = workplace.read(&format!("{name}/model.toml")).parse().expect("it is TOML");
        (ended.stdout, model["made"]["command"].as_str().expect("text").to_owned())
    };
    let (plain, plain_command) = trained(&[], "plain");
    let (more, more_command) = trained(&["--parts-and-pairs"], "more");
    assert_ne!(plain, more);
    let expected = plain_command.replace("--others 1.5", "--others 1.5 --parts-and-pairs");
    assert_eq!(more_command, expected);
    // Of objects that no vehicle has the size of, the other model is not asked, unless it is to be.
    let by_shape = |options: &[&str], name: &str| {
        workplace.succeed(&[&TRAIN[..10], options, &["-o", name]].concat()).stdout
    };
    let bounded = by_shape(&[], "bounded");
    assert!(bounded.contains("no vehicle has their size"), "{bounded}");
    let unbounded = by_shape(&["--any-size"], "unbounded");
    assert!(!unbounded.contains("no vehicle has their size"), "{unbounded}");
}

#[test]
fn other_data_may_be_judged_by_and_other_clusters_described() {
    let workplace = Workplace::new();
    let held_out = [
        "--held-out",
        "street-narrow",
        "--held-out-scans",
        "0..2",
        "--clusters",
        "hierarchical",
        "-o",
        "model",
    ];
    let ended = workplace.succeed(&[&TRAIN_PCA[..], &held_out].concat());
    let [trained, judged] = ["Trained on 6 drives: ", "Held out 1 drives: street-narrow: narrow-9001\n"];
    assert!(ended.stdout.contains(trained) && ended.stdout.contains(judged), "{ended:#?}");
    let model: toml::Table = workplace.read("model/model.toml").parse().expect("it is TOML");
    let command = model["made"]["command"].as_str().expect("text").to_owned();
    assert!(
        command.contains(
            "--detector pca --clusters hierarchical --held-out street-narrow --held-out-scans 0..2"
        ),
        "{command}"
    );
    let objects = workplace.read("model/objects.csv");
    assert!(
        objects.lines().count() > 10
            && objects.lines().skip(1).all(|it| it.starts_with("street-narrow,narrow-9001,"))
    );
    let manifest: serde_json::Value =
        serde_json::from_str(&workplace.read("model/manifest.json")).expect("JSON");
    assert_eq!(manifest["held_out_datasets"][0]["id"], "street-narrow");
    check_refused(
        &workplace,
        &["streets", "--scans", "0..2", "--held-out", "street-narrow", "-o", "m"],
        2,
        "is both in the training data and in --held-out",
    );
    check_refused(&workplace, &["streets", "--held-out", "nowhere", "-o", "m"], 2, "nowhere");
    check_refused(
        &workplace,
        &["streets", "--clusters", "kdtree", "-o", "m"],
        2,
        "possible values: hierarchical, paper, kd-tree-same-walls, kd-tree, pca",
    );
}

/// Trains with `arguments`; it ends with `exit_code`, says `part`, and leaves nothing.
#[track_caller]
fn check_refused(workplace: &Workplace, arguments: &[&str], exit_code: i32, part: &str) {
    let before = workplace.names();
    let ended = workplace.run(&[&["train"], arguments].concat());
    assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(exit_code), ""), "{ended:#?}");
    assert!(ended.stderr.contains(part), "{ended:#?}");
    assert_eq!(workplace.names(), before);
}

#[test]
fn what_cannot_be_trained_leaves_nothing() {
    let workplace = Workplace::new();
    check_refused(&workplace, &["street-narrow", "--scans", "0..2", "-o", "model"], 2, "one drive");
    check_refused(&workplace, &["nowhere", "-o", "model"], 2, "nowhere");
    let too_much = [&TRAIN[1..8], &["--nu", "1.5", "-o", "model"]].concat();
    check_refused(&workplace, &too_much, 4, "nu = 1.5");
}

#[test]
fn groupings_are_trained_for_several_sensors_and_run() {
    let workplace = Workplace::new();
    let train = ["train", "street-narrow", "--simulated-scans", "6", "--sensors", "vlp-16,hdl-32e"];
    let ended = workplace.succeed(&[&train[..], &["-o", "model"]].concat());
    assert!(ended.stdout.contains("Probability of a vehicle"), "{ended:#?}");
    let forest: toml::Table = workplace.read("model/objects.toml").parse().expect("it is TOML");
    let command =
        "scanbench train street-narrow --simulated-scans 6 --detector groupings --sensors vlp-16,hdl-32e";
    assert_eq!(forest["made"]["command"].as_str(), Some(command));
    assert!(workplace.read("model/calibration.csv").starts_with("what,expected,observed,n_groups\n"));
    workplace.succeed(&[&train[..], &["-o", "again"]].concat());
    let looks = ["objects.toml", "objects_second_look.toml", "objects_third_look.toml"];
    for name in [&looks[..], &["vehicles.toml", "prototypes.toml", "calibration.csv"]].concat() {
        assert_eq!(
            workplace.read(&format!("model/{name}")),
            workplace.read(&format!("again/{name}")),
            "{name}"
        );
    }
    let run = ["run", "street-narrow", "--simulated-scans", "2", "-d", "hierarchical", "--no-rrd", "-o"];
    workplace.succeed(&[&run[..], &["shipped"]].concat());
    let trained = ["trained", "-P", "vehicle_model.groupings_directory=model"];
    workplace.succeed(&[&run[..], &trained].concat());
    assert_ne!(workplace.read("shipped/matches.csv"), workplace.read("trained/matches.csv"));
}

#[test]
fn options_of_other_models_say_nothing_about_groupings() {
    let workplace = Workplace::new();
    for option in [&["--nu", "0.3"][..], &["--vehicles", "50"], &["--parts-and-pairs"]] {
        let ended = workplace.run(&[&["train", "streets"], option].concat());
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        assert!(ended.stderr.contains(&format!("{} says nothing about --detector hierarchical", option[0])));
    }
    let ended = workplace.run(&["train", "streets", "-d", "kd-tree", "--sensors", "vlp-16"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
}
