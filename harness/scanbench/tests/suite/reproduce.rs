//! `scanbench reproduce`: the claims of the papers, judged.

use crate::program::{Workplace, copy_folder};
use crate::shard_folders::check_in_shards;

const REPRODUCE: &str = "reproduce all street-narrow --simulated-scans 2 --settings 2 --per-class 2";
/// Few beams, which are simulated quickly.
const BEAMS: &str = "--sensor vlp-16 --seed 7 -o";

#[test]
fn claims_of_all_papers_are_judged_and_gated() {
    let workplace = Workplace::new();
    workplace.succeed(&(REPRODUCE, BEAMS, "first")).check_stdout(&["Of the claims (22) "]);
    copy_folder(&workplace.path("first"), &workplace.path("second"));
    let json = workplace.json("first/reproduction.json");
    let claims = json["claims"].as_array().unwrap();
    assert_eq!(claims.len(), 22);
    assert_eq!(claims[0]["settings"][1], 2);
    let readings: Vec<&str> =
        claims[0]["readings"].as_array().unwrap().iter().map(|it| it["reading"].as_str().unwrap()).collect();
    assert_eq!(readings[..4], ["good faith", "ν and γ as printed", "by centre", "by bev-iou"]);
    // The steps but good faith, then all of them against each of two rivals that get less.
    assert_eq!((readings.len(), readings[4]), (4 + 4 + 2 * 5, "to the letter"));
    assert_eq!(readings[13], "to the letter; against kd-tree over all that is no ground");
    let [of_vehicles, of_objects] = ["first/steps_vehicles.md", "first/steps_objects.md"];
    workplace.check_file(of_vehicles, &["walls stand and hide what is behind them", "pca"]);
    workplace.check_file(of_objects, &["kd-tree over short cells, walls left in"]);
    workplace.check_file("first/losses_objects.svg", &["annotated", "found", "paper, to the letter"]);
    // It is a run, too.
    let rows = workplace.read("first/scans.csv");
    for detector in [
        "paper,",
        "\"paper, to the letter\",",
        "\"paper, ν and γ as printed\",",
        "\"paper, step 4\",",
        "kd-tree,",
        "pca,",
    ] {
        assert!(rows.contains(detector), "{detector}");
    }
    // A claim that holds no longer closes the gate.
    let gate = |run: &str| {
        let ended = workplace.run(&["gate", run, "-b", "first", "-o", "verdict"]);
        (ended.exit_code, ended.stdout)
    };
    assert!(gate("second").1.contains("No result changed"));
    let verdict_of = |it: &serde_json::Value| it["verdict"].as_str().unwrap().to_owned();
    let held = claims.iter().position(|it| verdict_of(it) == "holds").unwrap();
    let mut changed = json.clone();
    changed["claims"][held]["verdict"] = "does_not_hold".into();
    workplace.write("second/reproduction.json", &changed.to_string());
    let (exit_code, said) = gate("second");
    assert!(exit_code == Some(100) && said.contains(" holds → does not hold."), "{said}");
    workplace.check_file("verdict/junit.xml", &["scanbench.claims"]);
    let parts = [
        "Claim by claim",
        "Where objects are lost",
        "Under every setting",
        "The background that the classifier is judged by",
    ];
    workplace.check_file("first/reproduction.html", &parts);
    assert!(workplace.path("first/recording/scans.rrd").exists());
    // The method of BG learns from whole objects, as in the paper, or from parts, and sees them from either end.
    let of_bg = claims.last().unwrap();
    assert_eq!((&of_bg["claim"]["paper"], of_bg["readings"].as_array().unwrap().len()), (&"BG".into(), 4));
    assert_eq!(of_bg["readings"][0]["reading"], "learned from whole, seen from below");
}

const VM: &str =
    "reproduce vm street-narrow --simulated-scans 2 --settings 0 --no-rrd --sensor vlp-16 --seed 7";

/// One line for each claim that is no time.
fn untimed(workplace: &Workplace, folder: &str) -> Vec<String> {
    let text = workplace.read(&format!("{folder}/reproduction.md"));
    // How many claims hold hangs on times, too.
    let is_timed = |it: &&str| ["**Of the claims", " ms", "faster"].iter().any(|part| it.contains(part));
    text.lines().filter(|it| !is_timed(it)).map(str::to_owned).collect()
}

#[test]
fn shards_of_the_run_are_judged_as_the_whole_is() {
    check_in_shards(&Workplace::new(), VM, &[2], |workplace, whole, merged| {
        assert_eq!(untimed(workplace, whole), untimed(workplace, merged));
        let [whole, merged] = [whole, merged].map(|it| workplace.read(&format!("{it}/matches.csv")));
        assert!(whole == merged && whole.lines().count() > 10, "{merged}");
    });
}

#[test]
fn recorded_and_simulated_scans_are_judged_apart() {
    let workplace = Workplace::with_drive(2);
    workplace.succeed(&("reproduce vm street-narrow street --simulated-scans 1 --settings 0", BEAMS, "vm"));
    let json = workplace.json("vm/reproduction.json");
    let overall = &json["claims"][1];
    assert_eq!(overall["claim"]["test"]["scenes"], "overall");
    // One pair of numbers for each origin, by every reading.
    for reading in overall["readings"].as_array().unwrap() {
        let numbers = reading["numbers"].as_str().unwrap();
        assert_eq!(numbers.matches(" against ").count(), 2, "{reading}");
    }
    workplace.check_file("vm/reproduction.html", &["scanbench reproduce vm street-narrow"]);
    for idle in ["--save-rrd=a.rrd", "--no-rrd", "--rerun-every 2", "--blueprint stages"] {
        workplace.refuse(&format!("reproduce all --choose training-streets {idle}"), 2, &[]);
    }
}

#[test]
fn settings_are_judged_the_same_twice() {
    let workplace = Workplace::new();
    for name in ["first", "second"] {
        let hg = "reproduce hg street-narrow --simulated-scans 2 --settings 2 --no-rrd";
        workplace.succeed(&(hg, BEAMS, name));
    }
    for name in ["settings.csv", "open_values.md", "settings.svg"] {
        let [first, second] = ["first", "second"].map(|it| workplace.read(&format!("{it}/{name}")));
        assert!(first == second, "{name}");
    }
    assert_eq!(untimed(&workplace, "first"), untimed(&workplace, "second"));
}

#[test]
fn one_paper_without_settings_and_judged_streets_choose_nothing() {
    let workplace = Workplace::new();
    workplace.succeed(&("reproduce hg street-narrow --simulated-scans 1 --settings 0", BEAMS, "hg"));
    let json = workplace.json("hg/reproduction.json");
    let claims = json["claims"].as_array().unwrap();
    assert!(claims.iter().all(|it| it["claim"]["paper"] == "HG" && it["settings"].is_null()));
    assert!(!workplace.path("hg/settings.csv").exists());
    let chosen = "reproduce all --choose=pca training-streets --scans 0..1 --simulated-scans 1 --settings 2";
    let said = workplace.succeed(&(chosen, "--sensor vlp-16")).stdout;
    assert!(
        said.contains("training-main-road vehicles ") && said.contains("pca.grid.cell_size_m = 0.4"),
        "{said}"
    );
    assert!(!said.contains("training-main-road objects "), "{said}");
}
