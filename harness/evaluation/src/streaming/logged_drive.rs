//! Drives as a run has seen them: scans in the order of time, what is labelled, what was answered.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use reports::rows::match_outcome::{AnnotationFacts, DetectionFacts, FoundBy, MatchOutcome};
use reports::rows::match_row::MatchRow;
use reports::rows::pose_row::PoseRow;
use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::ScanRow;
use reports::streaming::closeness::{NoStream, Stretch, stretches};
use reports::vocabulary::reason::{IgnoredAnnotation, IgnoredDetection};
use reports::vocabulary::task::Task;

use super::moving::{TimeUs, pose_of_row};

/// A longer time of detection is damage, in milliseconds: an hour.
const MOST_LATENCY_MS: f64 = 3.6e6;

/// A stretch of a drive without a gap.
#[derive(Debug, Clone)]
pub struct LoggedDrive {
    /// Id of the data set.
    pub dataset: String,
    /// Name of the drive.
    pub name: String,
    /// Its scans, by time: at least two.
    pub scans: Vec<LoggedScan>,
    /// Whether the pose of every scan is known.
    pub has_poses: bool,
    /// What is labelled and answered, by task.
    pub tasks: BTreeMap<Task, LoggedTask>,
}

/// A scan of a drive.
#[derive(Debug, Clone)]
pub struct LoggedScan {
    /// Its name.
    pub name: ScanName,
    /// When it was there to be taken.
    pub time_us: TimeUs,
    /// Pose of the sensor in a frame that rests; no turn and no way where poses are unknown.
    pub world_from_sensor: Isometry3<f64>,
    /// Time of detection in milliseconds of each detector of the run; `None` where it does not count.
    pub latencies_ms: Vec<Option<f64>>,
}

/// What is labelled and answered for one task.
#[derive(Debug, Clone)]
pub struct LoggedTask {
    /// What is labelled in each scan.
    pub labels: Vec<Vec<Label>>,
    /// What each detector of the run answered to each scan: by detector, then scan.
    pub answers: Vec<Vec<Vec<LoggedDetection>>>,
    /// Whether each detector of the run was asked for it: only those that give classes are asked for a class.
    pub is_asked: Vec<bool>,
    /// Whether detections beyond the labels are known to be false.
    pub are_false_known: bool,
}

/// An annotation that the task asks for.
#[derive(Debug, Clone)]
pub struct Label {
    /// Facts about it.
    pub facts: AnnotationFacts,
    /// Why it does not count; `None` if it counts.
    pub ignored: Option<IgnoredAnnotation>,
}

/// A detection that the task asks for.
#[derive(Debug, Clone)]
pub struct LoggedDetection {
    /// Facts about it.
    pub facts: DetectionFacts,
    /// What it is if it finds nothing.
    pub unmatched: Unmatched,
    /// Track of the annotation that it found in its own scan, and whether it found one.
    pub found: Option<Option<u32>>,
}

/// What a detection is that finds nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unmatched {
    /// False.
    False,
    /// Neither right nor false.
    Ignored(IgnoredDetection),
    /// It cannot be known whether it is false.
    Unknowable,
}

/// The drives of a run, and the data sets that have none.
///
/// `drive_of` gives a scan the name of its drive. Damaged poses count as unknown.
pub fn logged_drives(
    detectors: &[&str],
    (scans, matches, poses): (&[ScanRow], &[MatchRow], &[PoseRow]),
    drive_of: impl Fn(&ScanRow) -> String,
) -> (Vec<LoggedDrive>, Vec<NoStream>) {
    let detector_idx = |name: &str| detectors.iter().position(|it| *it == name);
    let poses =
        poses.iter().filter_map(|it| Some((key(&it.dataset, &it.sequence, it.scan), pose_of_row(it).ok()?)));
    let poses: BTreeMap<Key<'_>, Isometry3<f64>> = poses.collect();
    let (stretches, without) = stretches(scans, drive_of);
    let mut drives: Vec<LoggedDrive> =
        stretches.iter().map(|it| LoggedDrive::of(it, &poses, detectors.len())).collect();
    let mut place_of: BTreeMap<(String, String, u32), (usize, usize)> = BTreeMap::new();
    for (drive_idx, drive) in drives.iter().enumerate() {
        for (scan_idx, scan) in drive.scans.iter().enumerate() {
            let ScanName { dataset, sequence, scan } = scan.name.clone();
            place_of.insert((dataset, sequence, scan), (drive_idx, scan_idx));
        }
    }
    let place = |dataset: &str, sequence: &str, scan: u32| {
        place_of.get(&(dataset.to_owned(), sequence.to_owned(), scan)).copied()
    };
    for row in scans {
        let (Some((drive_idx, scan_idx)), Some(numbers), Some(detector)) =
            (place(&row.dataset, &row.sequence, row.scan), row.numbers(), detector_idx(&row.detector))
        else {
            continue;
        };
        let drive = &mut drives[drive_idx];
        let latency = &mut drive.scans[scan_idx].latencies_ms[detector];
        *latency = latency.or(numbers.latency_ms.filter(|it| is_latency(*it)));
        let task = drive.task(row.task, detectors.len());
        task.are_false_known &= numbers.counts.fo().is_some();
        task.is_asked[detector] = true;
    }
    for row in matches {
        let (Some((drive_idx, scan_idx)), Some(detector)) =
            (place(&row.dataset, &row.sequence, row.scan), detector_idx(&row.detector))
        else {
            continue;
        };
        drives[drive_idx].task(row.task, detectors.len()).add(scan_idx, detector, &row.outcome);
    }
    (drives, without)
}

/// Whether a time of detection in milliseconds can be one: files may be somebody else's.
pub fn is_latency(latency_ms: f64) -> bool {
    (0.0..=MOST_LATENCY_MS).contains(&latency_ms)
}

type Key<'a> = (&'a str, &'a str, u32);

fn key<'a>(dataset: &'a str, sequence: &'a str, scan: u32) -> Key<'a> {
    (dataset, sequence, scan)
}

impl LoggedDrive {
    fn of(
        Stretch { dataset, drive, scans }: &Stretch,
        poses: &BTreeMap<Key<'_>, Isometry3<f64>>,
        n_detectors: usize,
    ) -> Self {
        let pose = |it: &ScanName| poses.get(&key(&it.dataset, &it.sequence, it.scan)).copied();
        let has_poses = scans.iter().all(|(it, _)| pose(it).is_some());
        let scan = |(name, time_us): &(ScanName, TimeUs)| LoggedScan {
            name: name.clone(),
            time_us: *time_us,
            world_from_sensor: pose(name).filter(|_| has_poses).unwrap_or_default(),
            latencies_ms: vec![None; n_detectors],
        };
        Self {
            dataset: dataset.clone(),
            name: drive.clone(),
            scans: scans.iter().map(scan).collect(),
            has_poses,
            tasks: BTreeMap::new(),
        }
    }

    fn task(&mut self, task: Task, n_detectors: usize) -> &mut LoggedTask {
        let n_scans = self.scans.len();
        self.tasks.entry(task).or_insert_with(|| LoggedTask {
            labels: vec![Vec::new(); n_scans],
            answers: vec![vec![Vec::new(); n_scans]; n_detectors],
            is_asked: vec![false; n_detectors],
            are_false_known: true,
        })
    }

    /// Times of its scans.
    pub fn times_us(&self) -> Vec<TimeUs> {
        self.scans.iter().map(|it| it.time_us).collect()
    }
}

impl LoggedTask {
    fn add(&mut self, scan_idx: usize, detector: usize, outcome: &MatchOutcome) {
        use MatchOutcome as Of;
        let (label, detection) = match outcome {
            Of::Matched { annotation, detection, .. } => {
                let found = LoggedDetection {
                    facts: detection.clone(),
                    unmatched: self.beyond_labels(),
                    found: Some(annotation.track),
                };
                (Some((annotation, None)), Some(found))
            }
            Of::Missed { annotation, .. } => (Some((annotation, None)), None),
            Of::IgnoredAnnotation { annotation, reason } => (Some((annotation, Some(*reason))), None),
            Of::Tall { annotation, found_by } => {
                let found = found_by.as_ref().map(|FoundBy { detection, .. }| LoggedDetection {
                    facts: detection.clone(),
                    unmatched: self.beyond_labels(),
                    found: Some(annotation.track),
                });
                (Some((annotation, Some(IgnoredAnnotation::Tall))), found)
            }
            Of::False { detection, .. } => (None, Some(alone(detection, Unmatched::False))),
            Of::IgnoredDetection { detection, reason } => {
                (None, Some(alone(detection, Unmatched::Ignored(*reason))))
            }
            Of::Unknowable { detection, .. } => (None, Some(alone(detection, Unmatched::Unknowable))),
        };
        let labels = &mut self.labels[scan_idx];
        // Every detector has a row about the same annotation.
        if let Some((facts, ignored)) =
            label.filter(|(it, _)| labels.iter().all(|known| known.facts.id != it.id))
        {
            labels.push(Label { facts: facts.clone(), ignored });
        }
        self.answers[detector][scan_idx].extend(detection);
    }

    fn beyond_labels(&self) -> Unmatched {
        if self.are_false_known { Unmatched::False } else { Unmatched::Unknowable }
    }
}

fn alone(detection: &DetectionFacts, unmatched: Unmatched) -> LoggedDetection {
    LoggedDetection { facts: detection.clone(), unmatched, found: None }
}
