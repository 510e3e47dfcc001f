//! What the first scans of recorded data show: the sensor, how it is mounted, and whether the frame is as it should be.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use serde_json::Value;

use crate::program::{Prepared, Workplace};

/// Simulated scans of `sensor` as if they were recorded: no file says where they come from. A small one is on a robot.
fn recorded(sensor: &str) -> Workplace {
    static RECORDED: [Prepared; 3] = [const { Prepared::new() }; 3];
    let sensors = ["hdl-64e-s2", "vlp-16", "xt32"];
    let idx = sensors.iter().position(|it| *it == sensor).unwrap();
    RECORDED[idx].workplace(|workplace| {
        let simulate = "data simulate street-main-road --scans 0..2 --to semantic-kitti -o robot --sensor";
        let height_m = if idx == 0 { "1.73" } else { "0.9" };
        workplace.succeed(&(simulate, sensor, "--sensor-height", height_m));
        std::fs::remove_file(workplace.path("robot/scanbench.json")).unwrap();
    })
}

/// Rewrites all clouds below `folder`.
fn move_points(folder: &Path, position_m: &dyn Fn([f32; 3]) -> [f32; 3]) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            move_points(&path, position_m);
        } else if path.extension().is_some_and(|it| it == "bin") {
            let mut bytes = std::fs::read(&path).unwrap();
            for point in bytes.as_chunks_mut::<16>().0 {
                let at = |axis: usize| f32::from_le_bytes(point[4 * axis..4 * axis + 4].try_into().unwrap());
                let moved_m = position_m([at(0), at(1), at(2)]);
                for (axis, value_m) in moved_m.into_iter().enumerate() {
                    point[4 * axis..4 * axis + 4].copy_from_slice(&value_m.to_le_bytes());
                }
            }
            std::fs::write(&path, bytes).unwrap();
        }
    }
}

/// Runs, and returns what is printed and what the manifest says of the data set.
fn run(workplace: &Workplace, options: &[&str]) -> (String, Value) {
    let run = ["run", "robot", "-d", "pca,hierarchical", "--no-rrd", "-o", "out", "--overwrite"];
    let ended = workplace.succeed(&(&run, options));
    let manifest = workplace.json("out/manifest.json");
    (format!("{}{}", ended.stdout, ended.stderr), manifest["datasets"][0].clone())
}

fn f_rate(workplace: &Workplace) -> f64 {
    let report = workplace.json("out/report.json");
    let rows = report["rows"].as_array().unwrap();
    let is_it = |it: &&Value| {
        it["detector"] == "hierarchical"
            && it["task"] == "objects"
            && it["slice"] == "all"
            && it["metric"] == "f_rate"
    };
    rows.iter().find(is_it).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn a_sensor_on_a_robot_is_recognised_with_its_height_and_tilt() {
    let workplace = recorded("vlp-16");
    let (said, entry) = run(&workplace, &[]);
    assert!(said.contains("16 beams from -15.0 to 15.0 degrees as vlp-16 has"), "{said}");
    assert_eq!((&entry["sensor"], &entry["seen"]["sensor"]), (&"vlp-16".into(), &"vlp-16".into()));
    assert!((entry["sensor_height_m"].as_f64().unwrap() - 0.9).abs() < 0.1, "{entry}");
    assert_eq!(entry["seen"]["taken"], serde_json::json!(["sensor", "height"]));
    workplace.succeed("data check robot").check_stdout(&["vlp-16 (by its beams), 1.73 m above the road"]);
    let upright = f_rate(&workplace);
    let (sin, cos) = 8_f32.to_radians().sin_cos();
    move_points(&workplace.path("robot"), &|[x, y, z]| [x, cos * y - sin * z, sin * y + cos * z]);
    let (said, entry) = run(&workplace, &[]);
    assert!(said.contains("height and tilt taken from the scans"), "{said}");
    assert!((entry["seen"]["tilt_deg"].as_f64().unwrap() - 8.0).abs() < 0.5, "{entry}");
    assert!((f_rate(&workplace) - upright).abs() < 0.08, "{} and {upright}", f_rate(&workplace));
    assert!(!said.contains("no verdict"), "{said}");
    // So it is where the height is stated, and by the name that a catalogue gives the folder.
    let levelled = f_rate(&workplace);
    let height = entry["sensor_height_m"].to_string();
    let (said, entry) = run(&workplace, &["--sensor-height", &height]);
    assert!(said.contains("sensor and tilt taken from the scans"), "{said}");
    assert!((f_rate(&workplace) - levelled).abs() < 0.01, "{}", f_rate(&workplace));
    assert_eq!(entry["seen"]["taken"], serde_json::json!(["sensor", "tilt"]));
    workplace.write("mine.toml", "");
    workplace.succeed("data add robot --catalogue mine.toml");
    let ended =
        workplace.succeed("run robot --catalogue mine.toml -d pca,hierarchical --no-rrd -o out --overwrite");
    ended.check_stderr(&["tilt taken from the scans"]);
    assert!((f_rate(&workplace) - levelled).abs() < 0.01, "{}", f_rate(&workplace));
    // Results that name no frame are in that of the files, and stay with the points.
    workplace.succeed("detect robot --scan 0 -d kd-tree --boxes others.csv");
    let of_others = ["--detections", "others=others.csv", "--missing-detections", "empty"];
    let (said, entry) = run(&workplace, &of_others);
    assert!(said.contains("the ground is tilted by 8.0 degrees in the frame of the scans"), "{said}");
    assert_eq!(entry["seen"]["taken"], serde_json::json!(["sensor", "height"]));
}

#[test]
fn proposals_go_by_what_the_scans_show() {
    let workplace = recorded("xt32");
    let ended = workplace.succeed("data prelabel robot -o project --to labelcloud");
    ended.check_stderr(&["32 beams", "sensor, density and height taken from the scans"]);
    assert!(!ended.stderr.contains("warning"), "{ended:#?}");
    // What comes back has the sensor and the height that were taken.
    let manifest = workplace.read("project/scanbench.json");
    let written: Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(written["sensor"], "xt32", "{manifest}");
    assert!((written["sensor_height_m"].as_f64().unwrap() - 0.9).abs() < 0.1, "{manifest}");
}

#[test]
fn streets_that_slope_a_little_are_not_levelled() {
    let workplace = recorded("hdl-64e-s2");
    let (sin, cos) = 3_f32.to_radians().sin_cos();
    move_points(&workplace.path("robot"), &|[x, y, z]| [x, cos * y - sin * z, sin * y + cos * z]);
    let (said, entry) = run(&workplace, &[]);
    assert!((entry["seen"]["tilt_deg"].as_f64().unwrap() - 3.0).abs() < 0.5, "{entry}");
    assert_eq!(entry["seen"]["taken"], serde_json::json!([]));
    assert!(entry["doubts"].is_null() && !said.contains("\"robot\" is suspect"), "{said}");
}

#[test]
fn no_verdict_rests_on_a_frame_that_points_elsewhere_and_a_transform_mends_it() {
    let workplace = recorded("hdl-64e-s2");
    let (said, entry) = run(&workplace, &[]);
    assert!(!said.contains("suspect") && entry["doubts"].is_null(), "{said}");
    let upright = f_rate(&workplace);
    // A camera's frame: x right, y down, z forward.
    move_points(&workplace.path("robot"), &|[x, y, z]| [-y, -z, x]);
    let (said, entry) = run(&workplace, &[]);
    assert!(
        said.contains("warning: the frame of \"robot\" is suspect: the axis that points up is -y, not z"),
        "{said}"
    );
    assert!(said.contains("Task objects: no verdict, since frame or labels of robot are suspect."), "{said}");
    assert_eq!(entry["doubts"].as_array().unwrap().len(), 1);
    workplace.check_file("out/report.html", &["the axis that points up is -y"]);
    let checked = workplace.succeed("data check robot").stdout;
    assert!(checked.contains("the axis that points up is -y, not z"), "{checked}");
    workplace.write("mounting.txt", "# sensor from camera\n0 0 1 0\n-1 0 0 0\n0 -1 0 0\n");
    let (said, entry) = run(&workplace, &["--transform", "mounting.txt"]);
    assert!(!said.contains("suspect") && entry["doubts"].is_null(), "{said}");
    assert_eq!(f_rate(&workplace), upright);
}

#[test]
fn a_frame_upside_down_is_said_before_heights_with_the_file_that_mends_it() {
    let workplace = recorded("hdl-64e-s2");
    move_points(&workplace.path("robot"), &|[x, y, z]| [x, -y, -z]);
    let checked = workplace.succeed("data check robot").stdout;
    let warning = checked.lines().find(|it| it.starts_with("WARNING")).unwrap();
    assert!(warning.contains("the axis that points up is -z, not z"), "{checked}");
    assert!(!checked.contains("--sensor-height"), "{checked}");
    let turn = warning.split('`').nth(1).unwrap();
    workplace.write("mounting.txt", turn);
    let mended = workplace.succeed("data check robot --transform mounting.txt").stdout;
    assert!(!mended.contains("WARNING"), "{mended}");
}

#[test]
fn what_options_say_is_doubted_but_gone_by() {
    let workplace = recorded("hdl-64e-s2");
    let (said, entry) = run(&workplace, &["--sensor-height", "3", "--sensor", "vlp-16"]);
    assert!(said.contains("but the sensor is said to be 3 m above the road"), "{said}");
    assert_eq!((entry["sensor_height_m"].as_f64(), &entry["sensor"]), (Some(3.0), &"vlp-16".into()));
}

#[test]
fn scans_without_labels_are_run_and_detectors_are_compared() {
    let workplace = recorded("hdl-64e-s2");
    let drive = std::fs::read_dir(workplace.path("robot/sequences")).unwrap().next().unwrap().unwrap().path();
    std::fs::rename(drive.join("velodyne"), workplace.path("clouds")).unwrap();
    let run = ["run", "clouds", "-d", "pca,kd-tree,hierarchical", "--no-rrd", "-o", "out"];
    let ended = workplace.succeed(&run);
    ended.check_stderr(&["\"clouds\" has no labels: nothing is scored"]);
    assert!(
        ended.stdout.contains("also found by [%]") && !ended.stdout.contains("F-rate"),
        "{}",
        ended.stdout
    );
    let rows = workplace.read("out/agreement.csv");
    let rows: Vec<Vec<&str>> = rows.lines().skip(1).map(|it| it.split(',').collect()).collect();
    // Two tasks, three detectors, each with two others.
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let [n_detections, n_other, n_both] = [5, 6, 7].map(|column| row[column].parse::<u64>().unwrap());
        assert!(n_both <= n_detections.min(n_other), "{row:?}");
        let back = rows.iter().find(|it| (it[1], it[2], it[3]) == (row[1], row[3], row[2])).unwrap();
        assert_eq!([back[5], back[6], back[7]], [row[6], row[5], row[7]]);
    }
    assert!(rows.iter().any(|it| it[7] != "0"), "{rows:?}");
    let page = workplace.read("out/report.html");
    assert!(page.contains("Where detectors agree") && page.contains("clouds"));
    for absent in ["F-rate", "is undefined", "published", "id=\"range\"", "id=\"tables\""] {
        assert!(!page.contains(absent), "{absent}");
    }
}

#[test]
fn a_data_set_is_added_to_a_catalogue_as_its_scans_show_it() {
    let workplace = recorded("vlp-16");
    let add = ["data", "add", "robot", "--catalogue", "mine.toml"];
    let added = workplace.succeed(&(&add, "--licence ours")).stdout;
    assert!(added.contains("[recorded.robot]") && added.contains("sensor = \"vlp-16\""), "{added}");
    workplace.refuse(&add, 2, &["has \"robot\" already"]);
    let before = workplace.read("mine.toml");
    workplace.succeed(&(&add, "--id high --sensor-height 2"));
    assert!(workplace.read("mine.toml").starts_with(&before));
    let run = ["run", "high", "robot", "--catalogue", "mine.toml", "-d", "pca", "--no-rrd", "-o", "out"];
    let said = workplace.succeed(&run).stderr;
    assert!(
        said.contains("the frame of \"high\" is suspect") && !said.contains("\"robot\" is suspect"),
        "{said}"
    );
    let manifest = workplace.json("out/manifest.json");
    assert_eq!(manifest["datasets"][1]["licence"], "ours");
    assert_eq!(manifest["datasets"][0]["sensor_height_m"].as_f64(), Some(2.0));
}
