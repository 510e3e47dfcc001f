//! What other programs found, in every format that it is read in.

use std::path::Path;

use detector::{BoxDetails, DetectedClass, Detection, DetectorOutput, GivenClass};
use evaluation::protocols::official_objects::OfficialScanView;
use reports::vocabulary::class::AnnotationClass;
use scans::conversion::results::result_folder::{ResultFolder, ResultOutput};
use scans::dataset::class_table::ClassTable;
use scans::dataset::foreign_frame::ForeignFrame;
use scans::dataset::{Dataset, DatasetError};
use scans::foreign::detections::{ForeignBox, ForeignDetections};
use scans::foreign::foreign_class::ForeignClass;
use scans::foreign::foreign_results::{ForeignResults, MissingResults, ResultRequest, open_results};

use super::made::{kitti_raw, nuscenes, street, write};
use super::open;
use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

pub fn try_results(
    path: &Path,
    dataset: &dyn Dataset,
    missing: MissingResults,
) -> Result<ForeignResults, DatasetError> {
    let scan_indices: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let classes = &ClassTable::default();
    open_results(path, dataset, &ResultRequest { scan_indices: &scan_indices, classes, missing })
}

/// Opens the results and reads those of all scans.
pub fn read_all(path: &Path, dataset: &dyn Dataset) -> Result<Vec<ForeignDetections>, DatasetError> {
    let mut results = try_results(path, dataset, MissingResults::Refuse)?;
    let read = |scan_idx| Ok(results.read(&dataset.read_scan(scan_idx)?)?.unwrap_or_default());
    (0..dataset.scan_ids().len()).map(read).collect()
}

/// Opening, or else reading, fails with a message that has all of `parts`.
#[track_caller]
pub fn check_refused(path: &Path, dataset: &dyn Dataset, is_usage_error: bool, parts: &[&str]) {
    let error = read_all(path, dataset).expect_err("it has to be refused");
    let message = error.to_string();
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    assert_eq!(error.is_usage_error(), is_usage_error, "{message}");
}

/// By so much the score of a box is more than that of its class.
const OF_BOX: f32 = 16.0;

/// The class that the detector gives.
fn car() -> GivenClass {
    GivenClass::new("car", "car")
}

/// The annotations that have a box, as a detector would find them; the first again, as an unlikely vehicle.
fn echo(dataset: &dyn Dataset, scan_idx: usize) -> (DetectorOutput, Vec<ForeignBox>) {
    let scan = dataset.read_scan(scan_idx).unwrap();
    let (mut output, mut boxes) = (DetectorOutput::default(), Vec::new());
    let boxed = scan.annotations.iter().filter_map(|it| Some((it, it.bounding_box?)));
    for (number, (annotation, bounding_box)) in (0_u8..).zip(boxed) {
        let (class, score) = (DetectedClass::Vehicle, Some(f32::from(number) / 8.0));
        let velocity_m_per_s = Some([f32::from(number) + 1.0, -2.0]);
        let score_of_box = score.map(|it| it + OF_BOX);
        let box_details = BoxDetails { score: score_of_box, velocity_m_per_s, ..BoxDetails::default() };
        let detection = Detection::new(&annotation.point_indices, bounding_box, class, score);
        output.detections.push(Detection { box_details, given: Some(car()), ..detection });
        boxes.push(ForeignBox {
            bounding_box,
            class: Some(AnnotationClass::Car.into()),
            score,
            box_score: box_details.score,
            velocity_m_per_s,
            is_unlikely: false,
        });
    }
    if let Some(&first) = boxes.first() {
        let unlikely = Detection::new(&[], first.bounding_box, DetectedClass::Vehicle, Some(-2.0));
        let box_details = BoxDetails { score: Some(OF_BOX - 2.0), ..BoxDetails::default() };
        output.unlikely.push(Detection { box_details, given: Some(car()), ..unlikely });
        boxes.push(ForeignBox {
            score: unlikely.score,
            box_score: box_details.score,
            velocity_m_per_s: None,
            is_unlikely: true,
            ..first
        });
    }
    (output, boxes)
}

/// Writes the annotations of all scans as results of `echo`.
pub fn write_echo(dataset: &dyn Dataset, output: ResultOutput, folder: &Path) {
    let mut writer = ResultFolder::create(folder, output, false).unwrap();
    writer.begin_dataset(dataset.description());
    for scan_idx in 0..dataset.scan_ids().len() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let frame = dataset.foreign_frame(scan_idx).unwrap();
        writer.add("echo", &scan, &frame, &echo(dataset, scan_idx).0).unwrap();
    }
    writer.end_dataset().unwrap();
    assert_eq!(writer.finish().unwrap(), 0);
}

#[track_caller]
pub fn check_same_boxes(found: &ForeignDetections, expected: &[ForeignBox]) {
    assert_eq!(found.boxes.len(), expected.len());
    for (found, expected) in found.boxes.iter().zip(expected) {
        let (a, b) = (found.bounding_box, expected.bounding_box);
        let class = |it: &ForeignBox| it.class.map(|it| (it.class, it.given.map(GivenClass::name)));
        assert_eq!((class(found), found.score), (class(expected), expected.score));
        assert_eq!((found.box_score, found.is_unlikely), (expected.box_score, expected.is_unlikely));
        let lengths_m = a.center_m.iter().chain(&a.length_width_height_m);
        let pairs = lengths_m.zip(b.center_m.iter().chain(&b.length_width_height_m));
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 2e-4), "{a:?} {b:?}");
        let turn_rad = a.yaw_rad - b.yaw_rad;
        assert!(turn_rad.sin().abs() < 1e-4 && turn_rad.cos() > 0.0, "{a:?} {b:?}");
        let [a, b] = [found, expected].map(|it| it.velocity_m_per_s);
        let is_same = match (a, b) {
            (Some(a), Some(b)) => (0..2).all(|axis| (a[axis] - b[axis]).abs() < 1e-4),
            (a, b) => a == b,
        };
        assert!(is_same, "{a:?} {b:?}");
    }
}

#[track_caller]
fn check_round_trip(dataset: &dyn Dataset, output: ResultOutput) {
    let workplace = Workplace::new();
    let folder = workplace.path("written");
    write_echo(dataset, output, &folder);
    let found = read_all(&folder.join("echo"), dataset).unwrap_or_else(|error| panic!("{error}"));
    for (scan_idx, found) in found.iter().enumerate() {
        let mut expected = echo(dataset, scan_idx).1;
        // Other formats have no velocities.
        expected
            .iter_mut()
            .filter(|_| output != ResultOutput::NuScenes)
            .for_each(|it| it.velocity_m_per_s = None);
        if !matches!(output, ResultOutput::Csv) {
            // For other people's evaluators, which rank boxes.
            let probability = |log_odds: f32| (1.0 / (1.0 + f64::from(-log_odds).exp())) as f32;
            for it in &mut expected {
                it.score = it.box_score.take();
                if output == ResultOutput::NuScenes {
                    it.score = it.score.map(probability);
                }
            }
        }
        check_same_boxes(found, &expected);
    }
}

#[test]
fn velocities_are_the_same_from_a_detector_and_from_its_file() {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(2));
    let dataset = open(workplace.folder());
    write_echo(&*dataset, ResultOutput::NuScenes, &workplace.path("written"));
    let read = read_all(&workplace.path("written/echo"), &*dataset).unwrap();
    for (scan_idx, read) in read.iter().enumerate() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let view = OfficialScanView::new(&*dataset, scan_idx, &scan).unwrap();
        let output = echo(&*dataset, scan_idx).0;
        let (live, from_file) = (view.found(&output, &[]), view.found(&output, &read.official));
        assert_eq!(live.len(), from_file.len());
        for (live, from_file) in live.iter().zip(&from_file) {
            let [live, from_file] = [live, from_file].map(|it| it.velocity_m_per_s.unwrap_or_default());
            assert!((0..2).all(|axis| (live[axis] - from_file[axis]).abs() < 1e-5), "{live:?} {from_file:?}");
        }
        // The car is turned by more than half a radian in the world.
        assert!((live[0].velocity_m_per_s.unwrap()[0] - 1.0).abs() > 0.1);
    }
}

#[test]
fn what_is_written_is_read_back() {
    let workplace = Workplace::new();
    nuscenes(&workplace.path("nuscenes"), &*street(2));
    kitti_raw(&workplace.path("raw"), &*street(2));
    DrawnDataset::tracking(workplace.folder(), 3);
    for name in ["nuscenes", "raw", "street"] {
        check_round_trip(&*open(&workplace.path(name)), ResultOutput::Csv);
    }
    check_round_trip(&*street(2), ResultOutput::Csv);
    check_round_trip(&*open(&workplace.path("nuscenes")), ResultOutput::NuScenes);
    check_round_trip(&*open(&workplace.path("raw")), ResultOutput::Kitti);
    check_round_trip(&*open(&workplace.path("street")), ResultOutput::Kitti);
    check_round_trip(&*open(&super::argoverse2::drawn()), ResultOutput::Argoverse2);
    std::fs::remove_dir_all(workplace.path("street")).unwrap();
    DrawnDataset::objects(workplace.folder(), 3);
    check_round_trip(&*open(&workplace.path("street")), ResultOutput::Kitti);
}

#[test]
fn formats_are_for_the_data_sets_of_their_makers() {
    let workplace = Workplace::with_drive(2);
    let dataset = open(&workplace.path("street"));
    let (scan, frame) = (dataset.read_scan(0).unwrap(), dataset.foreign_frame(0).unwrap());
    for (number, output) in [ResultOutput::NuScenes, ResultOutput::Argoverse2].into_iter().enumerate() {
        let mut writer =
            ResultFolder::create(&workplace.path(&format!("out{number}")), output, false).unwrap();
        writer.begin_dataset(dataset.description());
        let error = writer.add("echo", &scan, &frame, &echo(&*dataset, 0).0).expect_err("another's");
        assert!(error.to_string().contains("its data set has no "), "{error}");
    }
    workplace.write("a.json", "{\"results\": {}}");
    check_refused(
        &workplace.path("a.json"),
        &*dataset,
        true,
        &["tokens of nuScenes", "\"street\" (kitti-tracking) has none"],
    );
    let street = street(1);
    workplace.write("kitti/000000.txt", "");
    check_refused(&workplace.path("kitti"), &*street, true, &["frame of KITTI's camera", "no calibration"]);
    assert_eq!(workplace.top_names(), ["a.json", "kitti", "street"]);
}

#[test]
fn what_lies_at_the_path_says_which_format_it_is() {
    let workplace = Workplace::with_drive(2);
    let dataset = open(&workplace.path("street"));
    let check = |name: &str, parts: &[&str]| check_refused(&workplace.path(name), &*dataset, true, parts);
    workplace.write("none/readme.txt", "");
    check("none", &["has no results in a known format (KITTI's .txt, "]);
    workplace.write("both/0000.txt", "");
    workplace.write("both/000000.u32", "");
    check("both", &["has results in several formats", "KITTI's .txt, scanbench's .csv and .u32"]);
    workplace.write("two/a.json", "");
    workplace.write("two/b.json", "");
    check("two", &["has several files of results", "a.json", "b.json"]);
    let error = read_all(&workplace.path("nowhere"), &*dataset).expect_err("it does not exist");
    assert!(matches!(error, DatasetError::Io { .. }), "{error}");
}

#[test]
fn other_content_is_seen_by_the_checksum() {
    let workplace = Workplace::with_drive(2);
    let dataset = open(&workplace.path("street"));
    let checksum = || {
        let results = try_results(&workplace.path("found"), &*dataset, MissingResults::AreEmpty).unwrap();
        results.checksum().to_owned()
    };
    let bytes = std::fs::read(workplace.path("street/training/velodyne/0000/000000.bin")).unwrap();
    let mut labels = vec![0_u8; bytes.len() / 4];
    workplace.write("found/000000.label", &labels);
    let before = checksum();
    assert_eq!(checksum(), before);
    workplace.write("found/readme.md", "no result");
    workplace.write("found/000077.label", "of no scan that is asked for");
    assert_eq!(checksum(), before);
    // Of the same size.
    labels[2] = 1;
    workplace.write("found/000000.label", &labels);
    assert_ne!(checksum(), before);
}

#[test]
fn scans_without_results_are_named_and_so_are_results_without_scans() {
    let workplace = Workplace::new();
    DrawnDataset::objects(workplace.folder(), 13);
    let dataset = open(&workplace.path("street"));
    for number in [0, 1, 77] {
        workplace.write(&format!("results/{number:06}.txt"), "");
    }
    let path = workplace.path("results");
    check_refused(
        &path,
        &*dataset,
        false,
        &[
            "has no results for 11 of 13 scans of \"street\": training/000002, training/000003, ",
            "training/000011 and 1 more; it has others: 000077.txt; --missing-detections empty",
        ],
    );
    let mut results = try_results(&path, &*dataset, MissingResults::AreEmpty).unwrap();
    let nothing = ForeignDetections { kitti_objects: Some(Vec::new()), ..ForeignDetections::default() };
    assert_eq!(results.read(&dataset.read_scan(1).unwrap()).unwrap(), Some(nothing));
    assert_eq!(results.read(&dataset.read_scan(2).unwrap()).unwrap(), None);
    let warnings = results.warnings();
    assert!(
        warnings[0].ends_with("has results for 1 scans that the data set does not have: 000077.txt"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].ends_with("has no results for 11 scans, which count as nothing found"),
        "{warnings:?}"
    );
}

#[test]
fn a_wrong_frame_is_seen_by_boxes_without_points() {
    let workplace = Workplace::new();
    let street = DrawnDataset::tracking(workplace.folder(), 3);
    let dataset = open(&street.root);
    let labels = std::fs::read_to_string(street.path("training/label_02/0000.txt")).unwrap();
    let read = |text: &str| {
        workplace.write("results/0000.txt", text);
        let mut results = try_results(&workplace.path("results"), &*dataset, MissingResults::Refuse).unwrap();
        for scan_idx in 0..3 {
            let found = results.read(&dataset.read_scan(scan_idx).unwrap()).unwrap().unwrap();
            assert!(found.boxes.len() <= 2);
        }
        results.warnings()
    };
    // The labels themselves are sound results.
    assert_eq!(read(&labels), Vec::<String>::new());
    let elsewhere = read(&labels.replace(" 1.73 ", " -1.73 "));
    assert!(elsewhere[0].contains("6 of 6 boxes nearer than 40 m contain no point"), "{elsewhere:?}");
    let first = labels.lines().find(|it| it.starts_with("1 ")).unwrap();
    let short = read(&format!("{first}\n9{}\n", &first[1..]));
    assert!(short[0].contains("1 scans that the data set does not have: 0000/000009"), "{short:?}");
    assert!(short[1].contains("drive 0000 has results from scan 1 to 9: of 1 others"), "{short:?}");
}

#[test]
fn damage_is_named() {
    let workplace = Workplace::with_drive(1);
    let dataset = open(&workplace.path("street"));
    let car = "0 -1 Car -1 -1 -10 0 0 1 1 1.5 1.8 4.2 1.5 1.73 12 -1.57";
    let check = |name: &str, content: &str, parts: &[&str]| {
        let path = workplace.path("results");
        let _ = std::fs::remove_dir_all(&path);
        write(&path.join(name), content);
        check_refused(&path, &*dataset, false, parts);
    };
    check("0000.txt", &car.replace("4.2", "nan"), &["0000.txt\", line 1: dimensions \"nan\""]);
    check("0000.txt", &car.replace("4.2", "-1"), &["line 1: a box with a side of -1 m"]);
    check(
        "0000.txt",
        &car.replace("4.2", "2000"),
        &["scan 0000/000000: box 1 has sides of [2000.0, 1.8, 1.5] m"],
    );
    check("0000.txt", &car.replace(" 12 ", " 20000 "), &["box 1 has the centre [20000.0, -1.5, "]);
    check("0000.txt", "0 -1 Car", &["line 1: ends before its truncation"]);
    check("000000.u32", "1234567", &["7 bytes are not a multiple of the 4"]);
    check("000000.u32", "12345678", &["has 2 labels, but its scan has "]);
    check("000000.label", "12345678", &["has 2 labels, but its scan has "]);
    check("000000.csv", "point,cluster\n0,1\n", &["has 1 labels, but its scan has "]);
    check("000000.csv", "nothing", &["has neither the columns point,cluster nor those of boxes"]);
    let error = {
        workplace.write(
            "results/000000.csv",
            "class,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\ngoose,1,1,1,1,1,1,1\n",
        );
        read_all(&workplace.path("results"), &*dataset).expect_err("no class")
    };
    assert!(error.is_usage_error() && error.to_string().contains("--class goose=misc"), "{error}");
    // Of two files of boxes neither is the right one.
    let boxes = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\n";
    workplace.write("results/000000.csv", boxes);
    workplace.write("results/000000.boxes.csv", boxes);
    check_refused(&workplace.path("results"), &*dataset, false, &["says the same of the scan as another"]);
}

#[test]
fn what_detect_writes_is_read() {
    let workplace = Workplace::with_drive(2);
    std::fs::create_dir_all(workplace.path("results/0000")).unwrap();
    for number in 0..2 {
        let name = |ending: &str| format!("results/0000/{number:06}.{ending}");
        let scan = format!("0000/{number:06}");
        let seen = ["-P", "vehicle_model.enabled=false", "-P", "boxes.whole=false"];
        let parts = [&["detect", "street", "--scan", &scan], &seen[..]].concat();
        workplace.succeed(&(&parts, ["-o", &name("u32"), "--boxes", &name("csv")]));
    }
    let dataset = open(&workplace.path("street"));
    let found = read_all(&workplace.path("results"), &*dataset).unwrap();
    for (scan_idx, found) in found.iter().enumerate() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let clusters = found.clusters.as_ref().unwrap();
        assert_eq!((clusters.len(), found.boxes.len()), (scan.cloud.len(), 2));
        for (number, it) in (1..).zip(&found.boxes) {
            assert_eq!(it.class, Some(ForeignClass::of("vehicle", AnnotationClass::Car)));
            let points = clusters.iter().zip(scan.cloud.positions_m());
            let points: Vec<[f32; 3]> =
                points.filter(|(cluster, _)| **cluster == number).map(|(_, position_m)| position_m).collect();
            // The box has four decimals.
            let grown = detector::OrientedBox {
                length_width_height_m: it.bounding_box.length_width_height_m.map(|it| it + 0.01),
                ..it.bounding_box
            };
            assert!(points.len() > 20 && points.iter().all(|it| grown.contains(*it)));
        }
    }
}

#[test]
fn instances_of_labels_are_clusters() {
    let workplace = Workplace::new();
    let simulate = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--simulated-scans", "2"];
    workplace.succeed(&(&simulate, "--to semantic-kitti -o drive"));
    let dataset = open(&workplace.path("drive"));
    let of_labels = read_all(&workplace.path("drive"), &*dataset).unwrap();
    for (scan_idx, found) in of_labels.iter().enumerate() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let clusters = found.clusters.as_ref().unwrap();
        for annotation in scan.annotations.iter().filter(|it| it.track.is_some()) {
            let number = annotation.track.unwrap() >> 16;
            let points: Vec<u32> = (0..).zip(clusters).filter(|it| *it.1 == number).map(|it| it.0).collect();
            assert_eq!(points, annotation.point_indices);
            assert_eq!(found.cluster_classes[number as usize - 1], Some(annotation.class.into()));
        }
    }
}

/// A submission of nuScenes with a box for the first sample, as Python writes it.
fn submission(token: &str, translation: &str, velocity: &str, score: &str) -> String {
    format!(
        r#"{{"meta": {{"use_lidar": true}}, "results": {{"{token}": [{{"sample_token": "{token}", "translation": {translation},
        "size": [1.8, 4.2, 1.5], "rotation": [1, 0, 0, 0], "velocity": {velocity}, "detection_name": "car",
        "detection_score": {score}, "attribute_name": ""}}]}}}}"#
    )
}

#[test]
fn a_velocity_that_python_calls_nan_is_unknown_and_nothing_else_may_be() {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(1));
    let dataset = open(workplace.folder());
    let ForeignFrame::World { sample_token, world_from_sensor } = dataset.foreign_frame(0).unwrap() else {
        panic!("samples have tokens")
    };
    let [x, y, z]: [f64; 3] = world_from_sensor.translation.vector.into();
    let here = format!("[{x}, {y}, {z}]");
    let path = workplace.path("results.json");
    let found = |velocity: &str| {
        write(&path, submission(&sample_token, &here, velocity, "0.5"));
        read_all(&path, &*dataset).unwrap().remove(0).official[0].velocity_m_per_s
    };
    assert_eq!(found("[1.5, -2]"), Some([1.5, -2.0]));
    assert!(found("[NaN, NaN]").unwrap().iter().all(|it| it.is_nan()));
    assert_eq!(found("null"), None);
    let named = format!("box 0 of the sample {sample_token:?} has ");
    let check = |translation: &str, velocity: &str, score: &str, problem: &str| {
        write(&path, submission(&sample_token, translation, velocity, score));
        check_refused(&path, &*dataset, false, &[&named, problem]);
    };
    check(&format!("[{x}, NaN, {z}]"), "[0, 0]", "0.5", "NaN in its translation");
    check(&here, "[-Infinity, 0]", "0.5", "-Infinity in its velocity");
    check(&here, "[0, 0]", "NaN", "NaN in its score");
    write(&path, submission(&sample_token, &here, "[0, 0]", "nan"));
    check_refused(&path, &*dataset, false, &["is not a submission of nuScenes"]);
    // Everything else is as before.
    write(&path, submission(&sample_token, &here, "[NaN, NaN]", "0.5"));
    workplace.succeed("run . -d pca --detections deep=results.json --protocol nuscenes --no-rrd -o out");
}

#[test]
fn more_boxes_of_a_sample_than_nuscenes_takes_are_said() {
    let workplace = Workplace::new();
    nuscenes(workplace.folder(), &*street(1));
    let dataset = open(workplace.folder());
    let ForeignFrame::World { sample_token, .. } = dataset.foreign_frame(0).unwrap() else {
        panic!("samples have tokens")
    };
    let path = workplace.path("results.json");
    let warnings = |n: usize| {
        let one = submission(&sample_token, "[1, 2, 3]", "[0, 0]", "0.5");
        let (begin, end) = (one.find("[{").unwrap() + 1, one.rfind('}').unwrap() - 2);
        let boxes = vec![&one[begin..end]; n].join(", ");
        write(&path, format!("{}{boxes}{}", &one[..begin], &one[end..]));
        try_results(&path, &*dataset, MissingResults::Refuse).unwrap().warnings()
    };
    assert_eq!(warnings(500), [""; 0]);
    assert!(warnings(501)[0].contains("1 samples have more than 500 boxes, up to 501: nuScenes refuses"));
}
