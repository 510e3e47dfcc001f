//! Training.

use detector::classify::model_file::ModelFile;

use crate::program::{Ended, Workplace};

/// Three simulated drives, of which the last is held out.
const TRAIN: [&str; 10] =
    ["train", "paper", "streets", "--seed", "7", "--simulated-scans", "4", "--nu", "0.3", "-o"];
/// The same drives for the model of the other detector.
const TRAIN_PCA: [&str; 7] = ["train", "pca", "streets", "--seed", "7", "--simulated-scans", "4"];
/// But for the manifest, which has a date.
const FILES: [&str; 5] = ["curves.csv", "curves.svg", "importance.csv", "objects.csv", "paper.model"];

/// A workplace with a trained model in `model`.
fn trained() -> (Workplace, Ended) {
    let workplace = Workplace::new();
    let ended = workplace.succeed(&[&TRAIN[..], &["model"]].concat());
    (workplace, ended)
}

#[test]
fn a_model_says_what_it_was_made_of_and_what_was_held_out() {
    let (workplace, ended) = trained();
    let model = ModelFile::of_any_kind(&workplace.read_bytes("model/paper.model")).expect("it is a model");
    let made = model.made();
    let command = "scanbench train paper streets --seed 7 --simulated-scans 4 --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.3";
    assert_eq!((&*made.command, &*made.data[0]), (command, "street-main-road (simulated, seeds from 7)"));
    let held_out = made.split.strip_prefix("held out: ").expect("it says what was held out");
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
    let said = "Run it: scanbench run -d paper -P vehicle_model.paper_directory=model";
    assert!(ended.stderr.contains(said), "{ended:#?}");
}

#[test]
fn the_same_scans_give_the_same_bytes_with_any_number_of_threads() {
    let [one, three] = ["1", "3"].map(|n_threads| {
        let workplace = Workplace::new();
        let mut command = workplace.command(&[&TRAIN[..], &["model"]].concat());
        let ended = Ended::from(command.env("RAYON_NUM_THREADS", n_threads).output().expect("it starts"));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        FILES.map(|it| workplace.read_bytes(&format!("model/{it}")))
    });
    assert!(one == three);
}

/// The outcomes of a detector with the shipped models, and with others; and what stands under the table of vehicles with these.
#[track_caller]
fn outcomes(workplace: &Workplace, detector: &str, option: &str) -> ([String; 2], String) {
    let run = ["run", "street-narrow", "--simulated-scans", "2", "-d", detector, "--no-rrd"];
    let matches = |options: &[&str], name: &str| {
        workplace.succeed(&[&run[..], options, &["-o", name]].concat());
        workplace.read(&format!("{name}/matches.csv"))
    };
    let of_both = [
        matches(&[], &format!("shipped-{detector}")),
        matches(&["-P", option], &format!("trained-{detector}")),
    ];
    (of_both, workplace.read(&format!("trained-{detector}/table_vehicles.md")))
}

#[test]
fn rivals_are_trained_for_several_sensors_and_run() {
    let workplace = Workplace::new();
    let train = [
        "train",
        "rivals",
        "street-narrow",
        "--seed",
        "7",
        "--simulated-scans",
        "6",
        "--sensors",
        "vlp-16,hdl-32e",
    ];
    let ended = workplace.succeed(&[&train[..], &["-o", "model"]].concat());
    assert!(ended.stdout.contains("kd-tree-trained, at hdl-32e 0."), "{ended:#?}");
    assert!(ended.stdout.contains("vehicles among clusters"), "{ended:#?}");
    let command =
        "scanbench train rivals street-narrow --seed 7 --simulated-scans 6 --sensors vlp-16,hdl-32e";
    for name in ["clusters.model", "kd_tree_trained.model", "kd_tree_tree.model"] {
        let model = workplace.read_bytes(&format!("model/{name}"));
        assert!(String::from_utf8_lossy(&model).contains(&format!("command = \"{command}\"")), "{name}");
    }
    let option = "vehicle_model.rivals_directory=model";
    for detector in ["kd-tree-trained", "kd-tree-tree", "kd-tree", "simple-grid"] {
        let ([shipped, trained], _) = outcomes(&workplace, detector, option);
        assert_ne!(shipped, trained, "{detector}");
    }
    let table = workplace.read("trained-kd-tree/table_vehicles.md");
    let said = "Vehicles classified by: kd-tree: trees trained on kd-tree components from \"model\".";
    assert!(table.contains(said), "{table}");
}

#[test]
fn a_model_that_was_trained_with_other_parameters_is_refused_with_both_values() {
    let workplace = Workplace::new();
    let train =
        ["train", "groupings", "street-narrow", "--seed", "7", "--simulated-scans", "6", "-o", "model"];
    workplace.succeed(&[&train[..], &["-P", "walls.enabled=false", "-P", "grouping.rounds=2"]].concat());
    let run = ["run", "street-narrow", "--simulated-scans", "1", "-d", "hierarchical", "--no-rrd"];
    let model = ["-P", "vehicle_model.groupings_directory=model"];
    let ended = workplace.run(&[&run[..], &model, &["-o", "refused"]].concat());
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    let said = "its model was trained with hierarchical.grouping.rounds = 2, and here it is 3";
    assert!(ended.stderr.contains(said), "{ended:#?}");
    let same = ["-P", "hierarchical.walls.enabled=false", "-P", "hierarchical.grouping.rounds=2"];
    workplace.succeed(&[&run[..], &model, &same, &["-o", "same"]].concat());
    let ended = workplace.run(&["train", "groupings", "street-narrow", "-P", "pca.grid.cell_size_m=0.5"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("changes no groups that are trained on"), "{ended:#?}");
}

#[test]
fn a_model_that_no_chosen_detector_reads_is_refused_by_name() {
    let workplace = Workplace::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    workplace.write("mine.toml", &format!("[vehicle_model]\ngroupings_directory = {shipped:?}"));
    let of_groupings = format!("vehicle_model.groupings_directory={shipped}");
    let switched_off = [of_groupings.as_str(), "-P", "vehicle_model.enabled=false"];
    for (options, reads) in [
        (&["-d", "kd-tree", "-P", &of_groupings][..], "kd-tree reads vehicle_model.rivals_directory"),
        (&["-d", "kd-tree,pca", "-c", "mine.toml"], "pca reads vehicle_model.pca_directory"),
        (&[&["-d", "hierarchical", "-P"][..], &switched_off].concat(), "hierarchical reads no model"),
    ] {
        let ended = workplace.run(&[&["run", "street-narrow", "-o", "out"], options].concat());
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        let said = format!("vehicle_model.groupings_directory = {shipped:?}: no chosen detector reads it; ");
        assert!(ended.stderr.contains(&said) && ended.stderr.contains(reads), "{ended:#?}");
        assert!(!workplace.path("out").exists());
    }
    // Some of the variants read it.
    let ablation =
        ["ablation", "street-narrow", "--simulated-scans", "1", "-q", "-o", "ablation", "-P", &of_groupings];
    workplace.succeed(&ablation);
    let sweep = ["sweep", "street-narrow", "-d", "kd-tree", "-P", &of_groupings, "-P"];
    let ended = workplace.run(&[&sweep[..], &["tolerance_m=0.4:0.5:0.1"]].concat());
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("no chosen detector reads it"), "{ended:#?}");
}

#[test]
fn a_damaged_model_is_named() {
    let workplace = Workplace::new();
    let params = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    std::fs::create_dir(workplace.path("model")).expect("an empty workplace");
    for (detector, kind) in [("hierarchical", "groupings"), ("paper", "paper")] {
        let name = format!("{kind}.model");
        let whole = std::fs::read(format!("{params}/{name}")).expect("it is shipped");
        let mut changed = whole.clone();
        changed[5000] ^= 1;
        let option = format!("vehicle_model.{kind}_directory=model");
        for damaged in [&changed, &whole[..whole.len() / 2]] {
            workplace.write_bytes(&format!("model/{name}"), damaged);
            let ended = workplace.run(&["run", "street-narrow", "-d", detector, "-P", &option, "-o", "out"]);
            assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
            assert!(ended.stderr.contains(&format!("{name}: the file is damaged")), "{ended:#?}");
        }
    }
    let ended = workplace.run(&["run", "-P", "vehicle_model.groupings_directory=nowhere", "-o", "out"]);
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    assert!(ended.stderr.contains("groupings.model: "), "{ended:#?}");
}

#[test]
fn the_detectors_of_the_papers_have_models_of_their_own() {
    let (workplace, _) = trained();
    let ([shipped, mine], _) = outcomes(&workplace, "paper", "vehicle_model.paper_directory=model");
    assert_ne!(shipped, mine);
    workplace.succeed(&[&TRAIN_PCA[..], &["-o", "model-pca"]].concat());
    let model = ModelFile::of_any_kind(&workplace.read_bytes("model-pca/pca.model")).expect("it is a model");
    let command = "scanbench train pca streets --seed 7 --simulated-scans 4 --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.2";
    assert_eq!(model.made().command, command);
    let header = workplace.read("model-pca/objects.csv").lines().next().expect("a header").to_owned();
    assert!(header.contains(",decision,height_m,length_m,width_m,scatterness_from_0,"), "{header}");
    let ([shipped, mine], _) = outcomes(&workplace, "pca", "vehicle_model.pca_directory=model-pca");
    assert_ne!(shipped, mine);
    // Each is no model for the other.
    std::fs::create_dir(workplace.path("exchanged")).expect("there is none");
    for (detector, other, other_file) in
        [("pca", "paper", "model/paper.model"), ("paper", "pca", "model-pca/pca.model")]
    {
        workplace.write_bytes(&format!("exchanged/{detector}.model"), &workplace.read_bytes(other_file));
        let option = format!("vehicle_model.{detector}_directory=exchanged");
        let ended = workplace.run(&["run", "-d", detector, "-P", &option, "-o", "out"]);
        assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
        let said = format!("{detector}.model: it is a model of \"{other}\", not of \"{detector}\"");
        assert!(ended.stderr.contains(&said), "{ended:#?}");
    }
}

#[test]
fn other_data_may_be_judged_by() {
    let workplace = Workplace::new();
    let held_out = ["--held-out", "street-narrow", "--held-out-scans", "0..2", "-o", "model"];
    let ended = workplace.succeed(&[&TRAIN_PCA[..], &held_out].concat());
    let [trained, judged] = ["Trained on 6 drives: ", "Held out 1 drives: street-narrow: narrow-803595\n"];
    assert!(ended.stdout.contains(trained) && ended.stdout.contains(judged), "{ended:#?}");
    let model = ModelFile::of_any_kind(&workplace.read_bytes("model/pca.model")).expect("it is a model");
    let command = &model.made().command;
    assert!(command.contains("--nu 0.2 --held-out street-narrow --held-out-scans 0..2"), "{command}");
    let objects = workplace.read("model/objects.csv");
    assert!(
        objects.lines().count() > 10
            && objects.lines().skip(1).all(|it| it.starts_with("street-narrow,narrow-803595,"))
    );
    let manifest: serde_json::Value =
        serde_json::from_str(&workplace.read("model/manifest.json")).expect("JSON");
    assert_eq!(manifest["held_out_datasets"][0]["id"], "street-narrow");
    check_refused(
        &workplace,
        &["pca", "training-narrow", "--scans", "0..2", "--held-out", "training-narrow", "-o", "m"],
        2,
        "is both in the training data and in --held-out",
    );
    check_refused(
        &workplace,
        &["groupings", "training-narrow", "--held-out", "nowhere", "-o", "m"],
        2,
        "nowhere",
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
    for model in ["groupings", "rivals", "paper"] {
        check_refused(
            &workplace,
            &[model, "training-narrow", "--scans", "0..2", "-o", "model"],
            2,
            "one drive",
        );
        check_refused(&workplace, &[model, "nowhere", "-o", "model"], 2, "nowhere");
        check_refused(&workplace, &[model, "-o", "model"], 2, "nothing learns from it");
    }
    let too_much = [&TRAIN[1..7], &["--nu", "1.5", "-o", "model"]].concat();
    check_refused(&workplace, &too_much, 4, "nu = 1.5");
    check_refused(&workplace, &["groupings", "streets", "--nu", "0.3"], 2, "--nu");
    check_refused(&workplace, &["paper", "streets", "--sensors", "vlp-16"], 2, "--sensors");
    let prototypes = ["groupings", "streets", "--prototypes", "nowhere.model", "-o", "model"];
    check_refused(&workplace, &prototypes, 2, "--prototypes nowhere.model: ");
}

#[test]
fn groupings_are_trained_for_several_sensors_and_run() {
    let workplace = Workplace::new();
    let train = [
        "train",
        "groupings",
        "street-narrow",
        "--seed",
        "7",
        "--simulated-scans",
        "6",
        "--sensors",
        "vlp-16,hdl-32e",
    ];
    let ended = workplace.succeed(&[&train[..], &["-o", "model"]].concat());
    assert!(ended.stdout.contains("Probability of a vehicle"), "{ended:#?}");
    let command =
        "scanbench train groupings street-narrow --seed 7 --simulated-scans 6 --sensors vlp-16,hdl-32e";
    let model = workplace.read_bytes("model/groupings.model");
    assert!(String::from_utf8_lossy(&model).contains(&format!("command = \"{command}\"")));
    assert!(workplace.read("model/calibration.csv").starts_with("what,expected,observed,n_groups\n"));
    workplace.succeed(&[&train[..], &["-o", "again"]].concat());
    for name in ["groupings.model", "calibration.csv"] {
        let [first, again] = ["model", "again"].map(|it| workplace.read_bytes(&format!("{it}/{name}")));
        assert!(first == again, "{name}");
    }
    // Against the model that comes with the program.
    let ([shipped, trained], _) =
        outcomes(&workplace, "hierarchical", "vehicle_model.groupings_directory=model");
    assert_ne!(shipped, trained);
}

#[test]
fn boxes_are_trained_to_the_byte_and_run() {
    let workplace = Workplace::new();
    let train = [
        "train",
        "boxes",
        "street-narrow",
        "--seed",
        "7",
        "--simulated-scans",
        "6",
        "--sensors",
        "vlp-16,hdl-32e",
    ];
    let ended = workplace.succeed(&[&train[..], &["-o", "model"]].concat());
    assert!(ended.stdout.contains("held-out ones, in %:\n"), "{ended:#?}");
    assert!(ended.stdout.contains("IoU in space >= 0.7\n  expected  observed     boxes\n"), "{ended:#?}");
    let model = workplace.read_bytes("model/boxes.model");
    let made = ModelFile::of_any_kind(&model).expect("it is a model").made().clone();
    assert_eq!(made.command, format!("scanbench {}", train.join(" ")));
    let mut command = workplace.command(&[&train[..], &["-o", "again"]].concat());
    let again = Ended::from(command.env("RAYON_NUM_THREADS", "1").output().expect("it starts"));
    assert_eq!(again.exit_code, Some(0), "{again:#?}");
    assert!(model == workplace.read_bytes("again/boxes.model"));
    let run = ["run", "street-narrow", "--simulated-scans", "2", "--no-rrd", "-d", "hierarchical,kd-tree"];
    let option = ["-P", "vehicle_model.boxes_directory=model"];
    workplace.succeed(&[&run[..], &["-o", "shipped"]].concat());
    workplace.succeed(&[&run[..], &option, &["-o", "trained"]].concat());
    // Boxes differ, and nothing else: classes, scores and points stand before them.
    let matches = |directory: &str| -> Vec<(String, String)> {
        let text = workplace.read(&format!("{directory}/matches.csv"));
        let column =
            text.lines().next().expect("a header").split(',').position(|it| it == "detection_center_x_m");
        let part = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            let (before, boxes) = cells.split_at(column.expect("a column"));
            (before.join(","), boxes.join(","))
        };
        text.lines().map(part).collect()
    };
    let (shipped, trained) = (matches("shipped"), matches("trained"));
    assert!(shipped.iter().map(|it| &it.0).eq(trained.iter().map(|it| &it.0)));
    assert!(shipped.iter().zip(&trained).filter(|(a, b)| a.1 != b.1).count() > 10);
    let refused = workplace.run(&[&run[..5], &["-d", "pca"], &option, &["-o", "refused"]].concat());
    assert_eq!(refused.exit_code, Some(2), "{refused:#?}");
    assert!(refused.stderr.contains("no chosen detector reads it"), "{refused:#?}");
}
