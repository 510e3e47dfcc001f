//! Sums of a run: of its scans and of every resample of them.

use crate::numbers::blocks::{BlockCount, Blocks, DriveSecond, Interval};
use crate::numbers::sums::{FalseObjects, Sums};
use crate::numbers::tally::Tally;
use crate::uncertainty::bootstrap::{Distribution, Resamples};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// The blocks of a data set, and how often each is drawn.
#[derive(Debug, Clone)]
pub struct Draw {
    pub(crate) blocks: Blocks,
    pub(crate) resamples: Resamples,
}

impl Draw {
    /// The blocks that are drawn.
    pub fn blocks(&self) -> BlockCount {
        self.blocks.count()
    }

    /// Adds the terms of a ratio to those of each resample: numerators and denominators by second of a drive.
    ///
    /// # Panics
    ///
    /// If a second is in no block.
    pub fn add_terms<'a>(
        &self,
        of_seconds: impl Iterator<Item = (&'a DriveSecond, [f64; 2])>,
        resampled: &mut [[f64; 2]],
    ) {
        let mut of_blocks = vec![[0.0; 2]; self.blocks.len()];
        for (second, terms) in of_seconds {
            let block_idx = self.blocks.index_of(second).expect("the blocks are of these seconds");
            of_blocks[block_idx] = [0, 1].map(|it| of_blocks[block_idx][it] + terms[it]);
        }
        self.resamples.add_terms(&of_blocks, resampled);
    }
}

/// Sums of one subject: of its scans and of every resample of them.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Number of scans.
    pub n_scans: u64,
    /// The blocks that were drawn from.
    pub blocks: BlockCount,
    /// Whether all false objects are known.
    pub false_objects: FalseObjects,
    /// Slice that the sums are of.
    pub slice: Slice,
    /// The sums themselves.
    pub total: Sums,
    /// The sums of each resample.
    pub resampled: Vec<Sums>,
}

/// Subject of a query to a tally: a data set or several, a task, a detector, a slice.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// Id of the data set, or the name of several together: that of their [`Extent`](crate::vocabulary::extent::Extent).
    pub dataset: &'a str,
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: &'a str,
    /// The slice.
    pub slice: Slice,
}

impl Tally {
    /// The draws for each data set, in order.
    pub fn draw(&self) -> Vec<Draw> {
        let of_datasets = self.datasets().iter().zip(self.blocks());
        let draw = |(dataset, blocks): (&String, Blocks)| Draw {
            resamples: Resamples::draw(dataset, blocks.count()),
            blocks,
        };
        of_datasets.map(draw).collect()
    }

    /// The blocks of each data set without any resample, for numbers that need no interval.
    pub(crate) fn undrawn(&self) -> Vec<Draw> {
        let of_blocks = self.blocks().into_iter();
        of_blocks.map(|blocks| Draw { resamples: Resamples::none(blocks.count()), blocks }).collect()
    }

    /// The sums that answer `question`; `None` if no data set has any.
    pub fn sample(&self, question: &Question<'_>, draws: &[Draw]) -> Option<Sample> {
        let mut all: Option<Sample> = None;
        for dataset_idx in self.datasets_in(question.dataset) {
            let Some(draw) = draws.get(dataset_idx) else { continue };
            let Some(sample) = self.sample_of(dataset_idx, question, draw) else { continue };
            all = Some(match all {
                Some(sum) => sum.with(&sample),
                None => sample,
            });
        }
        all
    }

    /// The terms of a ratio in each block that is drawn, data set by data set.
    pub fn terms_of_blocks(&self, question: &Question<'_>, metric: &Metric, draws: &[Draw]) -> Vec<[f64; 2]> {
        let mut terms = Vec::new();
        for dataset_idx in self.datasets_in(question.dataset) {
            let gathered = self.gathered(dataset_idx, question.task, question.detector);
            let Some((gathered, draw)) = gathered.zip(draws.get(dataset_idx)) else { continue };
            let placed = gathered.sums_of_blocks(&question.slice, &draw.blocks);
            let ratio = |sums: &Sums| sums.ratio(metric, gathered.false_objects).unwrap_or_default();
            terms.extend(placed.iter().map(|(_, sums)| ratio(sums)));
        }
        terms
    }

    fn sample_of(&self, dataset_idx: usize, question: &Question<'_>, draw: &Draw) -> Option<Sample> {
        let gathered = self.gathered(dataset_idx, question.task, question.detector)?;
        let placed = gathered.sums_of_blocks(&question.slice, &draw.blocks);
        let mut total = Sums::default();
        for (_, sums) in &placed {
            total.add_times(sums, 1.0);
        }
        Some(Sample {
            n_scans: gathered.n_scans,
            blocks: draw.blocks.count(),
            false_objects: gathered.false_objects,
            slice: question.slice,
            total,
            resampled: draw.resamples.sums(&placed),
        })
    }
}

impl Sample {
    /// Both samples together; false objects are known only if they are in both.
    fn with(mut self, other: &Self) -> Self {
        self.n_scans += other.n_scans;
        self.blocks = self.blocks.with(other.blocks);
        self.total.add_times(&other.total, 1.0);
        for (sum, it) in self.resampled.iter_mut().zip(&other.resampled) {
            sum.add_times(it, 1.0);
        }
        if other.false_objects == FalseObjects::Unknown {
            self.false_objects = FalseObjects::Unknown;
        }
        self
    }

    /// The value of `metric`; `None` if it is undefined or not measured for the slice.
    pub fn value(&self, metric: &Metric) -> Option<f64> {
        self.total.value(metric.formula(), self.false_objects).filter(|_| self.slice.measures(metric))
    }

    /// The value of `metric` in each resample.
    pub fn resampled_values(&self, metric: &Metric) -> impl Iterator<Item = Option<f64>> {
        let formula = metric.formula();
        self.resampled.iter().map(move |sums| sums.value(formula, self.false_objects))
    }

    /// The 95 % interval of `metric`; `None` if it is undefined in too many resamples, or a data set has a single block.
    pub fn interval(&self, metric: &Metric) -> Option<Interval> {
        Some(Distribution::new(self.resampled_values(metric), self.blocks)?.interval())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::counts::Counts;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
    use crate::uncertainty::bootstrap::N_RESAMPLES;

    #[test]
    fn terms_of_any_ratio_are_drawn_as_counts_are() {
        let mut tally = Tally::default().with_detectors(["other", "mine"].map(str::to_owned).to_vec());
        let seconds: Vec<DriveSecond> = (0..12).map(|it| DriveSecond::of("0000", f64::from(it))).collect();
        let terms = || seconds.iter().zip(0..).map(|(second, scan)| (second, [f64::from(scan % 5), 4.0]));
        for ((_, [found, _]), scan) in terms().zip(0..) {
            let [dataset, sequence] = ["street", "0000"].map(str::to_owned);
            let counts = Counts::new(4, found as u64, None).unwrap();
            tally.add_scan(&ScanRow {
                dataset,
                sequence,
                scan,
                time_s: Some(f64::from(scan)),
                detector: "mine".to_owned(),
                task: Task::Objects,
                outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(counts)),
            });
        }
        let draws = tally.draw();
        let question =
            |detector| Question { dataset: "street", task: Task::Objects, detector, slice: Slice::All };
        let sample = tally.sample(&question("mine"), &draws).unwrap();
        assert_eq!((sample.n_scans, sample.blocks.n_blocks), (12, 12));
        let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
        draws[0].add_terms(terms(), &mut resampled);
        let ratios = resampled.iter().map(|it| Some(it[0] / it[1]));
        assert!(sample.resampled_values(&Metric::Recall).eq(ratios));
        let of_blocks = tally.terms_of_blocks(&question("mine"), &Metric::Recall, &draws);
        assert_eq!(of_blocks, terms().map(|it| it.1).collect::<Vec<_>>());
        assert!(sample.interval(&Metric::Recall).is_some() && sample.interval(&Metric::FRate).is_none());
        assert!(tally.sample(&question("other"), &draws).is_none());
    }
}
