//! A small recording, and what is read back of it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::Duration;

use detector::detection::{SeenOfVehicle, SeenSides};
use detector::detector::StageTime;
use detector::stage_product::{LinkFate, ObjectCell, ProductCell, ProductLink, ProductSphere, Shape};
use detector::surface_class::SurfaceClass;
use detector::{BoxDetails, DetectedClass, Detection, Detections, DetectorOutput, OrientedBox, StageProduct};
use evaluation::matching::mistake::{Judged, Mistake, MistakeKind};
use evaluation::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};
use evaluation::metrics::counts::FalseDetections;
use evaluation::run::scan_recorder::Mark;
use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::reason::{FalseReason, MissReason};
use reports::vocabulary::task::Task;
use rerun::external::arrow::array::Array as _;
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::{LogMsg, StoreId};
use rerun::log::Chunk;
use scans::annotation::{Annotation, LabeledScan, ScanId};

use super::super::{Stream, StreamEnding};
use crate::{
    DetectorView, FirstTab, Opening, PointChoice, RecordingTarget, ScanView, StreamError, StreamOptions,
    TaskView, ViewerChoice,
};

pub const N_POINTS: usize = 6;

pub fn unit_box(x_m: f32) -> OrientedBox {
    OrientedBox { center_m: [x_m, 0.0, 0.5], length_width_height_m: [1.0; 3], yaw_rad: 0.3 }
}

pub fn scan(index: u32) -> LabeledScan {
    let annotation = |bounding_box, point_indices| Annotation {
        bounding_box,
        point_indices,
        track: Some(7),
        ..Annotation::of(AnnotationClass::Car)
    };
    LabeledScan::everywhere(
        ScanId { sequence: "0000".to_owned(), index },
        (0..N_POINTS).map(|it| [it as f32, 0.5, 0.5]).collect(),
        vec![annotation(Some(unit_box(0.0)), vec![0]), annotation(None, vec![2, 3])],
    )
}

pub fn output() -> DetectorOutput {
    let detection =
        |point_indices, x_m| Detection::new(point_indices, unit_box(x_m), DetectedClass::Vehicle, Some(0.5));
    let sides = SeenSides { rear: true, ..SeenSides::default() };
    let seen = Some(SeenOfVehicle { sides, is_front_sure: false });
    let partly_seen =
        Detection { box_details: BoxDetails { seen, ..BoxDetails::default() }, ..detection(&[4], 4.0) };
    DetectorOutput {
        detections: [detection(&[0, 1], 0.0), partly_seen].into_iter().collect(),
        stage_times: vec![
            StageTime { stage: "grid", duration: Duration::from_millis(2) },
            StageTime { stage: "boxes", duration: Duration::from_millis(1) },
        ],
        unlikely: Detections::default(),
        dropped_clusters: Vec::new(),
        n_left_uncut: 0,
    }
}

pub fn surfaces() -> Vec<SurfaceClass> {
    use SurfaceClass::{Clutter, Ground, Short, Tall, Unseen};
    vec![Short, Ground, Tall, Clutter, Unseen, Short]
}

pub fn products() -> Vec<StageProduct> {
    let cell = ProductCell { center_m: [0.5; 2], z_range_m: [0.0, 1.0], class: SurfaceClass::Short };
    let object_cell = ObjectCell { center_m: [0.5; 2], z_range_m: [0.0, 1.0], object: 3 };
    let product = |name, shape| StageProduct { stage: "grid", name, shape };
    vec![
        product("first_guess", Shape::LabeledPoints(vec![SurfaceClass::Clutter; N_POINTS])),
        product("point_classes", Shape::LabeledPoints(surfaces())),
        product("clusters", Shape::Clusters(vec![Some(0), Some(0), None, None, Some(9), None])),
        product("cells", Shape::Cells { cell_size_m: 1.0, cells: vec![cell] }),
        product("walls", Shape::Segments(vec![[[0.0; 3], [1.0; 3]]])),
        product("hulls", Shape::Contours(vec![vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])),
        product("boxes", Shape::Boxes(vec![unit_box(0.0)])),
        product(
            "links",
            Shape::Links(vec![ProductLink { ends_m: [[0.0; 3], [1.0; 3]], fate: LinkFate::Cut }]),
        ),
        product("dense", Shape::ObjectCells { cell_size_m: 0.2, cells: vec![object_cell] }),
        product("spheres", Shape::Spheres(vec![ProductSphere { center_m: [0.0; 3], radius_m: 0.5 }])),
    ]
}

/// The first pair matches, the second annotation is missed and the second detection false.
pub fn one_of_each(task: Task) -> Assignment {
    Assignment {
        task,
        criterion: CriterionKind::Points,
        annotations: vec![
            AnnotationOutcome::Matched { detection_idx: 0, cost: 0.1 },
            AnnotationOutcome::Missed(MissReason::Split),
        ],
        detections: vec![
            DetectionOutcome::Matched { annotation_idx: 0, cost: 0.1 },
            DetectionOutcome::False(FalseReason::Fragment),
        ],
        found_tall: Vec::new(),
    }
}

pub fn options(viewer: ViewerChoice) -> StreamOptions {
    let opening = Opening {
        shown_task: Task::Objects,
        first_tab: FirstTab::Compare,
        has_poses: true,
        follows: true,
        figures: &[],
    };
    StreamOptions { name: "test".to_owned(), viewer, opening, points: PointChoice::All }
}

/// Logs `scan` at its index, one metre further on than the one before.
pub fn log_scan(stream: &mut Stream, scan: &LabeledScan) -> Result<(), StreamError> {
    let world_from_sensor = Some(Isometry3::translation(f64::from(scan.id.index), 0.0, 0.0));
    let marks = [Mark { position_m: [2.0, 3.0], text: "worst 1".to_owned(), change: None }];
    let (step, drive_m) = (scan.id.index.into(), &[[0.0; 3], [1.0; 3]]);
    stream.log_scan(&ScanView { scan, step, marks: &marks, world_from_sensor, drive_m })
}

pub fn log_detector(
    stream: &mut Stream,
    scan: &LabeledScan,
    name: &str,
    products: &[StageProduct],
    assignments: &[Assignment],
) -> Result<(), StreamError> {
    let mistake = |kind, of, text: &str| Mistake { kind, of, n_points: 2, text: text.to_owned() };
    let view = |assignment| TaskView {
        assignment,
        false_detections: FalseDetections::Known,
        mistakes: vec![
            mistake(MistakeKind::Missed, Judged::Annotation(1), "split"),
            mistake(MistakeKind::False, Judged::Detection(1), "a part"),
        ],
        f_rate_so_far: (assignment.task == Task::Objects).then_some(0.5),
    };
    let tasks: Vec<TaskView<'_>> = assignments.iter().map(view).collect();
    let view = DetectorView {
        name,
        output: &output(),
        products,
        tasks: &tasks,
        latency: Some(Duration::from_millis(3)),
    };
    stream.log_detector(scan, &view)
}

/// A recording of `n_scans` scans by two detectors; the last scan has no outcomes.
pub fn record(folder: &Path, viewer: ViewerChoice, n_scans: u32) -> Result<StreamEnding, StreamError> {
    let target = RecordingTarget::File(folder.join("run.rrd"));
    record_with(&target, &options(viewer), &["grid", "kd-tree"], n_scans)
}

/// The same by these detectors to `target`.
pub fn record_to(target: &RecordingTarget, detectors: &[&str], n_scans: u32) {
    record_with(target, &options(ViewerChoice::None), detectors, n_scans).unwrap();
}

/// A recording of one detector to a file that is just begun.
pub fn open_file(folder: &Path) -> Stream {
    let target = RecordingTarget::File(folder.join("run.rrd"));
    Stream::open(&target, &options(ViewerChoice::None), &["grid"]).unwrap()
}

fn record_with(
    target: &RecordingTarget,
    options: &StreamOptions,
    detectors: &[&str],
    n_scans: u32,
) -> Result<StreamEnding, StreamError> {
    let mut stream = Stream::open(target, options, detectors)?;
    for index in 0..n_scans {
        let scan = scan(index);
        log_scan(&mut stream, &scan)?;
        let assignments = if index + 1 < n_scans { Task::ALL.map(one_of_each).to_vec() } else { vec![] };
        for name in detectors {
            log_detector(&mut stream, &scan, name, &products(), &assignments)?;
        }
    }
    stream.finish()
}

pub fn messages(file: &Path) -> Vec<LogMsg> {
    let reader = BufReader::new(File::open(file).unwrap());
    DecoderApp::decode_eager(reader).unwrap().map(Result::unwrap).collect()
}

/// The chunks of the recording itself, without those of the blueprint.
pub fn chunks(file: &Path) -> Vec<Chunk> {
    chunks_of(file, StoreId::is_recording)
}

/// The chunks of the blueprint.
pub fn chunks_of_blueprint(file: &Path) -> Vec<Chunk> {
    chunks_of(file, StoreId::is_blueprint)
}

fn chunks_of(file: &Path, is_wanted: fn(&StoreId) -> bool) -> Vec<Chunk> {
    let wanted = messages(file).into_iter().filter_map(|message| match message {
        LogMsg::ArrowMsg(store, message) if is_wanted(&store) => Some(message),
        _ => None,
    });
    wanted.map(|message| Chunk::from_arrow_msg(&message).unwrap()).collect()
}

/// How often each component of each entity was logged, as `entity component`.
pub fn n_logged(file: &Path) -> BTreeMap<String, usize> {
    let mut n_logged = BTreeMap::new();
    for chunk in chunks(file) {
        for descriptor in chunk.component_descriptors() {
            let rows = chunk.components().get_array(descriptor.component).unwrap();
            let name = format!("{} {}", chunk.entity_path(), descriptor.component);
            *n_logged.entry(name).or_default() += rows.len() - rows.null_count();
        }
    }
    n_logged
}
