//! Counting pass: all scans at all points, several scans at once, since counts do not depend on the load of the machine.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use detector::DetectorOutput;
use rayon::prelude::*;
use reports::rows::official_rows::OfficialRows;
use reports::rows::scan_row::ScanRow;
use reports::vocabulary::task::Task;
use scans::dataset::checksum::checksum_as_read;
use scans::dataset::scan_times::{ScanTime, scan_times};
use scans::dataset::{Dataset, DatasetError};

use crate::journal::JournalError;
use crate::matching::assign::assign;
use crate::process::problem::DetectorFailure;
use crate::protocols::chosen_protocols::{ChosenProtocols, ProtocolError};
use crate::run::rows::{RowsOf, scan_row};
use crate::run::scan_in_drive::ScanInDrive;
use crate::run::side_by_side::{DetectionTimes, DetectorScan};
use crate::scan_pass::ScanPassError;
use crate::sweep::cells_of_scan::CellsOfScan;
use crate::sweep::programs::Programs;
use crate::sweep::scan_at_point::ScanAtPoint;
use crate::sweep::sweep_plan::SweepPlan;

/// A data set and the scans that are taken from it.
#[derive(Clone)]
pub struct SweptDataset<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// The selected scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// The part of `scan_indices` that is run: all, or that of a shard.
    pub part: Range<usize>,
}

/// A pass over the scans of a sweep.
#[derive(Clone, Copy)]
pub struct SweepPass<'a> {
    /// The points and detectors.
    pub plan: &'a SweepPlan,
    /// The scans.
    pub datasets: &'a [SweptDataset<'a>],
    /// Official protocols under which it is also evaluated.
    pub protocols: Option<&'a ChosenProtocols>,
    /// Ends the sweep at the next point once it is set.
    pub interrupted: &'a AtomicBool,
}

/// Keeps a result, so that it counts as done.
pub type Keep<'a, T> = &'a (dyn Fn(T) -> Result<(), JournalError> + Sync);

/// Why a sweep ended early. Kept results stay.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A pass over scans ended early.
    #[error(transparent)]
    Scans(#[from] ScanPassError),
    /// A scan could not be evaluated under a protocol.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// A detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
    /// A result could not be kept.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Threads cannot be started.
    #[error("cannot start {n_jobs} threads")]
    Threads {
        /// Number of threads.
        n_jobs: usize,
        /// Cause of the failure.
        source: rayon::ThreadPoolBuildError,
    },
    /// The user interrupted the counting.
    #[error("interrupted after {} of {n_results} results", n_results - n_left)]
    Interrupted {
        /// Pairs of a scan and a point that were not done.
        n_left: usize,
        /// All pairs.
        n_results: usize,
    },
    /// The user interrupted the timing, after the counting.
    #[error("interrupted while detections were timed")]
    InterruptedWhileTimed,
}

impl SweepPass<'_> {
    /// Counts all pairs of a scan and a point that are not `done`, and passes every result to `keep`.
    ///
    /// A scan is read once for all its missing points, by one of `n_jobs` threads.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if a scan cannot be read or evaluated, a detector fails, a result cannot be kept, or the sweep is
    /// interrupted.
    pub fn count(
        &self,
        done: &BTreeSet<[usize; 3]>,
        n_jobs: usize,
        keep: Keep<'_, ScanAtPoint>,
    ) -> Result<(), SweepError> {
        let missing: Vec<MissingScan> = self.missing(done);
        let n_left = AtomicUsize::new(missing.iter().map(|it| it.point_idxs.len()).sum());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_jobs).build();
        let pool = pool.map_err(|source| SweepError::Threads { n_jobs, source })?;
        let programs = Programs::default();
        let times: Vec<Vec<ScanTime>> = self.datasets.iter().map(|it| scan_times(it.dataset)).collect();
        let check_interrupted = || match n_left.load(Ordering::Relaxed) {
            n_left if n_left > 0 && self.interrupted.load(Ordering::Relaxed) => {
                Err(SweepError::Interrupted { n_left, n_results: self.n_results() })
            }
            _ => Ok(()),
        };
        let look = |missing: &MissingScan| {
            check_interrupted()?;
            let scan_idx = self.datasets[missing.dataset_idx].scan_indices[missing.scan_idx];
            self.look(missing, &times[missing.dataset_idx][scan_idx], &programs, |scan| {
                keep(scan)?;
                n_left.fetch_sub(1, Ordering::Relaxed);
                check_interrupted()
            })
        };
        let looked: Vec<Result<(), SweepError>> =
            pool.install(|| missing.par_iter().with_max_len(1).map(look).collect());
        // Collected before errors are searched, so that the first in order is reported.
        looked.into_iter().collect()
    }

    /// Number of pairs of a scan and a point.
    pub fn n_results(&self) -> usize {
        self.datasets.iter().map(|it| it.part.len()).sum::<usize>() * self.plan.points.len()
    }

    fn missing(&self, done: &BTreeSet<[usize; 3]>) -> Vec<MissingScan> {
        let of_dataset = |(dataset_idx, it): (usize, &SweptDataset<'_>)| {
            it.part.clone().map(move |scan_idx| (dataset_idx, scan_idx))
        };
        let scans = self.datasets.iter().enumerate().flat_map(of_dataset);
        let missing = scans.map(|(dataset_idx, scan_idx)| {
            let is_missing = |point_idx: &usize| !done.contains(&[dataset_idx, scan_idx, *point_idx]);
            let point_idxs = (0..self.plan.points.len()).filter(is_missing).collect();
            MissingScan { dataset_idx, scan_idx, point_idxs }
        });
        missing.filter(|it| !it.point_idxs.is_empty()).collect()
    }

    fn look(
        &self,
        missing: &MissingScan,
        time: &ScanTime,
        programs: &Programs,
        on_result: impl Fn(ScanAtPoint) -> Result<(), SweepError>,
    ) -> Result<(), SweepError> {
        let &MissingScan { dataset_idx, scan_idx, ref point_idxs } = missing;
        let SweptDataset { dataset, scan_indices, .. } = self.datasets[dataset_idx];
        let description = dataset.description();
        let scan = dataset.read_scan(scan_indices[scan_idx])?;
        let under_protocols =
            self.protocols.map(|it| it.scan(dataset, scan_indices[scan_idx], &scan)).transpose()?;
        let of_scan = RowsOf { scan: &scan, checksum: checksum_as_read(&scan), time_s: time.known_s };
        let mut cells_of_scan = CellsOfScan::default();
        for &point_idx in point_idxs {
            let config = self.plan.points[point_idx].config.for_scans_of(description);
            let (mut official, mut scans, mut cells) = (OfficialRows::default(), Vec::new(), Vec::new());
            programs.at_point(self.plan, point_idx, description, |compared_detector, detector| {
                let mut result = DetectorScan {
                    detector: compared_detector.name,
                    output: DetectorOutput::default(),
                    times: DetectionTimes::default(),
                    failure: None,
                    assignments: Vec::new(),
                };
                let asked = ScanInDrive::anywhere(&scan, time.time_s, dataset, scan_indices[scan_idx]);
                detector.detect(&asked, &mut result.output)?;
                if let Some(it) = &under_protocols {
                    official.append(it.rows(compared_detector.name, detector, &result.output));
                }
                let entrant = self.plan.entrant(compared_detector.name, point_idx);
                for task in Task::ALL {
                    let detections = &result.output.detections;
                    let assignment =
                        assign(&scan, detections, task, &description.annotated, &config.matching);
                    let row = scan_row(description, of_scan, &result, &assignment);
                    scans.push(ScanRow { detector: entrant.clone(), ..row.as_written() });
                }
                cells.push(cells_of_scan.tally(&scan, &compared_detector.chosen, &config));
                Ok(())
            })?;
            on_result(ScanAtPoint { dataset_idx, scan_idx, point_idx, scans, cells, official })?;
        }
        Ok(())
    }
}

/// A scan, and its missing points.
struct MissingScan {
    dataset_idx: usize,
    scan_idx: usize,
    point_idxs: Vec<usize>,
}
