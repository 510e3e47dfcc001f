//! Protocols of others: what a run leaves of them, and what is made of it.

use serde_json::Value;
use test_data::test_data;

use crate::program::{Ended, Prepared, Workplace};

/// Runs two detectors on scans of a narrow street, seen by few beams.
#[track_caller]
fn run(workplace: &Workplace, name: &str, options: &str) {
    let street = "run street-narrow --simulated-scans 12 --scans 0..12:2 --sensor vlp-16 -o";
    let detectors = if options.contains("-d ") { "" } else { "-d hierarchical,pca" };
    let no_recording = if cfg!(feature = "viewer") { "--no-rrd" } else { "" };
    workplace.succeed(&((street, name), detectors, no_recording, options));
}

/// A workplace with a run `before` under a protocol, and one `without`.
fn evaluated() -> Workplace {
    static EVALUATED: Prepared = Prepared::new();
    EVALUATED.workplace(|workplace| {
        run(workplace, "before", "--protocol nuscenes");
        run(workplace, "without", "");
    })
}

fn numbers(workplace: &Workplace, run: &str) -> Vec<Value> {
    let report = workplace.read(&format!("{run}/protocols.json"));
    let report: Value = serde_json::from_str(&report).expect("it is JSON");
    report["rows"].as_array().expect("rows are a list").clone()
}

#[test]
fn a_run_leaves_numbers_rows_tables_and_a_section() {
    let workplace = Workplace::new();
    run(&workplace, "run", "--protocol nuscenes,argoverse2");
    let rows = numbers(&workplace, "run");
    for (protocol, best) in [("nuscenes", "nds"), ("argoverse2", "cds")] {
        for detector in ["hierarchical", "pca"] {
            let is_it = |it: &&Value| {
                it["protocol"] == protocol
                    && it["detector"] == detector
                    && it["class"] == "all"
                    && it["metric"] == best
            };
            let number = rows.iter().find(is_it).unwrap_or_else(|| panic!("no {best} of {detector}"));
            let [value, low] = [&number["value"], &number["interval_95"][0]].map(|it| it.as_f64().unwrap());
            assert!(value > 0.0 && value < 1.0 && low <= value, "{number}");
        }
        for ending in ["csv", "md", "tex"] {
            workplace.check_file(&format!("run/table_protocol_{protocol}.{ending}"), &[best]);
        }
        for ending in ["md", "tex"] {
            let short = workplace.read(&format!("run/table_protocol_{protocol}_short.{ending}"));
            assert!(
                short.contains(best) && !short.contains("pedestrian") && !short.contains("PEDESTRIAN"),
                "{short}"
            );
        }
        workplace.check_file("run/protocol_boxes.csv", &[&format!(",pca,{protocol},detection,")]);
    }
    let page = workplace.read("run/report.html");
    assert!(page.contains("href=\"#protocols\"") && page.contains("Protocol argoverse2"));
    let manifest = workplace.json("run/manifest.json");
    assert_eq!(manifest["protocols"], serde_json::json!(["nuscenes", "argoverse2"]));
    workplace.succeed("report run");
    assert_eq!(workplace.read("run/report.html"), page);
}

#[test]
fn the_order_of_detectors_changes_no_number_and_others_leave_no_file() {
    let workplace = evaluated();
    run(&workplace, "again", "--protocol nuscenes -d pca,hierarchical");
    let sorted = |run: &str| {
        let mut rows: Vec<String> = numbers(&workplace, run).iter().map(Value::to_string).collect();
        rows.sort();
        rows
    };
    assert_eq!(sorted("before"), sorted("again"));
    assert!(!workplace.path("without/protocols.json").exists());
    let manifest = workplace.json("without/manifest.json");
    assert!(manifest["protocols"].is_null());
}

#[test]
fn a_gate_holds_numbers_of_protocols_to_rules() {
    let workplace = evaluated();
    run(&workplace, "after", "--protocol nuscenes -P hierarchical.cluster.min_vehicle_points=60");
    let same = workplace.succeed("gate before -b before --full");
    assert!(same.stdout.starts_with("PASSED"), "{}", same.stdout);
    let compared = workplace.succeed("compare before after -o compared").stdout;
    assert!(compared.contains("nuscenes") && compared.contains("nds"), "{compared}");
    workplace.check_file("compared/comparison.csv", &["nuscenes,hierarchical,all,nds,"]);
    let rule = |metric: &str| {
        format!(
            "quality = []\n[[protocol]]\nprotocol = \"nuscenes\"\nmetrics = [\"{metric}\"]\nclasses = [\"all\", \"car\"]\n\
             absolute = 0.0001\nrelative = 0.0\n"
        )
    };
    workplace.write("rules.toml", &rule("ap"));
    let gate = |run: &str| workplace.run(&("gate", run, "-b before -t rules.toml -o verdict --allow-drift"));
    assert_eq!(gate("before").exit_code, Some(0));
    gate("after");
    workplace.check_file("verdict/gate.json", &["\"task\": \"nuscenes\""]);
    workplace.write("rules.toml", &rule("cds"));
    let refused = gate("after");
    assert_eq!(refused.exit_code, Some(2), "{}", refused.stderr);
    refused.check_stderr(&["the rule has no effect on \"cds\" of \"car\""]);
    workplace.write("rules.toml", &rule("ap"));
    let missing = gate("without");
    assert_eq!(missing.exit_code, Some(5), "{}{}", missing.stdout, missing.stderr);
}

#[test]
fn a_sweep_has_the_numbers_of_a_run_at_every_value() {
    let workplace = Workplace::new();
    let name = "hierarchical.grouping.ranked_probability";
    let street = ["street-narrow", "--simulated-scans", "12", "--scans", "0..12:2", "--sensor", "vlp-16"];
    let swept =
        ["-L", "ranked_probability=0.05,0.5", "--timed-scans", "0", "--protocol", "nuscenes,argoverse2"];
    workplace
        .succeed(&("sweep", &street, &swept, "-o out"))
        .check_stdout(&["Protocols of others: best of 2 values"]);
    let rows = workplace.json("out/sweep_protocols.json");
    let rows = rows["rows"].as_array().unwrap();
    for value in ["0.05", "0.5"] {
        let options = format!("-d hierarchical --protocol nuscenes,argoverse2 -P {name}={value}");
        run(&workplace, value, &options);
        let without_point = |row: &Value| {
            let mut row = row.as_object().unwrap().clone();
            row.remove("point");
            row.remove("values");
            Value::Object(row)
        };
        let at_value: Vec<Value> =
            rows.iter().filter(|it| it["values"][name] == value).map(without_point).collect();
        assert_eq!(at_value, numbers(&workplace, value));
    }
    assert_eq!(workplace.read("out/sweep_protocols.csv").lines().count(), 1 + rows.len());
    for file in ["sweep_protocols.md", "sweep_protocols.tex", "protocol_nuscenes_street-narrow.pdf"] {
        assert!(workplace.path(&format!("out/{file}")).is_file(), "{file}");
    }
    workplace.check_file("out/protocol_argoverse2_street-narrow.svg", &["present cds", "ranked probability"]);
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["protocols"], serde_json::json!(["nuscenes", "argoverse2"]));
    workplace.succeed("report out");
    workplace.check_file("out/report.html", &["sweep_protocols.csv"]);
}

#[test]
fn labels_fed_back_have_the_best_numbers() {
    let workplace = Workplace::new();
    let arguments =
        "selftest street-narrow --simulated-scans 2 --sensor vlp-16 --protocol nuscenes,argoverse2";
    let said = workplace.succeed(arguments).stdout;
    assert!(said.contains("protocol nuscenes: ") && said.contains("protocol argoverse2: "), "{said}");
    assert!(!said.contains("FAILED"), "{said}");
}

#[test]
fn a_split_of_kitti_is_the_scans_of_its_list() {
    let workplace = Workplace::new();
    let street = ["data", "simulate", "street-narrow", "--simulated-scans", "3", "--sensor", "vlp-16"];
    workplace.succeed(&(&street, "--to kitti-object -o objects"));
    workplace.refuse(
        "run objects -d pca --protocol kitti-object --no-rrd -o refused",
        2,
        &["objects", "has labels that do not say where objects are in the image"],
    );
    // KITTI has no class for what else stands there, and a rectangle in the image for each object.
    for scan in 0..3 {
        let labels = format!("objects/training/label_2/{scan:06}.txt");
        let text = workplace.read(&labels);
        let known =
            |it: &&str| ["Car ", "Van ", "Pedestrian ", "Cyclist "].iter().any(|name| it.starts_with(name));
        let in_image = |line: &str| {
            let mut words: Vec<&str> = line.split(' ').collect();
            words[4..8].copy_from_slice(&["500", "150", "600", "250"]);
            words.join(" ") + "\n"
        };
        let known: String = text.lines().filter(known).map(in_image).collect();
        workplace.write(&labels, &known);
    }
    workplace.write("objects/ImageSets/val.txt", "000002\n000000\n");
    let run = |name: &str| {
        let arguments =
            ["run", name, "-d", "pca", "--protocol", "kitti-object", "--no-rrd", "--overwrite", "-o", "run"];
        let mut command = workplace.command(&arguments);
        Ended::from(command.env("KITTI_OBJECT_ROOT", "objects").output().expect("it starts"))
    };
    let ended = run("kitti-object-val");
    assert_eq!(ended.exit_code, Some(0), "{}", ended.stderr);
    assert!(
        ended.stdout.contains("ap_3d_moderate_r40") && !ended.stdout.contains("sound_"),
        "{}",
        ended.stdout
    );
    let scans: std::collections::BTreeSet<String> = workplace
        .read("run/scans.csv")
        .lines()
        .skip(1)
        .map(|it| it.split(',').nth(2).unwrap_or_default().to_owned())
        .collect();
    assert_eq!(scans.into_iter().collect::<Vec<_>>(), ["0", "2"]);
    assert_eq!(numbers(&workplace, "run").len(), 216);
    workplace.write("objects/ImageSets/val.txt", "000002\n000007\n");
    let ended = run("kitti-object-val");
    assert_eq!(ended.exit_code, Some(3), "{}", ended.stderr);
    ended.check_stderr(&["000007.bin"]);
}

#[test]
#[ignore = "needs data/argoverse2 in SCANBENCH_TEST_DATA"]
fn labels_of_a_recorded_sweep_have_the_best_numbers() {
    let root = test_data("data/argoverse2").join("sensor/val");
    let said =
        Workplace::new().succeed(&["selftest", root.to_str().unwrap(), "--protocol", "argoverse2"]).stdout;
    assert!(said.contains("ok     val, protocol argoverse2: "), "{said}");
}
