//! Training the vehicle model.

use crate::program::{Ended, Workplace};

/// Three simulated drives, of which the last is held out.
const TRAIN: [&str; 10] =
    ["train", "streets", "--seed", "7", "--simulated-scans", "4", "--nu", "0.3", "-o", "model"];
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
    let command = "scanbench train streets --seed 7 --simulated-scans 4 --vehicles 3000 --others 1 --gamma 0.5 --nu 0.3";
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
    assert_eq!(workplace.read("model/importance.csv").lines().count(), 9);
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
    let n_vehicles = |option: &str, name: &str| {
        workplace.succeed(&[
            "run",
            "street-narrow",
            "--simulated-scans",
            "2",
            "-d",
            "hierarchical",
            "--no-rrd",
            "-P",
            option,
            "-o",
            name,
        ]);
        let manifest: serde_json::Value =
            serde_json::from_str(&workplace.read(&format!("{name}/manifest.json"))).expect("JSON");
        (workplace.read(&format!("{name}/matches.csv")), manifest["config"]["vehicle_model"].clone())
    };
    let (by_size, _) = n_vehicles("vehicle_model.enabled=false", "by-size");
    let (by_model, config) = n_vehicles("vehicle_model.directory=model", "by-model");
    assert_eq!(config["directory"].as_str(), Some("model"));
    assert_ne!(by_size, by_model);
}

#[test]
fn a_damaged_model_is_named() {
    let (workplace, _) = trained();
    let whole = workplace.read("model/model.toml");
    let run = ["run", "street-narrow", "-P", "vehicle_model.directory=model", "-o", "out"];
    for (damaged, said) in [
        (whole.replace("version = 1", "version = 9"), "version 9 of the format, this program reads 1"),
        (whole[..whole.len() / 2].to_owned(), "vehicle_model.directory"),
    ] {
        workplace.write("model/model.toml", &damaged);
        let ended = workplace.run(&run);
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        assert!(ended.stderr.contains(said), "{ended:#?}");
    }
    let ended = workplace.run(&["run", "-P", "vehicle_model.directory=nowhere", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("prototypes.toml"), "{ended:#?}");
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
    let too_much = ["streets", "--simulated-scans", "4", "--seed", "7", "--nu", "1.5", "-o", "model"];
    check_refused(&workplace, &too_much, 4, "nu = 1.5");
}
