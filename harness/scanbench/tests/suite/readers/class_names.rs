//! Names of classes: one rule for all formats.

use std::path::PathBuf;

use mcap::WriteOptions;
use reports::vocabulary::class::AnnotationClass;

use super::recordings::{SECOND, category, foxglove_messages, write};
use super::{made, open};
use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// Replaces `from` by `to` in a text file.
fn replace(path: PathBuf, from: &str, to: &str) {
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from} is not in {}", path.display());
    std::fs::write(path, text.replace(from, to)).unwrap();
}

/// Data sets whose labels have a `Fork_Lift` and a *gizmo*, by format, with the file or folder to name.
fn data_sets(workplace: &Workplace) -> Vec<&'static str> {
    let line = |number: u32, class: &str| {
        format!("{number} {number} {class} 0 0 0 500 150 700 300 1.5 1.8 4.2 0 1.7 12 0\n")
    };
    for number in 0..2 {
        std::fs::create_dir_all(workplace.path(["t", "o"][number])).unwrap();
    }
    let tracking = DrawnDataset::tracking(&workplace.path("t"), 2);
    tracking.write("training/label_02/0000.txt", line(0, "Fork_Lift") + &line(1, "gizmo") + &line(0, "CAR"));
    let objects = DrawnDataset::objects(&workplace.path("o"), 2);
    for (number, class) in ["Fork_Lift", "gizmo"].into_iter().enumerate() {
        let line = line(number as u32, class);
        let line = line.splitn(3, ' ').nth(2).unwrap();
        objects.write(
            &format!("training/label_2/{number:06}.txt"),
            format!("{line}{}", line.replace(class, "car")),
        );
    }
    let street = made::street(2);
    made::kitti_raw(&workplace.path("raw"), &*street);
    let tracklets = workplace.path("raw").join(made::DRIVE).join("tracklet_labels.xml");
    let text = std::fs::read_to_string(&tracklets).unwrap();
    let text = text.replacen("<objectType>", "<objectType>Fork Lift</objectType><x>", 1);
    let mut text = text.replacen("</objectType><h>", "</x><h>", 1);
    let last = text.rfind("<objectType>").unwrap();
    text.replace_range(last..last + 12, "<objectType>gizmo</objectType><x>");
    let end = last + text[last..].find("</objectType><h>").unwrap();
    text.replace_range(end..end + 13, "</x>");
    std::fs::write(tracklets, text).unwrap();
    made::nuscenes(&workplace.path("nuscenes"), &*street);
    let categories = workplace.path("nuscenes/v1.0-mini/category.json");
    replace(categories.clone(), "vehicle.car", "fork.lift");
    replace(categories, "vehicle.truck", "gizmo");
    for (number, class) in ["Fork Lift", "gizmo"].into_iter().enumerate() {
        let boxes = format!(
            r#"[{{"class": "{class}", "center_m": [5, 1, -1], "length_width_height_m": [4, 2, 1.5], "yaw_rad": 0.1}}]"#
        );
        workplace.write(&format!("folder/labels/{number}.json"), &boxes);
        workplace.write(&format!("folder/{number}.bin"), &[0_u8; 16]);
    }
    let mut messages = Vec::new();
    for (second, class) in [(1, "FORK-LIFT"), (2, "gizmo")] {
        messages.extend(foxglove_messages(second * SECOND, &category(class)));
    }
    write(workplace, WriteOptions::new(), &messages);
    vec!["t/street", "o/street", "raw", "./nuscenes", "folder", "drive.mcap"]
}

#[test]
fn unknown_names_are_listed_at_once_and_mapped_in_every_format() {
    let workplace = Workplace::new();
    for data in data_sets(&workplace) {
        let ended = workplace.run(&["data", "check", data, "--skip-damaged"]);
        // Nothing is damaged: the user has to name the classes, and all unknown ones are reported together.
        assert_eq!(ended.exit_code, Some(2), "{data}: {ended:#?}");
        ended.check_stderr(&["have 2 unknown classes:"]);
        let lines: Vec<&str> = ended.stderr.lines().map(str::trim).collect();
        assert!(
            lines.iter().any(|it| it.starts_with("\"gizmo\"") && it.contains(" times, first in ")),
            "{data}: {ended:#?}"
        );
        assert!(lines.contains(&"\"gizmo\" = \"misc\""), "{data}: {ended:#?}");
        let options = lines.iter().find(|it| it.starts_with("--class")).unwrap();
        assert!(
            options.to_lowercase().contains("fork") && options.contains("--class gizmo=misc"),
            "{data}: {ended:#?}"
        );
        // A run says the same, and nothing of scans that it could not read.
        let ended = workplace.run(&["run", data, "-d", "pca", "--no-rrd", "-o", "out"]);
        ended.check_stderr(&["have 2 unknown classes:"]);
        assert!(!ended.stderr.contains("beams"), "{data}: {ended:#?}");
        let mapped = ["--class", "fork lift=truck", "--class", "GIZMO=Pole"];
        let ended = workplace.succeed(&(["data", "check", data], &mapped));
        let annotations = ended.stdout.lines().find(|it| it.starts_with("annotations")).unwrap();
        assert!(annotations.contains(" truck") && annotations.contains(" pole"), "{data}: {annotations}");
        // One of the two is not enough, and both are still said where both are missing.
        let ended = workplace.end_with(&["data", "check", data, "--class", "fork lift=truck"], 2, &[]);
        assert!(
            ended.stderr.contains("have 1 unknown class:") && !ended.stderr.contains("fork"),
            "{data}: {ended:#?}"
        );
    }
}

#[test]
fn labels_of_semantic_kitti_that_nobody_knows_are_listed_by_number() {
    let workplace = Workplace::new();
    for number in 0..2 {
        workplace.write(&format!("s/sequences/00/velodyne/{number:06}.bin"), &[0_u8; 32]);
        let labels = [12 + number as u8, 0, 1, 0, 40, 0, 0, 0];
        workplace.write(&format!("s/sequences/00/labels/{number:06}.label"), &labels);
    }
    let ended = workplace.end_with("data check s", 2, &[]);
    // 13 is a bus; of 12 there are only points in the first scan.
    ended.check_stderr(&["\"12\"", "000000.label\", point 0"]);
    assert!(!ended.stderr.contains("\"13\""), "{ended:#?}");
    workplace.succeed("data check s --class 12=car").check_stdout(&["1 car, 1 bus"]);
}

#[test]
fn an_object_without_a_class_has_to_be_given_one() {
    let workplace = Workplace::new();
    let messages = foxglove_messages(SECOND, &serde_json::json!([]));
    write(&workplace, WriteOptions::new(), &messages);
    workplace.end_with("data check drive.mcap", 2, &["--class =misc", "\"\" = \"misc\""]);
    workplace.succeed("data check drive.mcap --class =car").check_stdout(&[": 1 car"]);
}

#[test]
fn configuration_catalogue_and_options_say_it_and_the_manifest_keeps_it() {
    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 2);
    drawn.change("training/label_02/0000.txt", |bytes| {
        *bytes = String::from_utf8(bytes.clone()).unwrap().replace("Car", "auto-mobil").into_bytes();
    });
    let run = ["run", "street", "-d", "pca", "--no-rrd", "--overwrite", "-o", "run"];
    workplace.refuse(&run, 2, &[]);
    assert!(!workplace.path("run").exists());
    workplace.write("mine.toml", "[classes]\nAUTO_MOBIL = \"car\"\n");
    let entry = |lines: &str| {
        format!(
            "[recorded.drive]\nformat = \"kitti-tracking\"\nroot = \"street\"\nannotated_classes = \"every-object\"\n\
             sensor_height_m = 1.73\nlicence = \"ours\"\nurl = \"https://example.org\"\n{lines}"
        )
    };
    workplace.write("catalogue.toml", &entry("classes = { auto-mobil = \"van\" }\n"));
    let mapping = |arguments: &str, class: &[&str]| -> serde_json::Value {
        workplace.succeed(&("run -d pca --no-rrd --overwrite -o run", arguments, class));
        let manifest = workplace.json("run/manifest.json");
        manifest["datasets"][0]["classes"].clone()
    };
    for (arguments, class, expected) in [
        ("street -c mine.toml", &[][..], serde_json::json!({"AUTO_MOBIL": "car"})),
        ("drive --catalogue catalogue.toml", &[], serde_json::json!({"auto-mobil": "van"})),
        // The configuration has the last word over the catalogue, the option over both.
        ("drive --catalogue catalogue.toml -c mine.toml", &[], serde_json::json!({"AUTO_MOBIL": "car"})),
        (
            "drive --catalogue catalogue.toml -c mine.toml",
            &["--class", "auto mobil=truck"],
            serde_json::json!({"auto mobil": "truck"}),
        ),
    ] {
        assert_eq!(mapping(arguments, class), expected, "{arguments} {class:?}");
    }
    let matches = workplace.read("run/matches.csv");
    assert!(matches.contains(",truck,") && !matches.contains(",car,"), "{}", &matches[..500]);
    // Where nothing is mapped, nothing is said.
    DrawnDataset::tracking(workplace.folder(), 2);
    assert_eq!(mapping("street", &[]), serde_json::Value::Null);
}

#[test]
fn checksums_and_lists_do_not_ask_about_classes() {
    let workplace = Workplace::new();
    data_sets(&workplace);
    let ended = workplace.succeed("data hash t/street ./nuscenes drive.mcap");
    assert_eq!(ended.stdout.lines().count(), 3);
}

#[test]
fn a_word_of_makers_is_known_in_recordings() {
    let workplace = Workplace::new();
    let [cloud, scene] = foxglove_messages(SECOND, &category("Dog"));
    let scan = open(&write(&workplace, WriteOptions::new(), &[cloud, scene])).read_scan(0).unwrap();
    assert_eq!(scan.annotations[0].class, AnnotationClass::Animal);
}
