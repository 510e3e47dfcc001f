//! Scans that are labelled, and in which nothing stands: every detection there is false.

use std::path::{Path, PathBuf};

use scans::annotation::LabeledScan;
use scans::conversion::ConversionError;
use scans::conversion::convert::{Output, convert};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;
use scans::dataset::{Dataset, DatasetError, Listing};

use super::made::{kitti_raw, nuscenes, street, write};
use super::{argoverse2, open};
use crate::drawn_dataset::DrawnDataset;
use crate::program::{Workplace, copy_folder};

/// A data set whose labels say that nothing stands anywhere.
struct Emptied(Box<dyn Dataset>);

impl Dataset for Emptied {
    fn listing(&self) -> &Listing {
        self.0.listing()
    }

    fn inner(&self) -> Option<&dyn Dataset> {
        Some(&*self.0)
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let mut scan = self.0.read_scan(scan_idx)?;
        scan.annotations.clear();
        Ok(scan)
    }
}

fn convert_emptied(format: OutputFormat, path: &Path) {
    let dataset = Emptied(street(2));
    let output = Output { path, format, compression: ChunkCompression::Lz4 };
    convert(&dataset, &[0, 1], output, |_, error| Err(error), || Ok::<(), ConversionError>(())).unwrap();
}

/// Makes a data set with the name of a format, and returns where it is.
type Maker = fn(&Workplace) -> PathBuf;

fn converted(workplace: &Workplace, format: OutputFormat, name: &str) -> PathBuf {
    convert_emptied(format, &workplace.path(name));
    workplace.path(name)
}

fn emptied_kitti_object(workplace: &Workplace) -> PathBuf {
    let drawn = DrawnDataset::objects(workplace.folder(), 2);
    (0..2).for_each(|number| drawn.write(&format!("training/label_2/{number:06}.txt"), ""));
    drawn.root
}

fn emptied_kitti_tracking(workplace: &Workplace) -> PathBuf {
    let drawn = DrawnDataset::tracking(workplace.folder(), 2);
    drawn.write("training/label_02/0000.txt", "");
    drawn.root
}

fn emptied_kitti_raw(workplace: &Workplace) -> PathBuf {
    kitti_raw(workplace.folder(), &Emptied(street(2)));
    workplace.folder().to_path_buf()
}

fn emptied_nuscenes(workplace: &Workplace) -> PathBuf {
    nuscenes(&workplace.path("trips"), &Emptied(street(2)));
    workplace.path("trips")
}

/// The scans of a drawn drive as `.bin`, each with a label file in which no box stands.
fn scan_folder(workplace: &Workplace) -> PathBuf {
    let drawn = DrawnDataset::objects(workplace.folder(), 2);
    for number in 0..2 {
        let bytes = std::fs::read(drawn.path(&format!("training/velodyne/{number:06}.bin"))).unwrap();
        workplace.write(&format!("drive/{number:06}.bin"), &bytes);
        workplace.write(&format!("drive/labels/{number:06}.json"), "[]");
    }
    workplace.path("drive")
}

const FORMATS: [(&str, Maker); 8] = [
    ("KITTI object", emptied_kitti_object),
    ("KITTI tracking", emptied_kitti_tracking),
    ("KITTI raw", emptied_kitti_raw),
    ("nuScenes", emptied_nuscenes),
    ("scan folder", scan_folder),
    ("MCAP", |it| converted(it, OutputFormat::Mcap, "drive.mcap")),
    ("SemanticKITTI", |it| converted(it, OutputFormat::SemanticKitti, "semantic")),
    ("KITTI with regions", |it| converted(it, OutputFormat::KittiTracking, "regions")),
];

#[test]
fn an_empty_label_is_a_label_in_all_formats() {
    for (name, make) in FORMATS {
        let workplace = Workplace::new();
        let dataset = open(&make(&workplace));
        for scan_idx in 0..2 {
            let scan = dataset.read_scan(scan_idx).unwrap();
            assert!(scan.annotations.is_empty() && scan.is_labeled(), "{name}");
        }
    }
    // No row of the table of annotations is about the third sweep.
    let workplace = Workplace::new();
    copy_folder(&argoverse2::drawn(), &workplace.path("drawn"));
    let sweeps = workplace.path("drawn/sensor/val/drawn-log/sensors/lidar");
    std::fs::copy(sweeps.join("2000.feather"), sweeps.join("3000.feather")).unwrap();
    let scan = open(&workplace.path("drawn")).read_scan(2).unwrap();
    assert!(scan.annotations.is_empty() && scan.is_labeled());
}

#[test]
fn what_nobody_labelled_is_not_labelled() {
    let workplace = Workplace::new();
    let folder = scan_folder(&workplace);
    std::fs::remove_dir_all(folder.join("labels")).unwrap();
    assert!(!open(&folder).read_scan(0).unwrap().is_labeled());
    // A recording of it, too.
    workplace.succeed("data convert drive --to mcap -o again.mcap");
    assert!(!open(&workplace.path("again.mcap")).read_scan(0).unwrap().is_labeled());
}

/// Sums of a column over the scans of a detector and a task.
fn sum(workplace: &Workplace, run: &str, [detector, task, column]: [&str; 3]) -> u64 {
    let rows = workplace.table(&format!("{run}/scans.csv")).into_iter();
    let asked = rows.filter(|it| it["detector"] == detector && it["task"] == task);
    asked.map(|it| it[column].parse::<u64>().unwrap_or_default()).sum()
}

#[test]
fn detections_are_false_where_nothing_stands() {
    for (name, make) in FORMATS {
        let workplace = Workplace::new();
        let path = make(&workplace);
        let run = ["run", path.to_str().unwrap(), "-d", "pca", "-P", "vehicle_model.enabled=false"];
        let ended = workplace.succeed(&(&run, "--no-rrd -o out"));
        ended.check_stderr(&["warning: nothing is annotated in the 2 labelled scans of"]);
        assert!(!workplace.path("out/agreement.csv").exists(), "{name}");
        // Of a folder without objects nobody knows which classes are annotated.
        let has_some = name.starts_with("KITTI ") || name == "nuScenes" || name == "scan folder";
        let task = if has_some { "vehicles" } else { "objects" };
        let n_false = sum(&workplace, "out", ["pca", task, "fo"]);
        assert!(n_false > 0, "{name}: {ended:#?}");
        let said = format!("nothing is annotated that counts; false detections: pca {n_false}.");
        ended.check_stdout(&[&said]);
        let report = workplace.json("out/report.json");
        let value = |metric: &str| {
            let rows = report["rows"].as_array().unwrap();
            let is_asked = |it: &&serde_json::Value| {
                it["metric"] == metric && it["task"] == task && it["slice"] == "all"
            };
            rows.iter().find(is_asked).map(|it| it["value"].clone())
        };
        assert_eq!(value("precision"), Some(0.0.into()), "{name}");
        assert!(value("recall").is_none_or(|it| it.is_null()), "{name}");
    }
}

/// Vehicles of four boxes in each of the scans, which nobody labelled, as KITTI's results have them.
const INVENTED: &str =
    "Car -1 -1 0 0 0 1 1 1.5 1.8 4.2 -2 1.7 12 0 0.9\nCar -1 -1 0 0 0 1 1 1.5 1.8 4.2 4 1.7 20 0 0.9\n";

#[test]
fn invented_vehicles_do_not_pass_a_gate() {
    let workplace = Workplace::new();
    let drawn = DrawnDataset::objects(workplace.folder(), 12);
    let mut blocks = "scan,block\n".to_owned();
    for number in 0..12 {
        drawn.write(&format!("training/label_2/{number:06}.txt"), "");
        blocks.extend([format!("{number},day {number}\n")]);
        write(&workplace.path(&format!("before/{number:06}.txt")), "");
        write(&workplace.path(&format!("after/{number:06}.txt")), INVENTED);
    }
    workplace.write("blocks.csv", &blocks);
    for side in ["before", "after"] {
        let results = format!("net={side}");
        let run = ["run", "street", "-d", "pca", "--detections", &results, "--blocks", "blocks.csv"];
        workplace.succeed(&(&run, ["--no-rrd", "-o", &format!("run-{side}")]));
        // Whoever changes the program runs this before there is a commit of it.
        let path = format!("run-{side}/manifest.json");
        let manifest = workplace.read(&path).replace("\"dirty\": true", "\"dirty\": false");
        workplace.write(&path, &manifest);
    }
    assert_eq!(sum(&workplace, "run-before", ["net", "vehicles", "fo"]), 0);
    assert_eq!(sum(&workplace, "run-after", ["net", "vehicles", "fo"]), 24);
    let gate = "gate run-after -b run-before --allow-drift -o verdict";
    workplace.end_with(gate, 100, &[]).check_stdout(&["FAILED: worse"]);
    let verdict = workplace.json("verdict/gate.json");
    let is_of_net = |it: &&serde_json::Value| it["metric"] == "fo" && it["detector"] == "net";
    let gated = verdict["metrics"].as_array().unwrap().iter().find(is_of_net);
    assert_eq!(gated.expect("false detections are gated")["finding"], "regression", "{verdict:#}");
    workplace.succeed("gate run-after -b run-after").check_stdout(&["PASSED"]);
    workplace.succeed("baseline init run-after -o ci");
    workplace.check_file("ci/tolerances.toml", &["where no annotation counts", "metrics = [\"fo\"]"]);
}
