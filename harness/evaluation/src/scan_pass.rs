//! A pass over the scans of a data set, several scans at once.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use scans::annotation::LabeledScan;
use scans::dataset::{Dataset, DatasetError};

/// A pass over scans of a data set.
#[derive(Clone, Copy)]
pub struct ScanPass<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// Indices of the scans to pass over.
    pub scan_indices: &'a [usize],
    /// Ends the pass before the next scan once it is set.
    pub interrupted: &'a AtomicBool,
    /// Called after every scan, from several threads.
    pub on_scan: &'a (dyn Fn() + Sync),
}

/// Why a pass ended early.
#[derive(Debug, thiserror::Error)]
pub enum ScanPassError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The user asked for it.
    #[error("interrupted while measuring the {n_scans} scans of {dataset:?}")]
    Interrupted {
        /// The data set.
        dataset: String,
        /// Scans that were asked for.
        n_scans: usize,
    },
}

/// A scan and its index among those of its data set.
#[derive(Debug, Clone, Copy)]
pub struct PassedScan<'a> {
    /// Its index.
    pub scan_idx: usize,
    /// The scan.
    pub scan: &'a LabeledScan,
}

impl ScanPass<'_> {
    /// Results of `look` for each scan, in their order. Every thread has its own state, made by `new_state`.
    ///
    /// # Errors
    ///
    /// [`ScanPassError`] if a scan cannot be read (the first such scan), or if the pass is interrupted.
    pub fn over<S, T: Send>(
        &self,
        new_state: impl Fn() -> S + Sync + Send,
        look: impl Fn(&mut S, PassedScan<'_>) -> T + Sync + Send,
    ) -> Result<Vec<T>, ScanPassError> {
        let of_scan = |state: &mut S, &scan_idx: &usize| {
            if self.interrupted.load(Ordering::Relaxed) {
                let (dataset, n_scans) = (self.dataset.description().id.clone(), self.scan_indices.len());
                return Err(ScanPassError::Interrupted { dataset, n_scans });
            }
            let seen = look(state, PassedScan { scan_idx, scan: &self.dataset.read_scan(scan_idx)? });
            (self.on_scan)();
            Ok(seen)
        };
        // Collected before errors are searched, so that the first in order is reported.
        let of_scans: Vec<_> = self.scan_indices.par_iter().map_init(new_state, of_scan).collect();
        of_scans.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    /// The numbers of points of scans 2 and 0 of a street, and how many scans were counted.
    fn seen(n_threads: usize, interrupted: bool) -> (Result<Vec<(usize, usize)>, ScanPassError>, usize) {
        let options = OpenOptions { sensor: Some("vlp-16".to_owned()), ..OpenOptions::default() };
        let street = open_dataset("street-main-road", &options, &built_in_catalogue().unwrap()).unwrap();
        let n_seen = AtomicUsize::new(0);
        let on_scan = || {
            n_seen.fetch_add(1, Ordering::Relaxed);
        };
        let interrupted = AtomicBool::new(interrupted);
        let pass = ScanPass {
            dataset: &*street,
            scan_indices: &[2, 0],
            interrupted: &interrupted,
            on_scan: &on_scan,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let look = |(): &mut (), it: PassedScan<'_>| (it.scan_idx, it.scan.cloud.len());
        let seen = pool.install(|| pass.over(|| (), look));
        (seen, n_seen.into_inner())
    }

    #[test]
    fn scans_are_seen_in_order_whatever_the_number_of_threads() {
        let (one, n_seen) = seen(1, false);
        let one = one.unwrap();
        assert_eq!((one[0].0, one[1].0, n_seen), (2, 0, 2));
        assert_ne!(one[0].1, one[1].1);
        assert_eq!(one, seen(3, false).0.unwrap());
    }

    #[test]
    fn an_interruption_ends_the_pass_before_a_scan() {
        let (error, n_seen) = seen(1, true);
        let error = error.unwrap_err();
        assert!(matches!(error, ScanPassError::Interrupted { n_scans: 2, .. }), "{error}");
        assert_eq!(n_seen, 0);
    }
}
