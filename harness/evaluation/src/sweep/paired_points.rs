//! How sure the difference of two points of a sweep is.

use reports::numbers::sums::{FalseObjects, Sums};
use reports::numbers::sweep_score::SweepScore;
use reports::vocabulary::metric::Metric;
use reports::vocabulary::task::Task;

use crate::metrics::counts::FalseDetections;
use crate::sweep::block_resamples::{BlockResamples, OfDataset, difference_interval};
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

    /// The 95 % interval of the rate of the first of two scores of one detector, task and extent minus that of the second;
    /// `None` if a data set has a single block.
    pub fn difference(&self, scores: [&SweepScore; 2]) -> Option<[f64; 2]> {
        let [first, second] = scores.map(|it| self.of_blocks(it));
        difference_interval(&[first?, second?])
    }

    /// The rate of the points that have these `scores` where each block of scans is judged at the point that all other
    /// blocks choose; `None` with fewer than two blocks. No scan has a say in what it is judged at.
    pub fn held_out(&self, scores: &[&SweepScore]) -> Option<f64> {
        let blocks = |score: &&SweepScore| -> Option<Vec<[f64; 2]>> {
            Some(self.of_blocks(score)?.into_iter().flat_map(|it| it.1).collect())
        };
        held_out(&scores.iter().map(blocks).collect::<Option<Vec<_>>>()?)
    }

    /// Numerators and denominators of the rate of `score`, block by block of each data set that it is about.
    fn of_blocks(&self, score: &SweepScore) -> Option<Vec<OfDataset<'_>>> {
        let is_known = score.counts.fo().is_some();
        let metric = if is_known { Metric::FRate } else { Metric::Recall };
        let task_idx = Task::ALL.iter().position(|it| *it == score.task)?;
        let detectors = &self.tally.manifest.detectors;
        let detector_idx = detectors.iter().position(|it| it.name == score.subject.detector)?;
        let terms = |sums: &PointSums| {
            let counts = sums.counts[task_idx].scored(FalseDetections::Known);
            Sums::of_counts(counts).ratio(&metric, FalseObjects::Known).unwrap_or_default()
        };
        let sums_idx = detector_idx * self.tally.entry.points.len() + score.subject.point_idx;
        let of_dataset = |it: &usize| {
            let (resamples, sums) = (&self.resamples[*it], &self.tally.datasets[*it]);
            let of_seconds = sums.of_seconds.iter().map(|(second, it)| (second, terms(&it[sums_idx])));
            (resamples, resamples.of_blocks(of_seconds))
        };
        Some(self.datasets_of(score).iter().map(of_dataset).collect())
    }

    /// Indices of the data sets that a score is about.
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

/// The ratio of sums over blocks of which each is taken from the point that is best on all others; of equal points from the
/// first.
fn held_out(points: &[Vec<[f64; 2]>]) -> Option<f64> {
    let n_blocks = points.first()?.len();
    if n_blocks < 2 {
        return None;
    }
    let sum = |terms: &mut dyn Iterator<Item = &[f64; 2]>| {
        terms.fold([0.0; 2], |sum: [f64; 2], it| [sum[0] + it[0], sum[1] + it[1]])
    };
    let ratio =
        |[numerator, denominator]: [f64; 2]| if denominator > 0.0 { numerator / denominator } else { -1.0 };
    let chosen = |block_idx: usize| {
        let of_others = |it: &Vec<[f64; 2]>| {
            ratio(sum(&mut it.iter().enumerate().filter(|(other, _)| *other != block_idx).map(|(_, it)| it)))
        };
        let rates: Vec<f64> = points.iter().map(of_others).collect();
        let best = (0..points.len()).reduce(|best, it| if rates[it] > rates[best] { it } else { best })?;
        Some(points[best][block_idx])
    };
    let chosen: Vec<[f64; 2]> = (0..n_blocks).map(chosen).collect::<Option<_>>()?;
    Some(ratio(sum(&mut chosen.iter()))).filter(|it| *it >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_block_has_a_say_in_what_it_is_judged_at() {
        // Two points that are alike but for one block each: whoever looks at all three blocks has 3 of 4 on each of two.
        let first = vec![[4.0, 4.0], [0.0, 4.0], [2.0, 4.0]];
        let second = vec![[0.0, 4.0], [4.0, 4.0], [2.0, 4.0]];
        // The others choose the second point for the first block and the first point for the second one.
        assert_eq!(held_out(&[first.clone(), second]), Some(2.0 / 12.0));
        assert_eq!(held_out(std::slice::from_ref(&first)), Some(0.5));
        assert_eq!(held_out(&[vec![[1.0, 2.0]]]), None);
        assert_eq!(held_out(&[]), None);
    }
}
