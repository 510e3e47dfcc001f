//! All detectors on all scans, one scan after the other.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use detector::{Detections, DetectorOutput};
use rayon::prelude::*;
use reports::vocabulary::reason::IgnoredDetection;
use reports::vocabulary::task::Task;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::checksum::checksum_as_read;
use scans::dataset::scan_times::{ScanTime, scan_times};
use scans::dataset::{Dataset, DatasetError};

use crate::matching::assign::{MatchingParams, assign};
use crate::matching::class_criteria::ClassCriteria;
use crate::matching::lost_points::LostPoints;
use crate::matching::outcome::{Assignment, DetectionOutcome};
use crate::metrics::agreement::agreements;
use crate::process::problem::{DetectorFailure, DetectorProblem};
use crate::run::counter::{Count, Counter};
use crate::run::given_classes::GivesClasses;
use crate::run::grid_write::GridWrite;
use crate::run::running_detector::{DetectionTime, RunningDetector};
use crate::run::scan_in_drive::{Place, ScanInDrive, ScansBefore, selected_before};

/// Settings of a run on one data set.
pub struct SideBySide<'a> {
    /// The data set of the scans.
    pub dataset: &'a dyn Dataset,
    /// The selected scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// The part of `scan_indices` that is run: all, or that of a shard.
    pub part: Range<usize>,
    /// Number of scans that were selected of the data sets before this one.
    pub n_before: usize,
    /// How detections are judged.
    pub matching: MatchingParams,
    /// How those of single classes are judged.
    pub class_criteria: &'a ClassCriteria,
    /// Number of detections of the first scan, for each detector, that are thrown away before the timed ones.
    pub n_warmup: usize,
    /// How often each detector detects in each scan. With repetitions the machine disturbs the shortest time less.
    pub n_repeats: NonZeroUsize,
    /// Number of scans that are read (or simulated) at once, each on its own thread. No scan is read while a detector runs.
    pub n_jobs: usize,
    /// Who counts instructions and memory, if they are counted.
    pub counter: Option<&'a Counter>,
    /// Whether the run goes on if a detector fails.
    pub on_failure: OnDetectorFailure,
    /// Ends the run at the next scan once it is set.
    pub interrupted: &'a AtomicBool,
}

/// Whether a run goes on if a detector gives no answer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum OnDetectorFailure {
    /// The run ends.
    #[default]
    Stop,
    /// The detector counts as having found nothing in the scan, and the run goes on unless the failure is final.
    Skip,
}

/// Results of one detector on one scan.
#[derive(Debug, Clone)]
pub struct DetectorScan {
    /// Name of the detector.
    pub detector: &'static str,
    /// Its detections, and the stage times of the first repetition.
    pub output: DetectorOutput,
    /// Times of the whole detection on a monotonic clock: no reading, matching or logging.
    pub times: DetectionTimes,
    /// The failure, if it gave no answer.
    pub failure: Option<DetectorFailure>,
    /// Outcomes of annotations and detections, one entry for each task: of
    /// [`Task::ALL`](reports::vocabulary::task::Task::ALL), then of classes.
    pub assignments: Vec<Assignment>,
}

/// Times of a detector for a scan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DetectionTimes {
    /// The first repetition: time of a detection that sees the scan for the first time. `None` if the detector failed, or
    /// its detections were read.
    pub first: Option<Duration>,
    /// The shortest of all repetitions.
    pub least: Option<Duration>,
    /// Time on processors in the first repetition; `None` if the system does not report it.
    pub cpu: Option<Duration>,
    /// The shortest time of the way to the detector and back; `None` for built-in detectors.
    pub overhead: Option<Duration>,
    /// The shortest time of the [reference](GridWrite), which takes turns with the detectors; `None` if it was not timed.
    pub reference: Option<Duration>,
    /// What was counted in the first repetition, if anything was.
    pub count: Option<Count>,
}

/// One scan with the results of all detectors.
pub struct ScanResults<'a> {
    /// Index of the scan among all selected scans of its data set, from 0, whichever part of them is run.
    pub run_idx: usize,
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Its checksum, as it was read.
    pub checksum: u32,
    /// When it was taken.
    pub time: &'a ScanTime,
    /// Results of each detector, in the order of `detectors`.
    pub results: &'a [DetectorScan],
    /// The detectors, which still hold the stage products of this scan.
    pub detectors: &'a [Box<dyn RunningDetector>],
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
    /// The user interrupted it.
    #[error("interrupted after {n_done} of {n_scans} scans")]
    Interrupted {
        /// Number of scans that were done.
        n_done: usize,
        /// Number of scans that were to be run.
        n_scans: usize,
    },
}

impl RunError {
    /// Whether a detector was not asked because the user has interrupted the run.
    fn is_interruption(&self) -> bool {
        matches!(self, Self::Detector(it) if it.problem == DetectorProblem::Interrupted)
    }
}

impl SideBySide<'_> {
    /// Runs `detectors` on every scan and hands each scan's results to `on_scan`, in the order of the scans.
    ///
    /// The detectors and the reference take turns scan by scan and repetition by repetition, in alternating order, so that
    /// a disturbance of the machine affects all of them.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a scan cannot be read, a detector failure ends the run, or the run is interrupted; and errors of
    /// `on_scan`.
    pub fn run<E: From<RunError>>(
        &self,
        detectors: &mut [Box<dyn RunningDetector>],
        on_scan: impl FnMut(ScanResults<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.run_past_damage(detectors, |_, error| Err(error), on_scan)
    }

    /// As [`Self::run`], but `on_damage` decides whether the run goes on without a scan that cannot be read.
    ///
    /// # Errors
    ///
    /// [`RunError`] if `on_damage` returns the error, a detector failure ends the run, or the run is interrupted; and errors
    /// of `on_scan`.
    pub fn run_past_damage<E: From<RunError>>(
        &self,
        detectors: &mut [Box<dyn RunningDetector>],
        mut on_damage: impl FnMut(&ScanId, DatasetError) -> Result<(), DatasetError>,
        mut on_scan: impl FnMut(ScanResults<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut is_warm = false;
        if let Some(counter) = self.counter {
            for detector in detectors.iter_mut() {
                detector.count_by(counter);
            }
        }
        let mut reference = GridWrite::default();
        let mut outputs = vec![DetectorOutput::default(); detectors.len()];
        let mut gives: Vec<GivesClasses> = detectors.iter().map(|it| GivesClasses::of(&**it)).collect();
        let times = scan_times(self.dataset);
        for (batch_idx, batch) in self.scan_indices[self.part.clone()].chunks(self.n_jobs.max(1)).enumerate()
        {
            let scans: Vec<_> = batch.par_iter().map(|&scan_idx| self.read(scan_idx)).collect();
            for (scan, in_batch_idx) in scans.into_iter().zip(0..) {
                let run_idx = self.part.start + batch_idx * self.n_jobs.max(1) + in_batch_idx;
                let (scan, checksum) = match scan {
                    Ok(read) => read,
                    Err(error) => {
                        let id = &self.dataset.scan_ids()[self.scan_indices[run_idx]];
                        on_damage(id, error).map_err(RunError::from)?;
                        continue;
                    }
                };
                let scan_idx = self.scan_indices[run_idx];
                let time = &times[scan_idx];
                let scan_indices = selected_before(self.dataset, self.scan_indices, run_idx);
                let before = Some(ScansBefore { scan_indices, times: &times, interrupted: self.interrupted });
                let place = Some(Place { dataset: self.dataset, scan_idx, before });
                let asked = ScanInDrive { scan: &scan, time_s: time.time_s, place };
                let or_interrupted = |error: RunError| {
                    if error.is_interruption() { self.interrupted_after(run_idx) } else { error }
                };
                if !is_warm {
                    self.warm_up(detectors, &asked).map_err(or_interrupted)?;
                    is_warm = true;
                }
                if self.is_interrupted() {
                    return Err(self.interrupted_after(run_idx).into());
                }
                let turns = self.detect_all(run_idx, &asked, detectors, &mut outputs, &mut reference);
                let turns = turns.map_err(or_interrupted)?;
                gives.iter_mut().zip(&outputs).for_each(|(gives, output)| gives.look(&output.detections));
                let mut results = self.results(&scan, detectors, &outputs, &gives, turns);
                if !scan.is_labeled() {
                    say_who_agrees(&mut results, scan.cloud.len());
                }
                on_scan(ScanResults { run_idx, scan: &scan, checksum, time, results: &results, detectors })?;
            }
        }
        Ok(())
    }

    fn read(&self, scan_idx: usize) -> Result<(LabeledScan, u32), DatasetError> {
        let scan = self.dataset.read_scan(scan_idx)?;
        let checksum = checksum_as_read(&scan);
        Ok((scan, checksum))
    }

    fn interrupted_after(&self, run_idx: usize) -> RunError {
        RunError::Interrupted { n_done: run_idx - self.part.start, n_scans: self.part.len() }
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn warm_up(
        &self,
        detectors: &mut [Box<dyn RunningDetector>],
        asked: &ScanInDrive<'_>,
    ) -> Result<(), RunError> {
        let mut thrown_away = DetectorOutput::default();
        for detector in detectors {
            for _ in (0..self.n_warmup).take_while(|_| !self.is_interrupted()) {
                // It is asked again when the scan counts.
                if self.unless_skipped(detector.detect(asked, &mut thrown_away))?.is_err() {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Fills the outputs of all detectors. Returns the times of each, or why it gave no answer.
    fn detect_all(
        &self,
        run_idx: usize,
        asked: &ScanInDrive<'_>,
        detectors: &mut [Box<dyn RunningDetector>],
        outputs: &mut [DetectorOutput],
        reference: &mut GridWrite,
    ) -> Result<Vec<Turns>, RunError> {
        let mut of_reference = Duration::MAX;
        let mut turns: Vec<Turns> = vec![Turns::default(); detectors.len()];
        let mut first_stage_times = Vec::new();
        // After an interruption the first repetition is finished, but no other is begun.
        for repeat in (0..self.n_repeats.get()).take_while(|it| *it == 0 || !self.is_interrupted()) {
            let mut order: Vec<Option<usize>> = (0..detectors.len()).map(Some).chain([None]).collect();
            if (run_idx + repeat) % 2 == 1 {
                order.reverse();
            }
            for turn in order {
                let Some(idx) = turn else {
                    of_reference = of_reference.min(reference.time(&asked.scan.cloud));
                    continue;
                };
                // A scan that was skipped once is not asked for again, nor one that a detector remembers.
                if turns[idx].failure.is_none() && (repeat == 0 || !detectors[idx].is_in_order()) {
                    let taken = detectors[idx].detect(asked, &mut outputs[idx]);
                    turns[idx].add(self.unless_skipped(taken)?);
                }
            }
            if repeat == 0 {
                first_stage_times = outputs.iter().map(|it| it.stage_times.clone()).collect();
            }
        }
        for (output, stage_times) in outputs.iter_mut().zip(first_stage_times) {
            output.stage_times = stage_times;
        }
        for (turns, output) in turns.iter_mut().zip(outputs) {
            turns.times.reference = Some(of_reference);
            if turns.failure.is_some() {
                output.clear();
            }
        }
        Ok(turns)
    }

    /// Ends the run after a failure, unless it is to be skipped; then returns the failure.
    fn unless_skipped(
        &self,
        taken: Result<DetectionTime, DetectorFailure>,
    ) -> Result<Result<DetectionTime, DetectorFailure>, RunError> {
        match taken {
            Err(failure) if self.on_failure == OnDetectorFailure::Stop || failure.is_final => {
                Err(failure.into())
            }
            taken => Ok(taken),
        }
    }

    /// Results of all detectors, with the outcomes of all annotations and detections.
    fn results(
        &self,
        scan: &LabeledScan,
        detectors: &[Box<dyn RunningDetector>],
        outputs: &[DetectorOutput],
        gives: &[GivesClasses],
        turns: Vec<Turns>,
    ) -> Vec<DetectorScan> {
        let annotated = &self.dataset.description().annotated;
        let judge = |detector: &dyn RunningDetector,
                     output: &DetectorOutput,
                     gives: &GivesClasses,
                     has_failed: bool| {
            let products = if has_failed { Vec::new() } else { detector.stage_products(&scan.cloud) };
            let lost = LostPoints::gather(scan, &output.detections, &products);
            let of_task = |task| {
                let criterion = self.class_criteria.of(task, self.matching.criterion);
                let matching = MatchingParams { criterion, ..self.matching };
                let mut assignment = assign(scan, &output.detections, task, annotated, &matching);
                if has_failed {
                    assignment.say_that_detector_failed();
                } else {
                    assignment.say_where_points_were_lost(scan, &lost);
                }
                assignment
            };
            gives.tasks(detector, scan, &output.detections).into_iter().map(of_task).collect()
        };
        let results = detectors.iter().zip(outputs).zip(gives).zip(turns);
        results
            .map(|(((detector, output), gives), turns)| DetectorScan {
                detector: detector.name(),
                output: output.clone(),
                times: turns.times,
                assignments: judge(&**detector, output, gives, turns.failure.is_some()),
                failure: turns.failure,
            })
            .collect()
    }
}

/// Says of all detections in a scan of `n_points` without labels how many of the other detectors have them.
fn say_who_agrees(results: &mut [DetectorScan], n_points: usize) {
    if results.len() < 2 {
        return;
    }
    for task in Task::ALL {
        let all: Vec<&Detections> = results.iter().map(|it| &it.output.detections).collect();
        let agreements = agreements(&all, task, n_points);
        for (result, agreements) in results.iter_mut().zip(agreements) {
            for assignment in result.assignments.iter_mut().filter(|it| it.task == task) {
                for (outcome, agreement) in assignment.detections.iter_mut().zip(&agreements) {
                    let is_unlabelled = matches!(
                        outcome,
                        DetectionOutcome::Unknowable(_)
                            | DetectionOutcome::Ignored(IgnoredDetection::OutsideLabeledRegion)
                    );
                    if is_unlabelled && agreement.is_some() {
                        *outcome = DetectionOutcome::Unknowable(*agreement);
                    }
                }
            }
        }
    }
}

/// The repetitions of one detector on one scan.
#[derive(Debug, Clone, Default)]
struct Turns {
    times: DetectionTimes,
    failure: Option<DetectorFailure>,
}

impl Turns {
    fn add(&mut self, taken: Result<DetectionTime, DetectorFailure>) {
        match taken {
            Ok(taken) => {
                let least = |old: Option<Duration>, new: Option<Duration>| old.into_iter().chain(new).min();
                self.times.first = self.times.first.or(taken.wall);
                self.times.cpu = self.times.cpu.or(taken.cpu);
                self.times.count = self.times.count.or(taken.count);
                self.times.least = least(self.times.least, taken.wall);
                self.times.overhead = least(self.times.overhead, taken.overhead);
            }
            // If a repetition fails, the times of the earlier ones do not count.
            Err(failure) => *self = Self { times: DetectionTimes::default(), failure: Some(failure) },
        }
    }
}
