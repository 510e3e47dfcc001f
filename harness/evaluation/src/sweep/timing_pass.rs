//! Some scans at all points once more, one after the other with nothing running beside, for the clock alone.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::time::Duration;

use detector::DetectorOutput;

use crate::run::entrant::Entrant;
use crate::sweep::journal_entry::{JournalEntry, TimedScan};
use crate::sweep::programs::Programs;
use crate::sweep::quality_pass::{SweepError, SweepPass};

/// Detections of a scan at a point that are timed, after one that is not.
pub const DETECTIONS_PER_SCAN: usize = 3;

impl SweepPass<'_> {
    /// Times `n_scans` scans of each data set, spread over it, that are in its part, but for the `done`, and leaves it in
    /// the journal.
    ///
    /// Of every other scan the points come in the opposite order, so that a disturbance of the machine meets all of them.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if a scan cannot be read, a result cannot be kept, or the sweep is interrupted.
    pub fn time(&self, done: &BTreeSet<(usize, usize)>, n_scans: usize) -> Result<(), SweepError> {
        let programs = Programs::default();
        for (index, scan) in self.timed_scans(n_scans) {
            if !done.contains(&scan) {
                self.journal.add(&JournalEntry::Times(self.time_scan(scan.0, scan.1, index, &programs)?))?;
            }
        }
        Ok(())
    }

    /// The scans that are timed, data set and scan, each with its index among those of the whole sweep.
    pub fn timed_scans(&self, n_scans: usize) -> Vec<(usize, (usize, usize))> {
        let of_dataset = |(dataset_idx, n_all): (usize, usize)| {
            let n_timed = n_scans.min(n_all);
            // The middles of as many stretches.
            (0..n_timed).map(move |it| (dataset_idx, (2 * it + 1) * n_all / (2 * n_timed)))
        };
        let all = self.datasets.iter().map(|it| it.scan_indices.len()).enumerate().flat_map(of_dataset);
        let is_ours = |(_, (dataset_idx, scan_idx)): &(usize, (usize, usize))| {
            self.datasets[*dataset_idx].part.contains(scan_idx)
        };
        all.enumerate().filter(is_ours).collect()
    }

    fn time_scan(
        &self,
        dataset_idx: usize,
        scan_idx: usize,
        index: usize,
        programs: &Programs,
    ) -> Result<TimedScan, SweepError> {
        let swept = &self.datasets[dataset_idx];
        let description = swept.dataset.description();
        let scan = swept.dataset.read_scan(swept.scan_indices[scan_idx])?;
        let n_points = self.plan.points.len();
        let mut times_ns = vec![Vec::new(); n_points];
        let mut output = DetectorOutput::default();
        for step in 0..n_points {
            let point_idx = if index.is_multiple_of(2) { step } else { n_points - 1 - step };
            for chosen in &self.plan.detectors {
                if self.interrupted.load(Ordering::Relaxed) {
                    // The whole scan is timed again, so that its points are timed side by side.
                    return Err(SweepError::InterruptedWhileTimed);
                }
                let entrant = Entrant::of(chosen.clone(), &self.plan.points[point_idx].config);
                let program = programs.take(description, entrant.name);
                let begun = entrant.begin_with(description, program);
                let mut detector = begun.map_err(|it| self.plan.at_point(point_idx, it))?;
                let at_point = |it| self.plan.at_point(point_idx, it);
                detector.detect(&scan, 0.0, &mut output).map_err(at_point)?;
                let mut detect = |_| {
                    let taken = detector.detect(&scan, 0.0, &mut output)?;
                    Ok(nanoseconds(taken.wall.unwrap_or_default()))
                };
                let of_point =
                    (0..DETECTIONS_PER_SCAN).map(&mut detect).collect::<Result<_, SweepError>>()?;
                times_ns[point_idx].push(of_point);
                programs.put_back(description, entrant.name, detector);
                (self.on_done)();
            }
        }
        Ok(TimedScan { dataset_idx, scan_idx, processor: self.processor.to_owned(), times_ns })
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
