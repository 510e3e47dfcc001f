//! Content of a recording, read back as a viewer would read it.

use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::Path;
use std::time::{Duration, Instant};

use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::{PointCloud, StageProduct};
use evaluation::matching::outcome::Assignment;
use evaluation::run::scan_recorder::Mark;
use reports::vocabulary::task::Task;
use rerun::ComponentIdentifier;
use rerun::external::arrow::array::{Array as _, AsArray as _};
use rerun::external::arrow::datatypes::UInt32Type;
use rerun::external::re_log_types::LogMsg;

use self::drawn_recording::{
    N_POINTS, chunks, chunks_of_blueprint, log_detector, log_scan, messages, n_logged, one_of_each,
    open_file, options, products, record, record_to, scan, surfaces,
};
use super::*;
use crate::marks_layer::write_marks;
use crate::recording_layout::KeptLayout;
use crate::{ViewerChoice, entity_paths, legend, palette};

mod drawn_recording;

#[track_caller]
fn check_n_logged(expected: &[(&str, usize)]) {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 3).unwrap();
    let n_logged = n_logged(&folder.path().join("run.rrd"));
    for (name, expected_n) in expected {
        assert_eq!(n_logged.get(*name), Some(expected_n), "{name} in {n_logged:#?}");
    }
}

#[test]
fn points_are_logged_once_a_scan_and_labelled_once_a_detector() {
    check_n_logged(&[
        ("/world/sensor/scan/points Points3D:positions", 3),
        ("/world/sensor/scan/points Points3D:colors", 3),
        ("/world/sensor/scan/points grid:grid:point_classes:colors", 3),
        ("/world/sensor/scan/points grid:grid:clusters:colors", 3),
        ("/world/sensor/scan/points grid:grid:first_guess:colors", 3),
        ("/world/sensor/scan/points kd-tree:grid:point_classes:colors", 3),
        ("/world/sensor/scan/points kd-tree:grid:clusters:colors", 3),
        ("/world/sensor/scan/annotations Boxes3D:half_sizes", 3),
    ]);
}

#[test]
fn every_product_that_is_no_label_has_an_entity() {
    check_n_logged(&[
        ("/world/sensor/detectors/kd-tree/cells/grid/cells/short\\ object Boxes3D:half_sizes", 3),
        ("/world/sensor/detectors/kd-tree/segments/grid/walls LineStrips3D:strips", 3),
        ("/world/sensor/detectors/kd-tree/contours/grid/hulls LineStrips3D:strips", 3),
        ("/world/sensor/detectors/kd-tree/boxes/grid/boxes Boxes3D:half_sizes", 3),
        ("/world/sensor/detectors/kd-tree/links/grid/links/link\\ cut LineStrips3D:strips", 3),
        ("/world/sensor/detectors/kd-tree/object_cells/grid/dense Boxes3D:half_sizes", 3),
        ("/world/sensor/detectors/kd-tree/scores/vehicle Boxes3D:labels", 3),
        ("/world/sensor/detectors/kd-tree/spheres/grid/spheres Ellipsoids3D:half_sizes", 3),
    ]);
}

#[test]
fn outcomes_that_a_scan_no_longer_has_are_cleared() {
    check_n_logged(&[
        ("/world/sensor/detectors/grid/outcomes/objects/matched LineStrips3D:strips", 2),
        ("/world/sensor/detectors/grid/outcomes/objects/matched Clear:is_recursive", 1),
        ("/world/sensor/detectors/grid/outcomes/objects/missed LineStrips3D:strips", 2),
        // The seen sides of the false detection are known.
        ("/world/sensor/detectors/grid/outcomes/vehicles/missed Clear:is_recursive", 1),
    ]);
}

#[test]
fn series_have_a_name_once_and_a_value_per_scan() {
    check_n_logged(&[
        ("/series/f_rate/objects/grid SeriesLines:names", 1),
        // The last scan is judged for no task.
        ("/series/f_rate/objects/grid Scalars:scalars", 2),
        ("/series/latency_ms/grid Scalars:scalars", 3),
        ("/series/stage_ms/grid SeriesLines:names", 1),
        ("/series/stage_ms/grid Scalars:scalars", 3),
        ("/world AnnotationContext:context", 1),
    ]);
}

#[test]
fn an_undefined_f_rate_has_no_value() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 2).unwrap();
    let n_logged = n_logged(&folder.path().join("run.rrd"));
    assert_eq!(n_logged.get("/series/f_rate/vehicles/grid Scalars:scalars"), None);
}

#[test]
fn the_only_timeline_is_the_number_of_the_scan() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 1).unwrap();
    let chunks = chunks(&folder.path().join("run.rrd"));
    let timelines: BTreeSet<&str> =
        chunks.iter().flat_map(|chunk| chunk.timelines().keys().map(rerun::TimelineName::as_str)).collect();
    assert_eq!(timelines, BTreeSet::from([entity_paths::SCAN_TIMELINE]));
}

#[test]
fn the_blueprint_is_sent_and_made_active() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 1).unwrap();
    let messages = messages(&folder.path().join("run.rrd"));
    let n_activations = messages
        .iter()
        .filter(|it| matches!(it, LogMsg::BlueprintActivationCommand(command) if command.make_active))
        .count();
    assert_eq!(n_activations, 1);
}

#[test]
fn poses_marks_counts_and_mistakes_are_logged_scan_by_scan() {
    check_n_logged(&[
        ("/world/sensor Transform3D:translation", 3),
        ("/world/drive LineStrips3D:strips", 3),
        ("/world/sensor/scan/marks Arrows3D:labels", 3),
        // The last scan is judged for no task; each other one has two mistakes.
        ("/mistakes/grid/objects TextLog:text", 4),
        ("/mistakes/kd-tree/vehicles TextLog:text", 4),
        ("/mistakes_of_scan/grid/objects TextDocument:text", 2),
        ("/series/counts/grid/objects/found Scalars:scalars", 2),
        ("/series/counts/grid/objects/missed Scalars:scalars", 2),
        ("/series/counts/kd-tree/vehicles/false Scalars:scalars", 2),
    ]);
}

#[test]
fn fewer_points_are_drawn_than_there_are_if_so_asked() {
    let folder = tempfile::tempdir().unwrap();
    let options = StreamOptions { points: PointChoice::AtMost(2), ..options(ViewerChoice::None) };
    let file = folder.path().join("run.rrd");
    let mut stream = Stream::open(&RecordingTarget::File(file.clone()), &options, &["grid"]).unwrap();
    let scan = scan(0);
    log_scan(&mut stream, &scan).unwrap();
    log_detector(&mut stream, &scan, "grid", &products(), &[]).unwrap();
    stream.finish().unwrap();
    let chunks = chunks(&file);
    let n_rows = |component: ComponentIdentifier| {
        let logged = chunks.iter().find_map(|chunk| chunk.components().get_array(component)).unwrap();
        logged.value(0).len()
    };
    assert_eq!(n_rows(re_sdk_types::archetypes::Points3D::descriptor_positions().component), 2);
    assert_eq!(n_rows(entity_paths::point_colors("grid", "grid", "clusters")), 2);
    let title = chunks.iter().find(|it| it.entity_path() == &entity_paths::LEGEND_SCAN.into()).unwrap();
    assert!(format!("{title}").contains("2 of 6 points drawn"), "{title}");
}

#[test]
fn points_that_cannot_be_drawn_take_their_labels_along() {
    let folder = tempfile::tempdir().unwrap();
    let mut stream = open_file(folder.path());
    let mut scan = scan(0);
    let with_holes = |it: usize| if it == 1 || it == 4 { f32::NAN } else { it as f32 };
    scan.cloud = (0..N_POINTS).map(|it| [with_holes(it), 0.0, 0.0]).collect::<PointCloud>();
    log_scan(&mut stream, &scan).unwrap();
    log_detector(&mut stream, &scan, "grid", &products(), &[]).unwrap();
    stream.finish().unwrap();

    let chunks = chunks(&folder.path().join("run.rrd"));
    let column = |name: ComponentIdentifier| {
        let column = chunks.iter().find_map(|chunk| chunk.components().get_array(name)).unwrap();
        column.value(0)
    };
    let surfaces = [0, 2, 3, 5].map(|it| surfaces()[it]);
    let rgba = |it: palette::Rgb| legend::rgba(it).to_u32();
    let colors = |product: &str| {
        let column = column(entity_paths::point_colors("grid", "grid", product));
        column.as_primitive::<UInt32Type>().values().to_vec()
    };
    assert_eq!(colors("point_classes"), surfaces.map(palette::surface_color).map(rgba));
    let none = palette::surface_color(SurfaceClass::Unseen);
    assert_eq!(colors("clusters"), [palette::cluster_color(0), none, none, none].map(rgba));
}

#[test]
fn views_take_the_colours_of_points() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 1).unwrap();
    let component = ComponentIdentifier::try_new("VisualizerInstruction:component_map").unwrap();
    let blueprint = chunks_of_blueprint(&folder.path().join("run.rrd"));
    let mappings = blueprint.iter().filter_map(|it| it.components().get_array(component));
    let mappings: Vec<String> = mappings.map(|it| format!("{it:?}")).collect();
    for detector in ["grid", "kd-tree"] {
        for product in ["point_classes", "clusters"] {
            let column = format!("\"{detector}:grid:{product}:colors\"");
            let of_column: Vec<&String> = mappings.iter().filter(|it| it.contains(&column)).collect();
            let is_right = |it: &&String| it.contains("Points3D:colors");
            assert!(!of_column.is_empty() && of_column.iter().all(is_right), "{column}: {mappings:#?}");
        }
    }
}

#[track_caller]
fn check_refused(name: &str, products: &[StageProduct], assignments: &[Assignment], expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut stream = open_file(folder.path());
    let scan = scan(0);
    log_scan(&mut stream, &scan).unwrap();
    let refused = log_detector(&mut stream, &scan, name, products, assignments).unwrap_err();
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn what_is_not_of_this_scan_is_refused() {
    check_refused("pca", &[], &[], r#"detector "pca" was not announced; announced are ["grid"]"#);
    let short =
        StageProduct { stage: "grid", name: "clusters", shape: Shape::Clusters(vec![None; N_POINTS - 1]) };
    check_refused("grid", &[short], &[], "clusters of grid has 5 labels, but the scan has 6 points");
    let mut assignment = one_of_each(Task::Objects);
    assignment.annotations.pop();
    check_refused(
        "grid",
        &[],
        &[assignment],
        "an assignment of grid has 1 annotations and 2 detections, but the scan has 2 and 2",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let device = RecordingTarget::Device("/dev/full".into());
    let refused = Stream::open(&device, &options(ViewerChoice::None), &["grid"]).map(|_| ()).unwrap_err();
    assert!(matches!(refused, StreamError::Write { .. }), "{refused}");
    assert!(refused.to_string().contains("No space left"), "{refused}");
}

#[test]
fn a_folder_that_is_not_there_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let refused = record(&folder.path().join("missing"), ViewerChoice::None, 1).unwrap_err();
    assert!(matches!(refused, StreamError::Create { .. }), "{refused}");
}

/// Records with a viewer at `url` and expects a complete file all the same.
#[track_caller]
fn check_viewer_is_lost(url: &str, within: Duration) {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let ending = record(folder.path(), ViewerChoice::Connect(url.parse().unwrap()), 3).unwrap();
    assert!(matches!(ending.viewer, ViewerState::Lost { .. }), "{ending:?}");
    assert!(started.elapsed() < within, "{:?}", started.elapsed());
    let n_logged = n_logged(&folder.path().join("run.rrd"));
    assert_eq!(n_logged["/world/sensor/scan/points Points3D:positions"], 3);
}

#[test]
fn a_viewer_that_is_not_there_costs_neither_time_nor_the_file() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    check_viewer_is_lost(&format!("rerun+http://127.0.0.1:{port}/proxy"), Duration::from_secs(2));
}

#[test]
fn a_recording_is_served_until_its_handle_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let ending = record(folder.path(), ViewerChoice::Serve { port: 0 }, 3).unwrap();
    let served = ending.served.expect("it is served");
    assert_eq!(ending.viewer, ViewerState::Connected);
    let n_logged = n_logged(&folder.path().join("run.rrd"));
    assert_eq!(n_logged["/world/sensor/scan/points Points3D:positions"], 3);

    let address = served.url.trim_start_matches("rerun+http://").trim_end_matches("/proxy").to_owned();
    assert!(std::net::TcpStream::connect(&address).is_ok(), "nobody listens at {address}");
    drop(served);
    let started = Instant::now();
    while std::net::TcpStream::connect(&address).is_ok() {
        assert!(started.elapsed() < Duration::from_secs(5), "the server outlives its handle");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_port_that_is_taken_is_an_error() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let folder = tempfile::tempdir().unwrap();
    let refused = record(folder.path(), ViewerChoice::Serve { port }, 1).unwrap_err();
    assert!(matches!(refused, StreamError::Serve { .. }), "{refused}");
}

#[test]
fn a_viewer_that_never_answers_does_not_cost_the_file() {
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = silent.local_addr().unwrap().port();
    check_viewer_is_lost(&format!("rerun+http://127.0.0.1:{port}/proxy"), Duration::from_secs(30));
}

#[test]
fn layers_hold_what_one_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), ViewerChoice::None, 3).unwrap();
    let whole = n_logged(&folder.path().join("run.rrd"));
    let layers = folder.path().join("recording");
    record_to(&layers_in(&layers, None), &["grid", "kd-tree"], 3);
    let mut of_layers = BTreeMap::new();
    for name in ["scans", "detector-grid", "detector-kd-tree"] {
        let of_layer = n_logged(&layers.join(format!("{name}.rrd")));
        assert!(of_layer.keys().all(|it| !of_layers.contains_key(it)), "{name}: {of_layer:#?}");
        of_layers.extend(of_layer);
    }
    assert_eq!(of_layers, whole);
    // No view, but where the time is at first.
    for layer in ["scans", "detector-grid"] {
        let blueprint = chunks_of_blueprint(&layers.join(format!("{layer}.rrd")));
        let entities: BTreeSet<String> = blueprint.iter().map(|it| it.entity_path().to_string()).collect();
        assert!(
            entities.contains("/time_panel") && !entities.iter().any(|it| it.contains("/view/")),
            "{entities:?}"
        );
    }
    assert_eq!(stores(&layers).len(), 1);
}

#[test]
fn a_detector_joins_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let [first, joined] = ["first", "joined"].map(|it| folder.path().join(it));
    record_to(&layers_in(&first, None), &["grid"], 3);
    record_to(&layers_in(&joined, Some(&first)), &["kd-tree"], 3);
    let names = |layers: &Path| -> BTreeSet<String> {
        let entries = std::fs::read_dir(layers).unwrap();
        entries.map(|it| it.unwrap().file_name().into_string().unwrap()).collect()
    };
    assert_eq!(names(&joined), ["detector-kd-tree.rrd", "layout.rrd"].map(str::to_owned).into());
    assert_eq!(stores(&first), stores(&joined));
    let layout = chunks_of_blueprint(&joined.join("layout.rrd"));
    let drawn: Vec<String> = layout.iter().map(|it| format!("{:?}", it.components())).collect();
    for detector in ["grid", "kd-tree"] {
        let column = format!("{detector}:grid:clusters:colors");
        assert!(drawn.iter().any(|it| it.contains(&column)), "{column}");
    }
    // A third one sees both.
    record_to(&layers_in(&folder.path().join("again"), Some(&joined)), &["pca"], 1);
    let kept = KeptLayout::read(&folder.path().join("again/layout.rrd")).unwrap();
    assert_eq!(kept.detectors.iter().map(|it| &it.detector).collect::<Vec<_>>(), ["grid", "kd-tree", "pca"]);
}

#[test]
fn a_recording_without_layout_is_not_joined() {
    let folder = tempfile::tempdir().unwrap();
    let target = layers_in(&folder.path().join("joined"), Some(folder.path()));
    let refused = Stream::open(&target, &options(ViewerChoice::None), &["grid"]).map(|_| ()).unwrap_err();
    assert!(matches!(refused, StreamError::NoLayout { .. }), "{refused}");
}

fn layers_in(folder: &Path, joins: Option<&Path>) -> RecordingTarget {
    RecordingTarget::Layers { folder: folder.to_owned(), joins: joins.map(Path::to_owned) }
}

/// Ids of the recordings whose layers are in `folder`.
fn stores(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let all = entries.flat_map(|it| messages(&it.unwrap().path()));
    all.filter(|it| it.store_id().is_recording()).map(|it| format!("{:?}", it.store_id())).collect()
}

#[test]
fn pointers_join_a_recording_for_the_scans_that_have_some() {
    let folder = tempfile::tempdir().unwrap();
    let layers = folder.path().join("recording");
    record_to(&layers_in(&layers, None), &["grid"], 4);
    let mark = |text: &str| Mark { position_m: [1.0, 2.0], text: text.to_owned(), change: None };
    let of_scans =
        BTreeMap::from([(0, vec![mark("a"), mark("b")]), (1, vec![mark("c")]), (3, vec![mark("d")])]);
    write_marks(&layers, &BTreeMap::from([("grid".to_owned(), of_scans)])).unwrap();
    let n_logged = n_logged(&layers.join("marks.rrd"));
    assert_eq!(n_logged["/world/sensor/detectors/grid/marks Arrows3D:labels"], 3);
    // After the second and after the last.
    assert_eq!(n_logged["/world/sensor/detectors/grid/marks Clear:is_recursive"], 2);
    assert_eq!(stores(&layers).len(), 1);
}
