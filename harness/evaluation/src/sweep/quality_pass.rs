//! All scans at all points, several scans at once: what is counted does not depend on what runs beside it.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;
use scans::dataset::scan_times::{ScanTime, scan_times};
use scans::dataset::{Dataset, DatasetError};

use crate::journal::{Journal, JournalError};
use crate::process::problem::DetectorFailure;
use crate::protocols::chosen_protocols::{ChosenProtocols, ProtocolError};
use crate::sweep::journal_entry::JournalEntry;
use crate::sweep::programs::Programs;
use crate::sweep::scan_at_point::{LookedAt, ScanAtPoint, look_at_points};
use crate::sweep::sweep_plan::SweepPlan;

/// A data set and the scans that are taken from it.
#[derive(Clone)]
pub struct SweptDataset<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// Which of its scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// Which of these are run, as indices among them: all, or those of a shard.
    pub part: Range<usize>,
}

/// What is run, and where it is reported.
#[derive(Clone, Copy)]
pub struct SweepPass<'a> {
    /// The points and detectors.
    pub plan: &'a SweepPlan,
    /// The scans.
    pub datasets: &'a [SweptDataset<'a>],
    /// What else it is evaluated by, if anything.
    pub protocols: Option<&'a ChosenProtocols>,
    /// Where results are kept.
    pub journal: &'a Journal,
    /// Ends the sweep at the next point once it is set.
    pub interrupted: &'a AtomicBool,
    /// Called whenever a scan has been looked at, at one point.
    pub on_done: &'a (dyn Fn() + Sync),
    /// The processor's own name, for times.
    pub processor: &'a str,
}

/// Why a sweep ended early. What is in the journal stays.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A scan could not be evaluated under a protocol.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// A detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
    /// A result could not be kept.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// No more threads.
    #[error("cannot start {n_jobs} threads")]
    Threads {
        /// How many were asked for.
        n_jobs: usize,
        /// What the operating system said.
        source: rayon::ThreadPoolBuildError,
    },
    /// The user asked for it.
    #[error("interrupted after {} of {n_results} results", n_results - n_left)]
    Interrupted {
        /// Pairs of a scan and a point that were not done.
        n_left: usize,
        /// All of them.
        n_results: usize,
    },
    /// The user asked for it when all was counted.
    #[error("interrupted while detections were timed")]
    InterruptedWhileTimed,
}

impl SweepPass<'_> {
    /// Does all but the `done`, and leaves it in the journal.
    ///
    /// A scan is read once for all points that are missing, by one of `n_jobs` threads.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if a scan cannot be read, a result cannot be kept, or the sweep is interrupted.
    pub fn count(&self, done: &BTreeSet<[usize; 3]>, n_jobs: usize) -> Result<(), SweepError> {
        let missing: Vec<MissingScan> = self.missing(done);
        let n_left = AtomicUsize::new(missing.iter().map(|it| it.point_idxs.len()).sum());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_jobs).build();
        let pool = pool.map_err(|source| SweepError::Threads { n_jobs, source })?;
        let programs = Programs::default();
        let times: Vec<Vec<ScanTime>> = self.datasets.iter().map(|it| scan_times(it.dataset)).collect();
        let look = |missing: &MissingScan| {
            let scan_idx = self.datasets[missing.dataset_idx].scan_indices[missing.scan_idx];
            self.look(missing, &times[missing.dataset_idx][scan_idx], &programs, &n_left)
        };
        let looked: Vec<Result<(), SweepError>> =
            pool.install(|| missing.par_iter().with_max_len(1).map(look).collect());
        // Collected before it is looked through for errors, so that the first in order is reported.
        looked.into_iter().collect()
    }

    /// Pairs of a scan and a point.
    pub fn n_results(&self) -> usize {
        self.datasets.iter().map(|it| it.part.len()).sum::<usize>() * self.plan.points.len()
    }

    fn missing(&self, done: &BTreeSet<[usize; 3]>) -> Vec<MissingScan> {
        let scans = self
            .datasets
            .iter()
            .enumerate()
            .flat_map(|(dataset_idx, it)| it.part.clone().map(move |scan_idx| (dataset_idx, scan_idx)));
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
        n_left: &AtomicUsize,
    ) -> Result<(), SweepError> {
        let &MissingScan { dataset_idx, scan_idx, ref point_idxs } = missing;
        let SweptDataset { dataset, scan_indices, .. } = self.datasets[dataset_idx];
        self.check_interrupted(n_left)?;
        let scan = dataset.read_scan(scan_indices[scan_idx])?;
        let official = match self.protocols {
            Some(it) => Some(it.scan(dataset, scan_indices[scan_idx], &scan)?),
            None => None,
        };
        let looked_at = LookedAt { scan: &scan, time_s: time.time_s, official: official.as_ref() };
        look_at_points(
            self.plan,
            programs,
            dataset.description(),
            looked_at,
            point_idxs,
            |point_idx, detectors, official| {
                let (sequence, second) = (scan.id.sequence.clone(), time.second.clone());
                self.journal.add(&JournalEntry::Quality(ScanAtPoint {
                    dataset_idx,
                    scan_idx,
                    scan: scan.id.index,
                    sequence,
                    second,
                    point_idx,
                    detectors,
                    official,
                }))?;
                n_left.fetch_sub(1, Ordering::Relaxed);
                (self.on_done)();
                self.check_interrupted(n_left)
            },
        )
    }

    fn check_interrupted(&self, n_left: &AtomicUsize) -> Result<(), SweepError> {
        let n_left = n_left.load(Ordering::Relaxed);
        if self.interrupted.load(Ordering::Relaxed) && n_left > 0 {
            return Err(SweepError::Interrupted { n_left, n_results: self.n_results() });
        }
        Ok(())
    }
}

/// A scan, and the points at which it has not been looked at.
struct MissingScan {
    dataset_idx: usize,
    scan_idx: usize,
    point_idxs: Vec<usize>,
}
