//! All detectors on all scans, one scan after the other.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use detector::{Detector, DetectorOutput};
use rayon::prelude::*;
use reports::vocabulary::task::Task;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::{Dataset, DatasetError};

use crate::matching::assign::{MatchingParams, assign};
use crate::matching::outcome::Assignment;
use crate::run::grid_write::GridWrite;

/// What is run, and how.
pub struct SideBySide<'a> {
    /// Where the scans come from.
    pub dataset: &'a dyn Dataset,
    /// Which of its scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// How detections are judged.
    pub matching: MatchingParams,
    /// Detections of the first scan, for each detector, that are thrown away before anything is timed.
    pub n_warmup: usize,
    /// How often each detector looks at each scan; more than once, and the shortest time is less disturbed by the machine.
    pub n_repeats: NonZeroUsize,
    /// Scans that are read (or simulated) at once, each on a thread of its own. Nothing is read while a detector runs.
    pub n_jobs: usize,
    /// Ends the run at the next scan once it is set.
    pub interrupted: &'a AtomicBool,
}

/// What one detector made of one scan.
#[derive(Debug, Clone)]
pub struct DetectorScan {
    /// Name of the detector.
    pub detector: &'static str,
    /// Its detections, and the stage times of the first repetition.
    pub output: DetectorOutput,
    /// Times of the whole detection on a monotonic clock: no reading, matching or logging.
    pub times: DetectionTimes,
    /// What became of annotations and detections, one entry for each of [`Task::ALL`].
    pub assignments: Vec<Assignment>,
}

/// How long a detector took for a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DetectionTimes {
    /// The first repetition: what a detection takes that sees the scan for the first time.
    pub first: Duration,
    /// The shortest of all repetitions.
    pub least: Duration,
    /// The shortest of all repetitions of the [reference](GridWrite), in turns with the detectors; `None` if it was not timed.
    pub reference: Option<Duration>,
}

/// One scan with what all detectors made of it.
pub struct ScanResults<'a> {
    /// Place of the scan in the run, from 0.
    pub run_idx: usize,
    /// The scan.
    pub scan: &'a LabeledScan,
    /// What each detector made of it, in the order of `detectors`.
    pub results: &'a [DetectorScan],
    /// The detectors, which still hold the stage products of this scan.
    pub detectors: &'a [Box<dyn Detector>],
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The user asked for it.
    #[error("interrupted after {n_done} of {n_scans} scans")]
    Interrupted {
        /// Scans that were done.
        n_done: usize,
        /// Scans that were asked for.
        n_scans: usize,
    },
}

impl SideBySide<'_> {
    /// Runs `detectors` on every scan and hands each scan's results to `on_scan`, in the order of the scans.
    ///
    /// The detectors, and the reference, take turns scan by scan and repetition by repetition, in alternating order, so that a
    /// disturbance of the machine meets all of them.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a scan cannot be read or the run is interrupted, and whatever `on_scan` returns.
    pub fn run<E: From<RunError>>(
        &self,
        detectors: &mut [Box<dyn Detector>],
        on_scan: impl FnMut(ScanResults<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.run_past_damage(detectors, |_, error| Err(error), on_scan)
    }

    /// As [`Self::run`], but of a scan that cannot be read `on_damage` says whether the run goes on without it.
    ///
    /// # Errors
    ///
    /// [`RunError`] if `on_damage` returns the error or the run is interrupted, and whatever `on_scan` returns.
    pub fn run_past_damage<E: From<RunError>>(
        &self,
        detectors: &mut [Box<dyn Detector>],
        mut on_damage: impl FnMut(&ScanId, DatasetError) -> Result<(), DatasetError>,
        mut on_scan: impl FnMut(ScanResults<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut is_warm = false;
        let mut reference = GridWrite::default();
        let mut outputs = vec![DetectorOutput::default(); detectors.len()];
        for (batch_idx, batch) in self.scan_indices.chunks(self.n_jobs.max(1)).enumerate() {
            let scans: Vec<_> = batch.par_iter().map(|&scan_idx| self.dataset.read_scan(scan_idx)).collect();
            for (scan, in_batch_idx) in scans.into_iter().zip(0..) {
                let run_idx = batch_idx * self.n_jobs.max(1) + in_batch_idx;
                let scan = match scan {
                    Ok(scan) => scan,
                    Err(error) => {
                        let id = &self.dataset.scan_ids()[self.scan_indices[run_idx]];
                        on_damage(id, error).map_err(RunError::from)?;
                        continue;
                    }
                };
                if !is_warm {
                    self.warm_up(detectors, &scan);
                    is_warm = true;
                }
                if self.is_interrupted() {
                    let n_scans = self.scan_indices.len();
                    return Err(RunError::Interrupted { n_done: run_idx, n_scans }.into());
                }
                let times = self.detect_all(run_idx, &scan, (detectors, &mut outputs), &mut reference);
                let results = self.results(&scan, (detectors, &outputs), &times);
                on_scan(ScanResults { run_idx, scan: &scan, results: &results, detectors })?;
            }
        }
        Ok(())
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn warm_up(&self, detectors: &mut [Box<dyn Detector>], scan: &LabeledScan) {
        let mut thrown_away = DetectorOutput::default();
        for detector in detectors {
            for _ in (0..self.n_warmup).take_while(|_| !self.is_interrupted()) {
                detector.detect(&scan.cloud, &mut thrown_away);
            }
        }
    }

    /// Fills the outputs of all detectors, and says how long each took.
    fn detect_all(
        &self,
        run_idx: usize,
        scan: &LabeledScan,
        (detectors, outputs): (&mut [Box<dyn Detector>], &mut [DetectorOutput]),
        reference: &mut GridWrite,
    ) -> Vec<DetectionTimes> {
        let mut of_reference = Duration::MAX;
        let mut times: Vec<Vec<Duration>> = vec![Vec::new(); detectors.len()];
        let mut first_stage_times = Vec::new();
        // Once asked to end, what is begun is finished, but not repeated.
        for repeat in (0..self.n_repeats.get()).take_while(|it| *it == 0 || !self.is_interrupted()) {
            let mut order: Vec<Option<usize>> = (0..detectors.len()).map(Some).chain([None]).collect();
            if (run_idx + repeat) % 2 == 1 {
                order.reverse();
            }
            for turn in order {
                let Some(idx) = turn else {
                    of_reference = of_reference.min(reference.time(&scan.cloud));
                    continue;
                };
                let started = Instant::now();
                detectors[idx].detect(&scan.cloud, &mut outputs[idx]);
                times[idx].push(started.elapsed());
            }
            if repeat == 0 {
                first_stage_times = outputs.iter().map(|it| it.stage_times.clone()).collect();
            }
        }
        for (output, stage_times) in outputs.iter_mut().zip(first_stage_times) {
            output.stage_times = stage_times;
        }
        let of_detector = |of_detector: Vec<Duration>| DetectionTimes {
            first: of_detector[0],
            least: of_detector.into_iter().min().unwrap_or_default(),
            reference: Some(of_reference),
        };
        times.into_iter().map(of_detector).collect()
    }

    /// What became of all that was detected.
    fn results(
        &self,
        scan: &LabeledScan,
        (detectors, outputs): (&[Box<dyn Detector>], &[DetectorOutput]),
        times: &[DetectionTimes],
    ) -> Vec<DetectorScan> {
        let annotated = &self.dataset.description().annotated;
        let judge = |output: &DetectorOutput| {
            let of_task = |&task| assign(scan, &output.detections, task, annotated, &self.matching);
            Task::ALL.iter().map(of_task).collect()
        };
        let results = detectors.iter().zip(outputs).zip(times);
        results
            .map(|((detector, output), times)| DetectorScan {
                detector: detector.name(),
                output: output.clone(),
                times: *times,
                assignments: judge(output),
            })
            .collect()
    }
}
