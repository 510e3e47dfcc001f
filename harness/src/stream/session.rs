//! A recording from its first scan to its last.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use detector::{DetectorOutput, StageProduct};
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{Clear, EntityPath, RecordingStream, RecordingStreamBuilder};

use super::blueprint::send_blueprint;
use super::error::StreamError;
use super::log_outcomes::log_outcomes;
use super::log_products::log_products;
use super::log_scan::{log_scan, log_title};
use super::log_series::{RunningFRate, log_f_rates, log_further, log_latency, log_lines, log_stage_times};
use super::log_static::log_static;
use super::recording;
use super::recording_axis::RecordingAxis;
use super::recording_file::RecordingFile;
use super::viewer::{ViewerChoice, ViewerLink, ViewerState};
use crate::annotation::LabeledScan;
use crate::matching::outcome::Assignment;
use crate::task::Task;

const APPLICATION_ID: &str = "scanbench";

/// Where a recording goes and how it opens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamOptions {
    /// The name of the recording in the viewer.
    pub name: String,
    /// The file, always written; one that exists is overwritten.
    pub file: PathBuf,
    /// A viewer that gets the same at the same time.
    pub viewer: ViewerChoice,
    /// The task whose outcomes are visible at first.
    pub shown_task: Task,
}

/// What one detector made of one scan.
#[derive(Debug, Clone, Copy)]
pub struct DetectorView<'a> {
    /// Its name, as announced to [`Stream::open`].
    pub name: &'a str,
    /// What it reports.
    pub output: &'a DetectorOutput,
    /// What its stages left behind.
    pub products: &'a [StageProduct],
    /// What became of every annotation and detection, for each task.
    pub assignments: &'a [Assignment],
    /// F-rates over the scans so far, for each task.
    pub f_rates_so_far: &'a [RunningFRate],
    /// Time of the whole detection.
    pub latency: Duration,
}

/// How a recording ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamEnding {
    /// Size of the file.
    pub file_n_bytes: u64,
    /// Whether the viewer got everything.
    pub viewer: ViewerState,
}

/// An open recording.
///
/// [`Self::finish`] tells whether everything was written; a stream that is only dropped may leave a file without its end.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Stream {
    recording: RecordingStream,
    file: RecordingFile,
    viewer: ViewerLink,
    path: PathBuf,
    detectors: Vec<DetectorState>,
    axis: RecordingAxis,
}

/// What has to be remembered of a detector from scan to scan.
struct DetectorState {
    name: String,
    on_screen: BTreeSet<EntityPath>,
    stages: Vec<&'static str>,
}

impl Stream {
    /// Creates the file, connects to the viewer if there is to be one, and sends what holds for the whole recording.
    ///
    /// `detectors` are the names of all that will log, in the order in which they are shown. A viewer that does not
    /// answer is no error: see [`Self::viewer_state`].
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the file cannot be written or a viewer has to be started and cannot be.
    pub fn open(options: &StreamOptions, detectors: &[&str]) -> Result<Self, StreamError> {
        Self::open_along(options, detectors, RecordingAxis::scans())
    }

    /// The same for a recording over something else than scans.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_along(
        options: &StreamOptions,
        detectors: &[&str],
        axis: RecordingAxis,
    ) -> Result<Self, StreamError> {
        // Rerun's own answer to this variable would be an empty file.
        if !rerun::decide_logging_enabled(true) {
            return Err(StreamError::SwitchedOff);
        }
        let file = RecordingFile::create(&options.file)?;
        let viewer = ViewerLink::open(&options.viewer)?;
        let mut sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        if viewer.state() != ViewerState::None {
            sinks.push(Box::new(viewer.clone()));
        }
        let recording = RecordingStreamBuilder::new(APPLICATION_ID)
            .recording_name(&*options.name)
            .batcher_config(batching())
            .set_sinks(sinks)
            .map_err(|error| StreamError::Log {
                entity: "the recording".to_owned(),
                reason: error.to_string(),
            })?;
        recording.set_log_tick_enabled(false);
        recording.set_log_time_enabled(false);

        let names: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        send_blueprint(&recording, APPLICATION_ID, &names, options.shown_task, &axis)?;
        log_static(&recording)?;
        for (detector_idx, name) in names.iter().enumerate() {
            log_lines(&recording, name, detector_idx)?;
        }
        let detectors = names
            .into_iter()
            .map(|name| DetectorState { name, on_screen: BTreeSet::new(), stages: Vec::new() })
            .collect();
        Ok(Self { recording, file, viewer, path: options.file.clone(), detectors, axis })
    }

    /// How the viewer does; one that was lost is worth a warning.
    pub fn viewer_state(&self) -> ViewerState {
        self.viewer.state()
    }

    /// Logs points and annotations of `scan`, the one with this number within the run.
    ///
    /// Whatever is logged afterwards belongs to it, until the next call. Call it from the thread that logs the detectors,
    /// and outside every stopwatch: what was logged before is written now, so that nothing of the recording runs beside a
    /// detector. (A viewer is sent to beside it, and shares the processor with it if it runs on the same machine.)
    ///
    /// # Errors
    ///
    /// [`StreamError`] if Rerun refuses, or if an earlier scan could not be written.
    pub fn log_scan(&mut self, scan_number: u32, scan: &LabeledScan) -> Result<(), StreamError> {
        self.flush()?;
        self.set_step(scan_number.into())?;
        log_scan(&self.recording, scan)
    }

    /// Logs points and annotations of `scan`, the only one of a recording over something else, from `step` on.
    ///
    /// # Errors
    ///
    /// As [`Self::log_scan`].
    pub fn log_first(&mut self, step: i64, scan: &LabeledScan) -> Result<(), StreamError> {
        self.set_step(step)?;
        log_scan(&self.recording, scan)
    }

    /// Goes on to another place on the axis, and writes `title` where the scan is named; the scan stays. Its `further` series
    /// have these values there; one that is undefined leaves a gap.
    ///
    /// # Errors
    ///
    /// As [`Self::log_scan`].
    pub fn log_step(
        &mut self,
        step: i64,
        title: String,
        further: &[(&'static str, Option<f64>)],
    ) -> Result<(), StreamError> {
        self.flush()?;
        self.set_step(step)?;
        log_title(&self.recording, title)?;
        log_further(&self.recording, further)
    }

    /// Logs what a detector made of `scan`, which is the one that was logged last.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the detector was not announced, if a product or an assignment is not of this scan, or if
    /// Rerun refuses.
    pub fn log_detector(&mut self, scan: &LabeledScan, view: &DetectorView<'_>) -> Result<(), StreamError> {
        let Some(detector_idx) = self.detectors.iter().position(|it| it.name == view.name) else {
            return Err(StreamError::UnknownDetector {
                detector: view.name.to_owned(),
                announced: self.detectors.iter().map(|it| it.name.clone()).collect(),
            });
        };
        let state = &mut self.detectors[detector_idx];
        let stream = &self.recording;
        let mut on_screen = log_products(stream, &scan.cloud, view.name, view.products)?;
        for assignment in view.assignments {
            on_screen.extend(log_outcomes(stream, scan, view.name, &view.output.detections, assignment)?);
        }
        // What the previous scan had and this one has not would stay otherwise.
        for path in state.on_screen.difference(&on_screen) {
            recording::log(stream, path.clone(), &Clear::flat())?;
        }
        state.on_screen = on_screen;
        log_f_rates(stream, view.name, view.f_rates_so_far)?;
        log_latency(stream, view.name, view.latency)?;
        log_stage_times(stream, view.name, &view.output.stage_times, &mut state.stages)
    }

    /// Writes the end of the file and waits, within limits, until the viewer has everything.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if the file is not complete.
    pub fn finish(self) -> Result<StreamEnding, StreamError> {
        self.flush()?;
        self.file.finish()?;
        let viewer = self.viewer.finish();
        let file_n_bytes = file_size(&self.path)?;
        Ok(StreamEnding { file_n_bytes, viewer })
    }

    fn set_step(&self, step: i64) -> Result<(), StreamError> {
        let timeline = rerun::TimelineName::try_new(&*self.axis.timeline).map_err(|error| {
            StreamError::Log { entity: self.axis.timeline.clone(), reason: error.to_string() }
        })?;
        self.recording.set_time_sequence(timeline, step);
        Ok(())
    }

    /// Lets Rerun write what it holds back, so that memory stays flat and a full disk is noticed.
    fn flush(&self) -> Result<(), StreamError> {
        // Whatever the flush says is known better to the file.
        let flushed = self.recording.flush_blocking();
        self.file.check()?;
        flushed.map_err(|error| StreamError::Write { path: self.path.clone(), reason: error.to_string() })
    }
}

/// Only our own flush, once a scan, cuts chunks and sends them: a timer would do so while a detector is timed.
fn batching() -> ChunkBatcherConfig {
    ChunkBatcherConfig::NEVER
}

fn file_size(path: &Path) -> Result<u64, StreamError> {
    let metadata = std::fs::metadata(path)
        .map_err(|error| StreamError::Write { path: path.to_owned(), reason: error.to_string() })?;
    Ok(metadata.len())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs::File;
    use std::io::BufReader;
    use std::net::TcpListener;
    use std::time::Instant;

    use detector::detector::StageTime;
    use detector::stage_product::{ProductCell, ProductSphere, Shape, SurfaceClass};
    use detector::{DetectedClass, Detection, OrientedBox, PointCloud};
    use rerun::external::arrow::array::{Array as _, AsArray as _};
    use rerun::external::arrow::datatypes::UInt16Type;
    use rerun::external::re_log_encoding::DecoderApp;
    use rerun::external::re_log_types::LogMsg;
    use rerun::log::Chunk;

    use super::*;
    use crate::annotation::{Annotation, AnnotationClass, PointRegion, ScanId};
    use crate::matching::outcome::{AnnotationOutcome, DetectionOutcome, FalseReason, MissReason};
    use crate::stream::entity_paths;

    const N_POINTS: usize = 6;

    fn unit_box(x_m: f32) -> OrientedBox {
        OrientedBox { center_m: [x_m, 0.0, 0.5], length_width_height_m: [1.0; 3], yaw_rad: 0.3 }
    }

    fn scan(index: u32) -> LabeledScan {
        let annotation = |bounding_box, point_indices| Annotation {
            class: AnnotationClass::Car,
            bounding_box,
            point_indices,
            track: Some(7),
            occlusion: None,
            truncation: None,
        };
        LabeledScan {
            id: ScanId { sequence: "0000".to_owned(), index },
            cloud: (0..N_POINTS).map(|it| [it as f32, 0.5, 0.5]).collect(),
            annotations: vec![annotation(Some(unit_box(0.0)), vec![0]), annotation(None, vec![2, 3])],
            point_regions: vec![PointRegion::Labeled; N_POINTS],
        }
    }

    fn output() -> DetectorOutput {
        let detection = |point_indices, x_m| Detection {
            point_indices,
            bounding_box: unit_box(x_m),
            class: DetectedClass::Vehicle,
            score: Some(0.5),
        };
        DetectorOutput {
            detections: [detection(&[0, 1], 0.0), detection(&[4], 4.0)].into_iter().collect(),
            stage_times: vec![
                StageTime { stage: "grid", duration: Duration::from_millis(2) },
                StageTime { stage: "boxes", duration: Duration::from_millis(1) },
            ],
            dropped_clusters: Vec::new(),
        }
    }

    fn surfaces() -> Vec<SurfaceClass> {
        use SurfaceClass::{Clutter, Ground, Short, Tall, Unseen};
        vec![Short, Ground, Tall, Clutter, Unseen, Short]
    }

    fn products() -> Vec<StageProduct> {
        let cell = ProductCell { center_m: [0.5; 2], z_range_m: [0.0, 1.0], class: SurfaceClass::Short };
        let product = |name, shape| StageProduct { stage: "grid", name, shape };
        vec![
            product("first_guess", Shape::LabeledPoints(vec![SurfaceClass::Clutter; N_POINTS])),
            product("point_classes", Shape::LabeledPoints(surfaces())),
            product("clusters", Shape::Clusters(vec![Some(0), Some(0), None, None, Some(9), None])),
            product("cells", Shape::Cells { cell_size_m: 1.0, cells: vec![cell] }),
            product("walls", Shape::Segments(vec![[[0.0; 3], [1.0; 3]]])),
            product("hulls", Shape::Contours(vec![vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])),
            product("boxes", Shape::Boxes(vec![unit_box(0.0)])),
            product("spheres", Shape::Spheres(vec![ProductSphere { center_m: [0.0; 3], radius_m: 0.5 }])),
        ]
    }

    /// The first pair matches, the second annotation is missed and the second detection false.
    fn one_of_each(task: Task) -> Assignment {
        Assignment {
            task,
            annotations: vec![
                AnnotationOutcome::Matched { detection_idx: 0, cost: 0.1 },
                AnnotationOutcome::Missed(MissReason::Split),
            ],
            detections: vec![
                DetectionOutcome::Matched { annotation_idx: 0, cost: 0.1 },
                DetectionOutcome::False(FalseReason::Fragment),
            ],
        }
    }

    fn options(folder: &Path, viewer: ViewerChoice) -> StreamOptions {
        let (name, file) = ("test".to_owned(), folder.join("run.rrd"));
        StreamOptions { name, file, viewer, shown_task: Task::Objects }
    }

    fn log_detector(
        stream: &mut Stream,
        scan: &LabeledScan,
        name: &str,
        products: &[StageProduct],
        assignments: &[Assignment],
    ) -> Result<(), StreamError> {
        let f_rates_so_far = [
            RunningFRate { task: Task::Objects, f_rate: Some(0.5) },
            RunningFRate { task: Task::Vehicles, f_rate: None },
        ];
        let view = DetectorView {
            name,
            output: &output(),
            products,
            assignments,
            f_rates_so_far: &f_rates_so_far,
            latency: Duration::from_millis(3),
        };
        stream.log_detector(scan, &view)
    }

    /// A recording of `n_scans` scans by two detectors; the last scan has no outcomes.
    fn record(folder: &Path, viewer: ViewerChoice, n_scans: u32) -> Result<StreamEnding, StreamError> {
        let mut stream = Stream::open(&options(folder, viewer), &["grid", "kd-tree"])?;
        for index in 0..n_scans {
            let scan = scan(index);
            stream.log_scan(index, &scan)?;
            let assignments = if index + 1 < n_scans { Task::ALL.map(one_of_each).to_vec() } else { vec![] };
            for name in ["grid", "kd-tree"] {
                log_detector(&mut stream, &scan, name, &products(), &assignments)?;
            }
        }
        stream.finish()
    }

    fn messages(file: &Path) -> Vec<LogMsg> {
        let reader = BufReader::new(File::open(file).unwrap());
        DecoderApp::decode_eager(reader).unwrap().map(Result::unwrap).collect()
    }

    /// The chunks of the recording itself, without those of the blueprint.
    fn chunks(file: &Path) -> Vec<Chunk> {
        let recorded = messages(file).into_iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(store, message) if store.is_recording() => Some(message),
            _ => None,
        });
        recorded.map(|message| Chunk::from_arrow_msg(&message).unwrap()).collect()
    }

    /// How often each component of each entity was logged, as `entity component`.
    fn n_logged(file: &Path) -> BTreeMap<String, usize> {
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
            ("/world/scan/points Points3D:positions", 3),
            ("/world/scan/points grid:surfaces", 3),
            ("/world/scan/points grid:clusters", 3),
            ("/world/scan/points grid:grid:first_guess", 3),
            ("/world/scan/points kd-tree:surfaces", 3),
            ("/world/scan/points kd-tree:clusters", 3),
            ("/world/scan/annotations Boxes3D:half_sizes", 3),
        ]);
    }

    #[test]
    fn every_product_that_is_no_label_has_an_entity() {
        check_n_logged(&[
            ("/world/detectors/kd-tree/cells/grid/cells Boxes3D:half_sizes", 3),
            ("/world/detectors/kd-tree/segments/grid/walls LineStrips3D:strips", 3),
            ("/world/detectors/kd-tree/contours/grid/hulls LineStrips3D:strips", 3),
            ("/world/detectors/kd-tree/boxes/grid/boxes Boxes3D:half_sizes", 3),
            ("/world/detectors/kd-tree/spheres/grid/spheres Ellipsoids3D:half_sizes", 3),
        ]);
    }

    #[test]
    fn outcomes_that_a_scan_no_longer_has_are_cleared() {
        check_n_logged(&[
            ("/world/detectors/grid/outcomes/objects/matched Boxes3D:half_sizes", 2),
            ("/world/detectors/grid/outcomes/objects/matched Clear:is_recursive", 1),
            ("/world/detectors/grid/outcomes/objects/missed Boxes3D:half_sizes", 2),
            ("/world/detectors/grid/outcomes/objects/false Boxes3D:half_sizes", 2),
            ("/world/detectors/grid/outcomes/vehicles/missed Clear:is_recursive", 1),
        ]);
    }

    #[test]
    fn series_have_a_name_once_and_a_value_per_scan() {
        check_n_logged(&[
            ("/series/f_rate/objects/grid SeriesLines:names", 1),
            ("/series/f_rate/objects/grid Scalars:scalars", 3),
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
        let timelines: BTreeSet<&str> = chunks
            .iter()
            .flat_map(|chunk| chunk.timelines().keys().map(rerun::TimelineName::as_str))
            .collect();
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
    fn points_that_cannot_be_drawn_take_their_labels_along() {
        let folder = tempfile::tempdir().unwrap();
        let mut stream = Stream::open(&options(folder.path(), ViewerChoice::None), &["grid"]).unwrap();
        let mut scan = scan(0);
        let with_holes = |it: usize| if it == 1 || it == 4 { f32::NAN } else { it as f32 };
        scan.cloud = (0..N_POINTS).map(|it| [with_holes(it), 0.0, 0.0]).collect::<PointCloud>();
        stream.log_scan(0, &scan).unwrap();
        log_detector(&mut stream, &scan, "grid", &products(), &[]).unwrap();
        stream.finish().unwrap();

        let surfaces_column = entity_paths::surface_column("grid");
        let chunks = chunks(&folder.path().join("run.rrd"));
        let column = chunks.iter().find_map(|chunk| chunk.components().get_array(surfaces_column)).unwrap();
        let logged = column.value(0).as_primitive::<UInt16Type>().values().to_vec();
        let expected: Vec<u16> = [0, 2, 3, 5].map(|it| surfaces()[it] as u16).to_vec();
        assert_eq!(logged, expected);
    }

    #[track_caller]
    fn check_refused(name: &str, products: &[StageProduct], assignments: &[Assignment], expected: &str) {
        let folder = tempfile::tempdir().unwrap();
        let mut stream = Stream::open(&options(folder.path(), ViewerChoice::None), &["grid"]).unwrap();
        let scan = scan(0);
        stream.log_scan(0, &scan).unwrap();
        let refused = log_detector(&mut stream, &scan, name, products, assignments).unwrap_err();
        assert_eq!(refused.to_string(), expected);
    }

    #[test]
    fn what_is_not_of_this_scan_is_refused() {
        check_refused("pca", &[], &[], r#"detector "pca" was not announced; there are ["grid"]"#);
        let short = StageProduct {
            stage: "grid",
            name: "clusters",
            shape: Shape::Clusters(vec![None; N_POINTS - 1]),
        };
        check_refused("grid", &[short], &[], "clusters of grid labels 5 points of a scan of 6");
        let mut assignment = one_of_each(Task::Objects);
        assignment.annotations.pop();
        check_refused(
            "grid",
            &[],
            &[assignment],
            "an assignment of grid has 1 annotations and 2 detections, the scan has 2 and 2",
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error() {
        let mut options = options(Path::new("."), ViewerChoice::None);
        options.file = PathBuf::from("/dev/full");
        let refused = Stream::open(&options, &["grid"]).map(|_| ()).unwrap_err();
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
        assert_eq!(n_logged["/world/scan/points Points3D:positions"], 3);
    }

    #[test]
    fn a_viewer_that_is_not_there_costs_neither_time_nor_the_file() {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        check_viewer_is_lost(&format!("rerun+http://127.0.0.1:{port}/proxy"), Duration::from_secs(2));
    }

    #[test]
    fn a_viewer_that_never_answers_does_not_cost_the_file() {
        let silent = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = silent.local_addr().unwrap().port();
        check_viewer_is_lost(&format!("rerun+http://127.0.0.1:{port}/proxy"), Duration::from_secs(30));
    }
}
