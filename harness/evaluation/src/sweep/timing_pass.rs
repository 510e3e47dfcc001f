//! Timing pass: some scans once more at all points, one after the other, with nothing else running.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::time::Duration;

use detector::DetectorOutput;

use crate::run::scan_in_drive::ScanInDrive;
use crate::sweep::programs::Programs;
use crate::sweep::quality_pass::{Keep, SweepError, SweepPass, SweptDataset};
use crate::sweep::scan_at_point::TimedScan;

/// Number of timed detections of a scan at a point, after one that is not timed.
pub const DETECTIONS_PER_SCAN: usize = 3;

impl SweepPass<'_> {
    /// Times, on `processor`, those of `n_scans` scans spread over each data set that are in its part and not `done`. Passes
    /// each to `keep`. `on_done` is called whenever a detector was timed at a point.
    ///
    /// For every other scan the points come in the opposite order, so that a disturbance of the machine affects all points.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if a scan cannot be read, a detector fails, a result cannot be kept, or the sweep is interrupted.
    pub fn time(
        &self,
        done: &BTreeSet<(usize, usize)>,
        n_scans: usize,
        processor: &str,
        on_done: impl Fn(),
        keep: Keep<'_, TimedScan>,
    ) -> Result<(), SweepError> {
        let programs = Programs::default();
        for (index, (dataset_idx, scan_idx)) in self.timed_scans(n_scans) {
            if !done.contains(&(dataset_idx, scan_idx)) {
                let times_ns = self.times_ns(dataset_idx, scan_idx, index, &programs, &on_done)?;
                keep(TimedScan { dataset_idx, scan_idx, processor: processor.to_owned(), times_ns })?;
            }
        }
        Ok(())
    }

    /// The scans of this part that are timed: index among the timed scans of the whole sweep, and the indices of data set
    /// and scan.
    pub fn timed_scans(&self, n_scans: usize) -> Vec<(usize, (usize, usize))> {
        let of_dataset = |(dataset_idx, n_all): (usize, usize)| {
            let n_timed = n_scans.min(n_all);
            // The middles of `n_timed` equal stretches.
            (0..n_timed).map(move |it| (dataset_idx, (2 * it + 1) * n_all / (2 * n_timed)))
        };
        let all = self.datasets.iter().map(|it| it.scan_indices.len()).enumerate().flat_map(of_dataset);
        let is_ours = |(_, (dataset_idx, scan_idx)): &(usize, (usize, usize))| {
            self.datasets[*dataset_idx].part.contains(scan_idx)
        };
        all.enumerate().filter(is_ours).collect()
    }

    /// Times of a scan; `index` is its index among the timed scans.
    fn times_ns(
        &self,
        dataset_idx: usize,
        scan_idx: usize,
        index: usize,
        programs: &Programs,
        on_done: impl Fn(),
    ) -> Result<Vec<Vec<Vec<u64>>>, SweepError> {
        let SweptDataset { dataset, scan_indices, .. } = self.datasets[dataset_idx];
        let scan = dataset.read_scan(scan_indices[scan_idx])?;
        let n_points = self.plan.points.len();
        let mut times_ns = vec![Vec::new(); n_points];
        let mut output = DetectorOutput::default();
        for step in 0..n_points {
            let point_idx = if index.is_multiple_of(2) { step } else { n_points - 1 - step };
            if self.interrupted.load(Ordering::Relaxed) {
                // The whole scan is timed again, so that its points are timed side by side.
                return Err(SweepError::InterruptedWhileTimed);
            }
            let description = dataset.description();
            times_ns[point_idx] = programs.at_point(self.plan, point_idx, description, |_, detector| {
                let asked = ScanInDrive::anywhere(&scan, 0.0, dataset, scan_indices[scan_idx]);
                detector.detect(&asked, &mut output)?;
                let detect = |_| {
                    let taken = detector.detect(&asked, &mut output)?;
                    Ok(nanoseconds(taken.wall.unwrap_or_default()))
                };
                let times = (0..DETECTIONS_PER_SCAN).map(detect).collect();
                on_done();
                times
            })?;
        }
        Ok(times_ns)
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
