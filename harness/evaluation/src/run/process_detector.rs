//! A detector that is a program of its own, started again after a failure.

use std::time::Duration;

use detector::detector::{DetectorOutput, StageTime};
use detector::stage_product::{Shape, StageProduct};
use detector::{BoxDetails, DetectedClass, Detection, PointCloud};
use perf_event::events::Hardware;
use scans::annotation::LabeledScan;
use scans::conversion::results::detection_rows::clusters_of_points;

use crate::process::answer::{Found, RankedBox};
use crate::process::conversation::{Answered, Asked, Conversation, FIRST_SCAN_LIMIT, Goodbye};
use crate::process::message::Configuration;
use crate::process::problem::{DetectorFailure, DetectorProblem};
use crate::process::program::StartedProgram;
use crate::run::config::RunConfig;
use crate::run::counter::{Count, Counter, ProcessMeter, peak_bytes_of};
use crate::run::drive_memory::DriveMemory;
use crate::run::foreign_detector::ForeignProcess;
use crate::run::found_objects::{ForeignVehicles, FoundObject, members_of};
use crate::run::kept_names::kept;
use crate::run::running_detector::{DetectionTime, RunningDetector};
use crate::run::scan_in_drive::ScanInDrive;

/// After so many failures without an answer in between, it is not started again.
const MOST_FAILURES: u32 = 3;
/// Prefix of the names of stages whose times the detector measured itself.
pub const REPORTED: &str = "reported: ";

/// The product that says which points are ground: those whose value is not 0.
pub const GROUND_PRODUCT: &str = "ground";

/// The name of a detector that reads the points and finds nothing.
pub const NOTHING: &str = "nothing";

/// A detector that is a program of its own.
pub struct ProcessDetector {
    name: &'static str,
    process: ForeignProcess,
    start: StartedProgram,
    configuration: Configuration,
    vehicles: ForeignVehicles,
    conversation: Option<Conversation>,
    has_answered: bool,
    n_failures: u32,
    probe: OverheadProbe,
    counter: Option<Counter>,
    meter: ProcessMeter,
    memory: DriveMemory,
    // Of the latest scan.
    clusters: Vec<Option<u32>>,
    products: Vec<(String, Vec<u8>)>,
    // Whether it reported ground points in any scan so far.
    // Whether its latest answer has a place for classes.
    names_classes: bool,
    reports_ground: bool,
}

/// A program that reads the points of a scan and finds nothing.
enum OverheadProbe {
    NotStarted,
    Running(Box<Conversation>),
    /// It does not work here.
    Broken,
}

impl ProcessDetector {
    /// The detector `name`, which is not started before the first scan.
    pub fn new(
        name: &'static str,
        process: &ForeignProcess,
        folder: std::path::PathBuf,
        configuration: Configuration,
        vehicles: ForeignVehicles,
        config: &RunConfig,
    ) -> Self {
        let start = StartedProgram {
            command: process.command.clone(),
            folder,
            hidden: process.sandbox.then(|| config.places_of_labels.clone()),
            threads: process.threads,
            start_limit: process.start_limit,
            classes: config.classes.clone(),
        };
        Self {
            name,
            process: process.clone(),
            start,
            configuration,
            vehicles,
            conversation: None,
            has_answered: false,
            n_failures: 0,
            probe: OverheadProbe::NotStarted,
            counter: None,
            meter: ProcessMeter::default(),
            memory: DriveMemory::default(),
            clusters: Vec::new(),
            products: Vec::new(),
            reports_ground: false,
            names_classes: true,
        }
    }

    /// Reuses the program of a detector that had other parameters.
    ///
    /// # Errors
    ///
    /// If the program does not accept the new parameters.
    pub fn with_program(mut self, mut conversation: Conversation) -> Result<Self, DetectorFailure> {
        let is_the_same = conversation.has(&self.configuration);
        let taken = if is_the_same { Ok(()) } else { conversation.configure_anew(&self.configuration) };
        self.conversation = Some(conversation);
        match taken {
            Ok(()) => Ok(self),
            Err(problem) => Err(DetectorFailure { is_final: true, ..self.failure(None, problem) }),
        }
    }

    /// The answer to the scan in `asked`.
    fn ask(&mut self, in_drive: &ScanInDrive<'_>) -> Result<Answered, DetectorFailure> {
        let scan = in_drive.scan;
        let mut conversation = if let Some(conversation) = self.conversation.take() {
            conversation
        } else {
            let begun = Conversation::begin(&self.start, &self.configuration, scan.cloud.len());
            let begun = begun.map_err(|goodbye| self.start_failure(goodbye))?;
            let _ = self.process.introduction.set(begun.introduction().clone());
            (self.has_answered, self.meter) = (false, ProcessMeter::default());
            begun
        };
        let limit = if self.has_answered {
            self.process.time_limit
        } else {
            self.process.time_limit.max(FIRST_SCAN_LIMIT)
        };
        let asked = if conversation.knows_drives() {
            let (memory, wishes) = (&mut self.memory, conversation.wishes());
            let caught_up =
                memory.catch_up(in_drive, wishes, |asked| conversation.ask(asked, limit).map(|_| ()));
            let asked = caught_up.and_then(|begins_drive| memory.asked(in_drive, wishes, begins_drive));
            asked.and_then(|asked| conversation.ask(&asked, limit))
        } else {
            conversation.ask(&Asked { scan, time_s: in_drive.time_s, in_drive: None }, limit)
        };
        self.conversation = Some(conversation);
        match asked {
            Ok(answered) => {
                (self.has_answered, self.n_failures) = (true, 0);
                Ok(answered)
            }
            Err(problem) => Err(self.failure(Some(scan), problem)),
        }
    }

    fn start_failure(&self, (problem, last_words): Goodbye) -> DetectorFailure {
        DetectorFailure { detector: self.name.to_owned(), scan: None, problem, last_words, is_final: true }
    }

    /// The failure that `problem` causes. The detector is ended, unless it reported the problem itself.
    fn failure(&mut self, scan: Option<&LabeledScan>, problem: DetectorProblem) -> DetectorFailure {
        let (problem, last_words) = match (self.conversation.take(), problem) {
            (Some(conversation), problem @ DetectorProblem::Reported(_)) => {
                let last_words = conversation.last_words();
                self.conversation = Some(conversation);
                (problem, last_words)
            }
            (Some(conversation), problem) => {
                self.memory.lose();
                self.n_failures += 1;
                conversation.end(problem)
            }
            (None, problem) => (problem, Vec::new()),
        };
        // A scan that the machine prevents is not held against the detector: the run ends.
        let is_final = self.n_failures >= MOST_FAILURES
            || matches!(problem, DetectorProblem::Machine(_) | DetectorProblem::Interrupted);
        let scan = scan.map(|it| it.id.to_string());
        DetectorFailure { detector: self.name.to_owned(), scan, problem, last_words, is_final }
    }

    /// Time from the question to the answer without detection; `None` if it cannot be measured.
    fn time_overhead(&mut self, &ScanInDrive { scan, time_s, .. }: &ScanInDrive<'_>) -> Option<Duration> {
        if matches!(self.probe, OverheadProbe::NotStarted) {
            let start = StartedProgram { command: probe_command(), threads: 1, ..self.start.clone() };
            let configuration =
                Configuration { parameters: serde_json::Map::new(), ..self.configuration.clone() };
            let begun = Conversation::begin(&start, &configuration, scan.cloud.len());
            self.probe = begun.map_or(OverheadProbe::Broken, |it| OverheadProbe::Running(Box::new(it)));
        }
        let OverheadProbe::Running(probe) = &mut self.probe else { return None };
        let answered = probe.ask(&Asked { scan, time_s, in_drive: None }, FIRST_SCAN_LIMIT).ok();
        if answered.is_none() {
            self.probe = OverheadProbe::Broken;
        }
        answered.map(|it| it.wall)
    }

    /// Instructions so far, while its program runs and is counted.
    fn count_so_far(&mut self) -> Option<u64> {
        if self.counter == Some(Counter::Processor) {
            self.meter.begin(&Hardware::INSTRUCTIONS, &self.conversation.as_ref()?.processes());
        }
        self.meter.n_so_far()
    }

    fn count_since(&mut self, before: Option<u64>) -> Count {
        let n_instructions = self.meter.n_so_far().zip(before).map(|(after, before)| after - before);
        let processes = self.conversation.as_ref().map_or_else(Vec::new, Conversation::processes);
        Count { n_instructions, peak_bytes: peak_bytes_of(&processes) }
    }

    fn take(
        &mut self,
        found: Found,
        cloud: &PointCloud,
        output: &mut DetectorOutput,
    ) -> Result<(), DetectorProblem> {
        let stage_times = found.stages.iter().map(|(name, ms)| StageTime {
            stage: kept(&format!("{REPORTED}{name}")),
            duration: Duration::from_secs_f64(ms / 1e3),
        });
        output.stage_times.extend(stage_times);
        let objects = objects_of(&found);
        self.reports_ground |= found.products.iter().any(|(name, _)| name == GROUND_PRODUCT);
        self.products = found.products;
        self.names_classes = found.names_classes;
        self.vehicles.detections_of(objects, cloud, output).map_err(DetectorProblem::WrongAnswer)?;
        for RankedBox { bounding_box, score, class } in found.ranked {
            let ranked = Detection::new(&[], bounding_box, DetectedClass::Vehicle, Some(score));
            output.unlikely.push(Detection { given: class.and_then(|it| it.given), ..ranked });
        }
        self.clusters = clusters_of_points(&output.detections, cloud.len());
        Ok(())
    }
}

impl RunningDetector for ProcessDetector {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(
        &mut self,
        asked: &ScanInDrive<'_>,
        output: &mut DetectorOutput,
    ) -> Result<DetectionTime, DetectorFailure> {
        let scan = asked.scan;
        output.clear();
        self.clusters.clear();
        self.products.clear();
        let before = self.count_so_far();
        let Answered { found, wall, cpu } = self.ask(asked)?;
        let count = self.counter.is_some().then(|| self.count_since(before));
        if let Err(problem) = self.take(found, &scan.cloud, output) {
            output.clear();
            self.products.clear();
            return Err(self.failure(Some(scan), problem));
        }
        let overhead = self.time_overhead(asked);
        Ok(DetectionTime { wall: Some(wall), cpu, overhead, count })
    }

    fn count_by(&mut self, counter: &Counter) {
        self.counter = Some(counter.clone());
    }

    fn may_give_classes(&self) -> bool {
        self.names_classes
    }

    fn is_in_order(&self) -> bool {
        self.conversation.as_ref().is_some_and(|it| it.wishes().in_order)
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let product = |name, values: Vec<Option<u32>>| {
            let shape =
                Shape::Clusters(if values.len() == cloud.len() { values } else { vec![None; cloud.len()] });
            StageProduct { stage: name, name, shape }
        };
        let labels = self.products.iter().map(|(name, values)| {
            product(kept(name), values.iter().map(|it| Some(u32::from(*it))).collect())
        });
        labels.chain([product("clusters", self.clusters.clone())]).collect()
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        match self.products.iter().find(|(name, _)| name == GROUND_PRODUCT) {
            Some((_, values)) => Some(values.iter().map(|it| *it != 0).collect()),
            // If it gives no answer, it has classified no point as ground.
            None => self.reports_ground.then(|| vec![false; cloud.len()]),
        }
    }

    fn into_conversation(self: Box<Self>) -> Option<Conversation> {
        self.conversation
    }

    fn finish(self: Box<Self>) -> Vec<String> {
        if let OverheadProbe::Running(probe) = self.probe {
            probe.quit();
        }
        let warnings = self.conversation.map_or_else(Vec::new, Conversation::quit);
        warnings.into_iter().map(|it| format!("the detector {:?} {it}", self.name)).collect()
    }
}

/// This program, as a detector that reads the points and finds nothing.
fn probe_command() -> Vec<String> {
    let program = std::env::current_exe().unwrap_or_default();
    vec![program.display().to_string(), "serve".to_owned(), NOTHING.to_owned()]
}

/// The objects of an answer, in the order of its detections.
fn objects_of(found: &Found) -> Vec<FoundObject> {
    let mut objects: Vec<FoundObject> = match (&found.clusters, found.boxes.as_slice()) {
        (None, boxes) => {
            boxes.iter().map(|it| FoundObject { bounding_box: Some(*it), ..FoundObject::default() }).collect()
        }
        (Some(clusters), []) => members_of(clusters).into_values().map(FoundObject::of_points).collect(),
        (Some(clusters), boxes) => {
            let mut objects: Vec<FoundObject> = boxes
                .iter()
                .map(|it| FoundObject { bounding_box: Some(*it), ..FoundObject::of_points(Vec::new()) })
                .collect();
            for (id, points) in members_of(clusters) {
                objects[id as usize - 1].point_indices = Some(points);
            }
            objects
        }
    };
    for (idx, object) in objects.iter_mut().enumerate() {
        object.class = found.classes.get(idx).copied().flatten();
        object.box_details = BoxDetails {
            score: found.box_scores.get(idx).copied().flatten(),
            velocity_m_per_s: found.velocities.get(idx).copied().flatten(),
            track: found.tracks.get(idx).copied().flatten(),
            ..BoxDetails::default()
        };
        object.score = found.scores.as_ref().and_then(|it| it.get(idx).copied());
    }
    objects
}
