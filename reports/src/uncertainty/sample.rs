//! Sums of a run, as they are and as they would be had other scans been drawn.

use crate::numbers::blocks::{BlockCount, Blocks};
use crate::numbers::sums::{FalseObjects, Sums};
use crate::numbers::tally::Tally;
use crate::uncertainty::bootstrap::Resamples;
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
}

/// Sums of one subject, as they are and as they would be had other scans been drawn.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Number of scans.
    pub n_scans: u64,
    /// The blocks that were drawn from.
    pub blocks: BlockCount,
    /// Whether all false objects are known.
    pub false_objects: FalseObjects,
    /// What the sums are of.
    pub slice: Slice,
    /// The sums themselves.
    pub total: Sums,
    /// Those of each resample.
    pub resampled: Vec<Sums>,
}

/// What a tally has been asked about: a data set or several, a task, a detector, a slice.
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

    /// The same without any resample, where only the numbers themselves matter.
    pub(crate) fn undrawn(&self) -> Vec<Draw> {
        let of_blocks = self.blocks().into_iter();
        of_blocks.map(|blocks| Draw { resamples: Resamples::none(blocks.count()), blocks }).collect()
    }

    /// The sums that are asked for; `None` if nothing was seen of the kind.
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
    /// Both together; false objects are known only where they are in both.
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

    /// The value of `metric`; `None` if it is undefined, or not measured of the slice.
    pub fn value(&self, metric: &Metric) -> Option<f64> {
        self.total.value(metric.formula(), self.false_objects).filter(|_| self.slice.measures(metric))
    }

    /// The value of `metric` in each resample.
    pub fn resampled_values(&self, metric: &Metric) -> impl Iterator<Item = Option<f64>> {
        let formula = metric.formula();
        self.resampled.iter().map(move |sums| sums.value(formula, self.false_objects))
    }
}
