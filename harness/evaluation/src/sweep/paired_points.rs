//! How sure the difference of two points of a sweep is.

use reports::numbers::sums::{FalseObjects, Sums};
use reports::numbers::sweep_score::SweepScore;
use reports::vocabulary::metric::Metric;
use reports::vocabulary::task::Task;

use crate::metrics::counts::FalseDetections;
use crate::sweep::block_resamples::{BlockResamples, difference_interval};
use crate::sweep::sweep_tally::{PointSums, SweepTally};

/// The points of a sweep, and draws of its scans that all of them share.
pub struct PairedPoints<'a> {
    tally: &'a SweepTally<'a>,
    // Of each data set.
    resamples: Vec<BlockResamples>,
}

impl<'a> PairedPoints<'a> {
    /// Draws the scans of `tally`.
    pub fn draw(tally: &'a SweepTally<'a>) -> Self {
        let datasets = tally.manifest.datasets.iter().zip(&tally.datasets);
        let draw = datasets.map(|(entry, it)| BlockResamples::draw(&entry.id, it.of_seconds.keys().cloned()));
        Self { tally, resamples: draw.collect() }
    }

    /// The 95 % interval of the rate of the first of two scores of one detector, task and extent minus that of the second; `None` if a
    /// data set has a single block.
    pub fn difference(&self, scores: [&SweepScore; 2]) -> Option<[f64; 2]> {
        let [first, _] = scores;
        let is_known = first.counts.fo().is_some();
        let metric = if is_known { Metric::FRate } else { Metric::Recall };
        let task_idx = Task::ALL.iter().position(|it| *it == first.task)?;
        let detectors = &self.tally.manifest.detectors;
        let detector_idx = detectors.iter().position(|it| it.name == first.subject.detector)?;
        let terms = |sums: &PointSums| {
            let counts = sums.counts[task_idx].scored(FalseDetections::Known);
            Sums::of_counts(counts).ratio(&metric, FalseObjects::Known).unwrap_or_default()
        };
        let of_sides = scores.map(|score| {
            let sums_idx = detector_idx * self.tally.entry.points.len() + score.subject.point_idx;
            let of_dataset = |it: &usize| {
                let (resamples, sums) = (&self.resamples[*it], &self.tally.datasets[*it]);
                let of_seconds = sums.of_seconds.iter().map(|(second, it)| (second, terms(&it[sums_idx])));
                (resamples, resamples.of_blocks(of_seconds))
            };
            self.datasets_of(score).iter().map(of_dataset).collect::<Vec<_>>()
        });
        difference_interval(&of_sides)
    }

    /// Places of the data sets that a score is about.
    fn datasets_of(&self, score: &SweepScore) -> Vec<usize> {
        let manifest = self.tally.manifest;
        let extent = &score.subject.extent;
        let pool = manifest.pools().into_iter().find(|it| it.extent == *extent);
        let is_in_it = |id: &String| {
            pool.as_ref().map_or_else(|| extent.name() == id, |pool| pool.datasets.contains(id))
        };
        (0..manifest.datasets.len()).filter(|it| is_in_it(&manifest.datasets[*it].id)).collect()
    }
}
