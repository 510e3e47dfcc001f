//! Training.

use std::path::Path;

use detector::classify::model_file::ModelFile;

use crate::program::{Prepared, Workplace, copy_folder};

/// Three simulated drives, of which the last is held out.
const DRIVES: &str = "streets --seed 7 --simulated-scans 6 --sensor vlp-16";
/// A street as several sensors see it.
const STREET: &str = "street-narrow --seed 7 --simulated-scans 4 --sensors vlp-16,hdl-32e";
const RUN: &str = "run street-narrow --simulated-scans 3 --sensor vlp-16 --no-rrd -d";

/// A workplace with a trained model in `model`, and what was said.
fn trained() -> Workplace {
    static TRAINED: Prepared = Prepared::new();
    TRAINED.workplace(|workplace| {
        let ended = workplace.succeed(&("train paper", DRIVES, "--nu 0.3 -o model"));
        workplace.write("said", &(ended.stdout + &ended.stderr));
    })
}

/// The command that a model was made by.
fn command_of(workplace: &Workplace, model: &str) -> String {
    let model = ModelFile::of_any_kind(&workplace.read_bytes(model)).expect("it is a model");
    model.made().command.clone()
}

#[test]
fn a_model_says_what_it_was_made_of_and_what_was_held_out() {
    let workplace = trained();
    let model = ModelFile::of_any_kind(&workplace.read_bytes("model/paper.model")).expect("it is a model");
    let made = model.made();
    let command = "scanbench train paper streets --seed 7 --simulated-scans 6 --sensor vlp-16 --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.3";
    assert_eq!((&*made.command, &*made.data[0]), (command, "street-main-road (simulated, seeds from 7)"));
    let held_out = made.split.strip_prefix("held out: ").expect("it says what was held out");
    let drive = held_out.split(": ").nth(1).expect("data set and drive");
    // Nothing of any other drive was judged, and the curves are of as many objects.
    let objects = workplace.read("model/objects.csv");
    let n_objects = objects.lines().skip(1).count();
    assert!(n_objects > 20, "{n_objects}");
    assert!(objects.lines().skip(1).all(|it| it.split(',').nth(1) == Some(drive)), "{objects}");
    let curves = workplace.read("model/curves.csv");
    let last = curves.lines().last().expect("a row").split(',').skip(1).take(4);
    let last: Vec<usize> = last.map(|it| it.parse().expect("a count")).collect();
    assert_eq!(last[0] + last[1], n_objects);
    assert_eq!(last[..2], last[2..], "at the lowest threshold everything is classified as a vehicle");
    assert_eq!(workplace.read("model/importance.csv").lines().count(), 9);
    workplace.check_file("model/curves.svg", &["Held-out drives (simulated)"]);
    let run_it = "Run it: scanbench run -d paper -P vehicle_model.paper_directory=model";
    workplace.check_file("said", &[&format!("Held out 1 drives: {held_out}\n"), run_it]);
}

#[test]
fn of_several_parameters_those_are_taken_that_are_best_on_drives_that_are_left_out() {
    let workplace = Workplace::new();
    let ended = workplace.succeed(&("train pca", DRIVES, "--nu 0.05,0.3 --gamma 0.1,0.2 -o several"));
    let areas: Vec<(&str, &str)> =
        ended.stdout.lines().filter_map(|it| it.trim().strip_prefix("nu ")?.split_once(": ROC ")).collect();
    assert_eq!(areas.len(), 4, "{}", ended.stdout);
    let area = |it: &(&str, &str)| it.1.split(' ').next_back().unwrap().parse::<f64>().unwrap();
    let best = areas.iter().max_by(|a, b| area(a).total_cmp(&area(b))).unwrap().0;
    ended.check_stdout(&["mean of 5 parts of the training drives", &format!("Chosen: nu {best}\n")]);
    // The same as if nothing else had been asked for.
    let (nu, gamma) = best.split_once(", gamma ").unwrap();
    workplace.succeed(&("train pca", DRIVES, ("--nu", nu, "--gamma", gamma), "-o one"));
    assert_eq!(workplace.read("several/objects.csv"), workplace.read("one/objects.csv"));
    assert!(command_of(&workplace, "several/pca.model").ends_with("--gamma 0.1,0.2 --nu 0.05,0.3"));
}

/// No detector finds the same with the shipped models as with others.
#[track_caller]
fn check_outcomes(workplace: &Workplace, detectors: &[&str], option: &str) {
    for (name, option) in [("shipped", ""), ("trained", option)] {
        workplace.succeed(&((RUN, detectors.join(",")), "-o", name, (option, "--overwrite")));
    }
    for detector in detectors {
        let [shipped, trained] = ["shipped", "trained"].map(|name| {
            let rows = workplace.table(&format!("{name}/matches.csv")).into_iter();
            rows.filter(|it| it["detector"] == *detector).collect::<Vec<_>>()
        });
        assert!(shipped != trained && shipped.len() > 10, "{detector}");
    }
}

#[test]
fn rivals_are_trained_for_several_sensors_and_run() {
    let workplace = Workplace::new();
    workplace
        .succeed(&("train rivals", STREET, "-o model"))
        .check_stdout(&["kd-tree-trained, at hdl-32e 0.", "kd-tree-tree"]);
    for name in ["kd_tree_trained.model", "kd_tree_tree.model"] {
        let command = command_of(&workplace, &format!("model/{name}"));
        assert_eq!(command, format!("scanbench train rivals {STREET}"), "{name}");
    }
    let detectors = ["kd-tree-trained", "kd-tree-tree"];
    check_outcomes(&workplace, &detectors, "-P vehicle_model.rivals_directory=model");
}

#[test]
fn the_model_of_clusters_is_trained_for_all_detectors_that_share_it() {
    let workplace = Workplace::new();
    workplace
        .succeed(&("train clusters", STREET, "-o model"))
        .check_stdout(&["vehicles among clusters, trained on "]);
    check_outcomes(&workplace, &["kd-tree", "simple-grid"], "-P vehicle_model.clusters_directory=model");
    let said = "kd-tree, simple-grid: trees trained on kd-tree components from \"model\".";
    workplace.check_file("trained/table_vehicles.md", &["Vehicles classified by: ", said]);
}

#[test]
fn groupings_are_trained_to_the_byte_and_refused_with_other_parameters_with_both_values() {
    let workplace = Workplace::new();
    let train = "train groupings street-narrow --seed 7 --simulated-scans 4 --sensor vlp-16";
    for output in ["model", "again"] {
        workplace.succeed(&(train, "-P walls.enabled=false -P grouping.rounds=2 -o", output));
    }
    for name in ["groupings.model", "calibration.csv"] {
        let [first, again] = ["model", "again"].map(|it| workplace.read_bytes(&format!("{it}/{name}")));
        assert!(first == again, "{name}");
    }
    let model = "-P vehicle_model.groupings_directory=model";
    let said = "its model was trained with hierarchical.grouping.rounds = 2, and here it is 3";
    workplace.refuse(&(RUN, "hierarchical -o refused", model), 2, &[said]);
    let same = "-P hierarchical.walls.enabled=false -P hierarchical.grouping.rounds=2";
    workplace.succeed(&(RUN, "hierarchical -o same", model, same));
}

#[test]
fn a_model_that_no_chosen_detector_reads_is_refused_by_name() {
    let workplace = Workplace::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    workplace.write("mine.toml", &format!("[vehicle_model]\ngroupings_directory = {shipped:?}"));
    let of_groupings = format!("vehicle_model.groupings_directory={shipped}");
    let switched_off = [of_groupings.as_str(), "-P", "vehicle_model.enabled=false"];
    for (options, reads) in [
        (&["-d", "kd-tree", "-P", &of_groupings][..], "kd-tree reads vehicle_model.clusters_directory"),
        (&["-d", "kd-tree,pca", "-c", "mine.toml"], "pca reads vehicle_model.pca_directory"),
        (&[&["-d", "hierarchical", "-P"][..], &switched_off].concat(), "hierarchical reads no model"),
    ] {
        let said = format!("vehicle_model.groupings_directory = {shipped:?}: no chosen detector reads it; ");
        workplace.refuse(&("run street-narrow -o out", options), 2, &[&said, reads]);
    }
    // The file of a project is for all commands in its folder and below, and names folders from where it lies.
    let models = workplace.path("models");
    copy_folder(Path::new(shipped), &models);
    workplace.write("scanbench.toml", "[vehicle_model]\ngroupings_directory = \"models\"");
    std::fs::create_dir(workplace.path("below")).expect("a folder");
    for detector in ["pca", "hierarchical"] {
        let run = (
            "run street-narrow --simulated-scans 1 --sensor vlp-16 -q --no-rrd -o run --overwrite -d",
            detector,
        );
        let ended = workplace.command(&run).current_dir(workplace.path("below")).output().expect("it starts");
        assert!(ended.status.success(), "{ended:?}");
        let manifest = workplace.json("below/run/manifest.json");
        let named = manifest["config"]["vehicle_model"]["groupings_directory"].as_str().expect("a text");
        assert_eq!(Path::new(named), models);
    }
    // So is what stands for it: a copy that Python has added detectors to.
    std::fs::rename(workplace.path("scanbench.toml"), workplace.path("copy.toml")).expect("it was written");
    let copy = workplace.path("copy.toml").into_os_string().into_string().expect("text");
    let run = "run street-narrow --simulated-scans 1 --sensor vlp-16 -q --no-rrd -d pca -o of-copy";
    let ended = workplace.run_with(&[("SCANBENCH_PROJECT", &copy)], run);
    assert_eq!(ended.exit_code, Some(0), "{ended:?}");
    let resolved = &workplace.json("of-copy/manifest.json")["config"]["vehicle_model"];
    assert!(resolved["groupings_directory"].as_str().expect("a text").ends_with("models"), "{resolved}");
    // Some of the variants read it.
    let ablation = "ablation street-narrow --simulated-scans 1 --sensor vlp-16 -q -o ablation -P";
    workplace.succeed(&(ablation, [of_groupings.as_str()]));
    let sweep = ["sweep", "street-narrow", "-d", "kd-tree", "-P", &of_groupings, "-P"];
    workplace.refuse(&(&sweep, "tolerance_m=0.4:0.5:0.1"), 2, &["no chosen detector reads it"]);
}

#[test]
fn a_damaged_model_is_named() {
    let workplace = Workplace::new();
    let params = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    for (detector, kind) in [("hierarchical", "groupings"), ("paper", "paper")] {
        let name = format!("{kind}.model");
        let whole = std::fs::read(format!("{params}/{name}")).expect("it is shipped");
        let mut changed = whole.clone();
        changed[5000] ^= 1;
        let option = format!("vehicle_model.{kind}_directory=model");
        for damaged in [&changed, &whole[..whole.len() / 2]] {
            workplace.write(&format!("model/{name}"), damaged);
            workplace.refuse(
                &["run", "street-narrow", "-d", detector, "-P", &option, "-o", "out"],
                2,
                &[&format!("{name}: the file is damaged")],
            );
        }
    }
    workplace.refuse("run -P vehicle_model.groupings_directory=nowhere -o out", 2, &["groupings.model: "]);
}

#[test]
fn the_detectors_of_the_papers_have_models_of_their_own() {
    let workplace = trained();
    check_outcomes(&workplace, &["paper"], "-P vehicle_model.paper_directory=model");
    workplace.succeed(&("train pca", DRIVES, "-o model-pca"));
    let command = "scanbench train pca streets --seed 7 --simulated-scans 6 --sensor vlp-16 --vehicles 3000 --others 1.5 --gamma 0.1078 --nu 0.2";
    assert_eq!(command_of(&workplace, "model-pca/pca.model"), command);
    let header = workplace.read("model-pca/objects.csv").lines().next().expect("a header").to_owned();
    assert!(header.contains(",decision,height_m,length_m,width_m,scatterness_from_0,"), "{header}");
    check_outcomes(&workplace, &["pca"], "-P vehicle_model.pca_directory=model-pca");
    // Each is no model for the other.
    for (detector, other, other_file) in
        [("pca", "paper", "model/paper.model"), ("paper", "pca", "model-pca/pca.model")]
    {
        workplace.write(&format!("exchanged/{detector}.model"), &workplace.read_bytes(other_file));
        let option = format!("vehicle_model.{detector}_directory=exchanged");
        let said = format!("{detector}.model: it is a model of \"{other}\", not of \"{detector}\"");
        workplace.refuse(&["run", "-d", detector, "-P", &option, "-o", "out"], 2, &[&said]);
    }
}

#[test]
fn other_data_may_be_judged_by() {
    let workplace = Workplace::new();
    let held_out = "--held-out street-narrow --held-out-scans 0..2 -o model";
    workplace
        .succeed(&("train pca", DRIVES, held_out))
        .check_stdout(&["Trained on 9 drives: ", "Held out 1 drives: street-narrow: narrow-803595\n"]);
    let command = command_of(&workplace, "model/pca.model");
    assert!(command.contains("--nu 0.2 --held-out street-narrow --held-out-scans 0..2"), "{command}");
    let objects = workplace.read("model/objects.csv");
    assert!(
        objects.lines().count() > 10
            && objects.lines().skip(1).all(|it| it.starts_with("street-narrow,narrow-803595,"))
    );
    let manifest = workplace.json("model/manifest.json");
    assert_eq!(manifest["held_out_datasets"][0]["id"], "street-narrow");
}

#[test]
fn groupings_are_trained_for_several_sensors_and_run() {
    let workplace = Workplace::new();
    workplace.succeed(&("train groupings", STREET, "-o model")).check_stdout(&["Probability of a vehicle"]);
    let command = command_of(&workplace, "model/groupings.model");
    assert_eq!(command, format!("scanbench train groupings {STREET}"));
    assert!(workplace.read("model/calibration.csv").starts_with("what,expected,observed,n_groups\n"));
    // Against the model that comes with the program.
    check_outcomes(&workplace, &["hierarchical"], "-P vehicle_model.groupings_directory=model");
}

#[test]
fn recorded_scans_are_trained_on_beside_streets() {
    let workplace = Workplace::with_drive(3);
    let street = "street-narrow --seed 7 --simulated-scans 4 --sensors vlp-16,hdl-32e";
    workplace.succeed(&("train groupings", street, "--recorded street -o model"));
    let command = command_of(&workplace, "model/groupings.model");
    assert_eq!(command, format!("scanbench train groupings {street} --recorded street"));
    let manifest = workplace.json("model/manifest.json");
    let datasets = manifest["datasets"].as_array().expect("data sets");
    let ids: Vec<_> = datasets.iter().map(|it| it["id"].as_str().expect("an id")).collect();
    assert_eq!(ids, ["street-narrow", "street-narrow", "street"]);
    // They have a say.
    workplace.succeed(&("train groupings", street, "-o without"));
    let [with, without] =
        ["model", "without"].map(|it| workplace.read_bytes(&format!("{it}/groupings.model")));
    assert!(with != without);
}

#[test]
fn boxes_are_trained_to_the_byte_and_run() {
    let workplace = Workplace::new();
    let street = "street-narrow --seed 7 --simulated-scans 6 --sensor vlp-16";
    workplace
        .succeed(&("train boxes", street, "-o model"))
        .check_stdout(&["held-out ones, in %:\n", "IoU in space >= 0.7\n  expected  observed     boxes\n"]);
    assert_eq!(command_of(&workplace, "model/boxes.model"), format!("scanbench train boxes {street}"));
    let again = workplace.run_with(&[("RAYON_NUM_THREADS", "1")], &("train boxes", street, "-o again"));
    assert_eq!(again.exit_code, Some(0), "{again:#?}");
    assert!(workplace.read_bytes("model/boxes.model") == workplace.read_bytes("again/boxes.model"));
    let option = "-P vehicle_model.boxes_directory=model";
    workplace.succeed(&(RUN, "hierarchical,kd-tree -o shipped"));
    workplace.succeed(&(RUN, "hierarchical,kd-tree -o trained", option));
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
    workplace.refuse(&(RUN, "pca -o refused", option), 2, &["no chosen detector reads it"]);
}
