//! How long protocols of others take at the size of nuScenes' validation set: 6,019 scans with 30 labels and 500 boxes each,
//! in 150 drives, made up. One core.
//!
//! `cargo bench -p evaluation --bench protocols` prints seconds for matching, for the numbers and for their intervals, and
//! the most memory that was held; it fails if matching and numbers take more than 20 s, or memory is more than 1 GB.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::process::ExitCode;
use std::time::Instant;

use detector::{DetectorOutput, OrientedBox, PointCloud};
use evaluation::protocols::PROTOCOLS;
use evaluation::protocols::official_objects::OfficialScanView;
use evaluation::protocols::official_protocol::{FoundInScan, OfficialProtocol};
use nalgebra::{Isometry3, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::numbers::tally::Tally;
use reports::protocols::drawn_scans::{DrawnScans, N_PROTOCOL_RESAMPLES};
use reports::protocols::protocol_tally::{ProtocolQuestion, ProtocolTally};
use reports::protocols::under_protocol::DrawnValues;
use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::{ScanOutcome, ScanRow};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::extent::OVERALL;
use reports::vocabulary::protocol::Protocol;
use reports::vocabulary::task::Task;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::dataset::official::OfficialObject;

const N_SCANS: u32 = 6_019;
const N_DRIVES: u32 = 150;
const N_LABELS: usize = 30;
const N_BOXES: usize = 500;
const MOST_SECONDS: f64 = 20.0;
const MOST_BYTES: u64 = 1_000_000_000;
const CLASSES: [AnnotationClass; 5] = [
    AnnotationClass::Car,
    AnnotationClass::Truck,
    AnnotationClass::Bus,
    AnnotationClass::Pedestrian,
    AnnotationClass::Cyclist,
];

fn main() -> ExitCode {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("nothing was in parallel before");
    println!("{N_SCANS} scans with {N_LABELS} labels and {N_BOXES} boxes each");
    let mut is_fast = true;
    // KITTI's has a benchmark of its own.
    for protocol in PROTOCOLS.iter().filter(|it| it.protocol() != Protocol::KittiObject) {
        let seconds = measure(*protocol);
        is_fast &= seconds <= MOST_SECONDS;
    }
    let most = most_bytes();
    println!("most memory: {:.0} MB", most as f64 / 1e6);
    if is_fast && most <= MOST_BYTES { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Prints the times of a protocol, and returns that of matching and numbers together.
fn measure(protocol: &dyn OfficialProtocol) -> f64 {
    let (mut tally, mut rows) = (Tally::default(), ProtocolTally::default());
    let mut matching_s = 0.0;
    for scan in 0..N_SCANS {
        let (labelled, objects) = drawn(scan);
        let name = ScanName { dataset: "drawn".to_owned(), sequence: labelled.id.sequence.clone(), scan };
        tally.add_scan(&scan_row(&name));
        let started = Instant::now();
        let view = OfficialScanView::of_annotations(&labelled);
        let found = FoundInScan {
            name,
            detector: "drawn",
            view: &view,
            output: &DetectorOutput::default(),
            objects: &objects,
            kitti_objects: None,
        };
        rows.add(&protocol.rows(&found));
        matching_s += started.elapsed().as_secs_f64();
    }
    let scans = DrawnScans::of(&tally, OVERALL);
    let started = Instant::now();
    let question = ProtocolQuestion { protocol: protocol.protocol(), detector: "drawn" };
    let under = rows.rows(question, &scans).expect("rows were added");
    let values = under.values(&vec![1; scans.names().len()]);
    let numbers_s = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let drawn = DrawnValues::new(&*under, &scans);
    let intervals_s = started.elapsed().as_secs_f64();
    assert!(drawn.values == values && !values.is_empty(), "the same scans have the same numbers");
    println!(
        "{:<12} matching {matching_s:>6.1} s, numbers {numbers_s:>6.2} s, intervals of {N_PROTOCOL_RESAMPLES} draws {intervals_s:>6.1} s",
        protocol.protocol().name()
    );
    matching_s + numbers_s
}

fn scan_row(name: &ScanName) -> ScanRow {
    ScanRow {
        dataset: name.dataset.clone(),
        sequence: name.sequence.clone(),
        scan: name.scan,
        time_s: Some(f64::from(name.scan) / 2.0),
        detector: "drawn".to_owned(),
        task: Task::Vehicles,
        outcome: ScanOutcome::Skipped { reason: "it is drawn".to_owned() },
    }
}

/// Labels, and boxes of which some are near them.
fn drawn(scan: u32) -> (LabeledScan, Vec<OfficialObject>) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    rng.set_stream(scan.into());
    let mut annotations = Vec::new();
    let mut objects = Vec::new();
    for index in 0..N_BOXES {
        let class = CLASSES[rng.random_range(0..CLASSES.len())];
        let at_m: [f32; 2] = [rng.random_range(-38.0..38.0), rng.random_range(-38.0..38.0)];
        if index < N_LABELS {
            annotations.push(annotation(class, at_m));
        }
        let moved = Vector3::new(rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0), 0.0);
        let at = Vector3::new(f64::from(at_m[0]), f64::from(at_m[1]), 0.0) + moved;
        let pose = Isometry3::new(at, Vector3::z() * rng.random_range(-3.0..3.0));
        let score = Some(rng.random_range(0.0..1.0) * if index < N_LABELS { 1.0 } else { 0.5 });
        objects.push(OfficialObject { score, ..OfficialObject::new(class.name(), &pose, [4.0, 2.0, 1.5]) });
    }
    let id = ScanId { sequence: format!("{:04}", scan * N_DRIVES / N_SCANS), index: scan };
    (LabeledScan::everywhere(id, PointCloud::default(), annotations), objects)
}

fn annotation(class: AnnotationClass, [x_m, y_m]: [f32; 2]) -> Annotation {
    let bounding_box =
        OrientedBox { center_m: [x_m, y_m, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.3 };
    Annotation { bounding_box: Some(bounding_box), point_indices: vec![0], ..Annotation::of(class) }
}

/// The most memory that this process ever held; 0 where the system does not report it.
fn most_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|it| it.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|it| it.trim().trim_end_matches(" kB").trim().parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}
