//! The uncertainty of numbers: how they vary when other scans are drawn.
//!
//! Neighbouring scans show the same objects, so whole [blocks](crate::numbers::blocks) of scans are drawn, with replacement,
//! as many as there are. Every ratio is computed again from the sums of the drawn blocks.
//!
//! Resamples of few blocks vary too little: their variance is (n − 1) / n of the right one, and the ends of a percentile
//! interval are those of a normal distribution where they should be those of Student's. So percentiles farther out are
//! taken.
//!
//! Efron, Tibshirani: An Introduction to the Bootstrap, 1993: percentile intervals of clusters. Hesterberg: What Teachers
//! Should Know About the Bootstrap, The American Statistician 69, 2015, section 3.2 and its "expanded percentile interval".

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};

use crate::numbers::blocks::{BlockCount, Interval};
use crate::numbers::sums::Sums;

/// Number of times that scans are drawn.
pub const N_RESAMPLES: usize = 10_000;
/// Seed of the draws.
pub const SEED: u64 = 1;

/// How often each block of a data set was drawn, for each resample.
#[derive(Debug, Clone)]
pub struct Resamples {
    blocks: BlockCount,
    // Resample by resample, a number for each block.
    times_drawn: Vec<u16>,
}

impl Resamples {
    /// Draws from the `blocks` of `dataset`.
    ///
    /// The draws depend on the data set alone, not on the rest of the run or the number of threads. So numbers of
    /// different detectors, or of different runs over the same scans, have the same draws.
    pub fn draw(dataset: &str, blocks: BlockCount) -> Self {
        Self::first(N_RESAMPLES, dataset, blocks)
    }

    /// The first `n_resamples` of these draws, for numbers that take long to compute.
    pub fn first(n_resamples: usize, dataset: &str, blocks: BlockCount) -> Self {
        let n_blocks = blocks.n_blocks as usize;
        let mut times_drawn = vec![0_u16; n_resamples * n_blocks];
        let seed = SEED ^ fingerprint(dataset);
        if n_blocks > 0 {
            times_drawn.par_chunks_mut(n_blocks).enumerate().for_each(|(resample_idx, times_drawn)| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(resample_idx as u64);
                for _ in 0..n_blocks {
                    let block_idx = rng.random_range(0..n_blocks);
                    times_drawn[block_idx] = times_drawn[block_idx].saturating_add(1);
                }
            });
        }
        Self { blocks, times_drawn }
    }

    /// No resample of the `blocks`.
    pub fn none(blocks: BlockCount) -> Self {
        Self { blocks, times_drawn: Vec::new() }
    }

    /// The blocks that are drawn from.
    pub fn blocks(&self) -> BlockCount {
        self.blocks
    }

    /// How often each block was drawn for resample `resample_idx`.
    pub fn times_drawn(&self, resample_idx: usize) -> &[u16] {
        let n_blocks = self.blocks.n_blocks as usize;
        &self.times_drawn[resample_idx * n_blocks..][..n_blocks]
    }

    /// How often each block was drawn, resample by resample.
    pub fn all_times_drawn(&self) -> impl Iterator<Item = &[u16]> {
        self.times_drawn.chunks(self.chunk_len())
    }

    /// The sums of each resample. `of_blocks` holds sums by index of their block; those of other blocks are zero.
    pub fn sums(&self, of_blocks: &[(usize, Sums)]) -> Vec<Sums> {
        let sum = |times_drawn: &[u16]| {
            let mut sum = Sums::default();
            for (block_idx, of_block) in of_blocks {
                let times = times_drawn[*block_idx];
                if times > 0 {
                    sum.add_times(of_block, f64::from(times));
                }
            }
            sum
        };
        self.times_drawn.par_chunks(self.chunk_len()).map(sum).collect()
    }

    /// Adds numerator and denominator of a ratio, a pair for every block, to the pairs of each resample.
    pub fn add_terms(&self, of_blocks: &[[f64; 2]], resampled: &mut [[f64; 2]]) {
        for (sum, times_drawn) in resampled.iter_mut().zip(self.times_drawn.chunks(self.chunk_len())) {
            for (times, terms) in times_drawn.iter().zip(of_blocks) {
                let times = f64::from(*times);
                *sum = [sum[0] + times * terms[0], sum[1] + times * terms[1]];
            }
        }
    }

    fn chunk_len(&self) -> usize {
        (self.blocks.n_blocks as usize).max(1)
    }
}

/// Hash of a name (FNV-1a).
fn fingerprint(name: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    name.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

/// Values of all resamples.
///
/// ```
/// use reports::numbers::blocks::{BlockCount, BlockKind};
/// use reports::uncertainty::bootstrap::Distribution;
///
/// // What a rate would be, had other scans of twenty drives been drawn.
/// let blocks = BlockCount::of_dataset(20, BlockKind::Drives);
/// let values = (0..10_000).map(|it| Some(f64::from(it) / 10_000.0));
/// let [low, high] = Distribution::new(values, blocks).expect("there are many drives").interval().ends;
/// // A little farther out than 2.5 and 97.5 %, since twenty drives vary too little.
/// assert!(0.01 < low && low < 0.025 && 0.975 < high && high < 0.99);
/// ```
#[derive(Debug, Clone)]
pub struct Distribution {
    // Invariant: ascending, finite, and at least two.
    sorted: Vec<f64>,
    // Invariant: with degrees of freedom.
    blocks: BlockCount,
}

impl Distribution {
    /// The distribution of `values`, one for each resample of `blocks`.
    ///
    /// `None` if a data set has only one block, which cannot show how blocks vary, or if more than one in twenty values is
    /// undefined.
    pub fn new(values: impl Iterator<Item = Option<f64>>, blocks: BlockCount) -> Option<Self> {
        let (mut sorted, mut n) = (Vec::new(), 0_usize);
        for value in values {
            n += 1;
            sorted.extend(value.filter(|it| it.is_finite()));
        }
        sorted.sort_unstable_by(f64::total_cmp);
        let is_defined = blocks.degrees_of_freedom > 0 && sorted.len() >= 2 && 20 * sorted.len() >= 19 * n;
        is_defined.then_some(Self { sorted, blocks })
    }

    /// The 95 % interval between two percentiles by nearest rank; the fewer blocks, the farther out they lie.
    pub fn interval(&self) -> Interval {
        let tail = expanded_tail(self.blocks);
        let at = |share: f64| {
            let rank = (share * self.sorted.len() as f64).ceil() as usize;
            self.sorted[rank.clamp(1, self.sorted.len()) - 1]
        };
        Interval { ends: [at(tail), at(1.0 - tail)], blocks: self.blocks }
    }

    /// The standard error: the standard deviation of the values, widened by √(n / (n − 1)), since resamples of few blocks
    /// vary too little.
    pub fn standard_error(&self) -> f64 {
        let n = self.sorted.len() as f64;
        let mean = self.sorted.iter().sum::<f64>() / n;
        let variance = self.sorted.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / (n - 1.0);
        widening(self.blocks) * variance.sqrt()
    }

    /// The least effect that data like these would show: a true difference of this size is significant at the 5 %
    /// level, either way, in four of five data sets of this size. The quantiles of Student's distribution at 97.5 and at
    /// 80 %, times the standard error: 2.8 standard errors where there are many blocks, 3.1 for ten.
    pub fn least_effect(&self) -> f64 {
        let freedom = self.blocks.degrees_of_freedom;
        (student_quantile(0.975, freedom) + student_quantile(0.8, freedom)) * self.standard_error()
    }
}

/// √(n / (n − 1)): the factor by which resamples of `blocks` vary too little. n − 1 is summed over data sets.
fn widening(blocks: BlockCount) -> f64 {
    (blocks.n_blocks as f64 / blocks.degrees_of_freedom as f64).sqrt()
}

/// The share of the resamples beyond either end of the 95 % interval: Φ(−√(n / (n − 1)) · t), where t is Student's quantile
/// at 97.5 %. 0.025 of many blocks, 0.0086 of ten.
fn expanded_tail(blocks: BlockCount) -> f64 {
    let student = student_quantile(0.975, blocks.degrees_of_freedom);
    Normal::standard().cdf(-widening(blocks) * student)
}

/// The quantile of Student's distribution at `share`.
fn student_quantile(share: f64, degrees_of_freedom: u64) -> f64 {
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom as f64);
    student.expect("a distribution of several blocks has degrees of freedom").inverse_cdf(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::BlockKind;
    use crate::numbers::sums::FalseObjects;
    use crate::vocabulary::formula::Term;
    use crate::vocabulary::metric::Metric;

    fn drives(n: usize) -> BlockCount {
        BlockCount::of_dataset(n as u64, BlockKind::Drives)
    }

    fn recall_of(sums: &Sums) -> Option<f64> {
        sums.value(Metric::Recall.formula(), FalseObjects::Known)
    }

    /// Blocks of `n` annotations, of which `found` are found.
    fn blocks(found: &[u32], n: u32) -> Vec<(usize, Sums)> {
        let block = |&found: &u32| {
            let mut sums = Sums::default();
            sums.add(Term::Annotations, f64::from(n));
            sums.add(Term::Matched, f64::from(found));
            sums
        };
        found.iter().map(block).enumerate().collect()
    }

    fn distribution(blocks: &[(usize, Sums)]) -> Option<Distribution> {
        let count = drives(blocks.len());
        let sums = Resamples::draw("street", count).sums(blocks);
        Distribution::new(sums.iter().map(recall_of), count)
    }

    #[test]
    fn as_many_blocks_are_drawn_as_there_are() {
        let resamples = Resamples::draw("street", drives(7));
        assert!(resamples.times_drawn.chunks(7).all(|it| it.iter().map(|n| u32::from(*n)).sum::<u32>() == 7));
        let of_first: u32 = resamples.times_drawn.iter().step_by(7).map(|n| u32::from(*n)).sum();
        // Ten thousand draws of a mean of 1 and a variance of 6/7.
        assert!((9_700..10_300).contains(&of_first), "{of_first}");
    }

    #[test]
    fn the_number_of_threads_and_other_data_sets_change_nothing() {
        let draw = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| Resamples::draw("street", drives(20)).times_drawn)
        };
        assert_eq!(draw(1), draw(7));
        assert_ne!(draw(1), Resamples::draw("another", drives(20)).times_drawn);
    }

    #[test]
    fn fewer_resamples_are_the_first_of_all() {
        let [all, few] = [N_RESAMPLES, 3].map(|n| Resamples::first(n, "street", drives(7)));
        assert!((0..3).all(|it| all.times_drawn(it) == few.times_drawn(it)));
        assert_ne!(few.times_drawn(0), few.times_drawn(1));
    }

    #[test]
    fn an_interval_of_alike_blocks_is_a_point() {
        let alike = distribution(&blocks(&[3; 10], 4)).unwrap();
        assert_eq!(alike.interval(), Interval { ends: [0.75, 0.75], blocks: drives(10) });
        assert_eq!((alike.standard_error(), alike.least_effect()), (0.0, 0.0));
    }

    #[test]
    fn an_interval_of_coins_is_that_of_the_binomial() {
        // A hundred blocks of one annotation, half of them found: the standard error of a share is √(0.25 / 100).
        let found: Vec<u32> = (0..100).map(|it| it % 2).collect();
        let coins = distribution(&blocks(&found, 1)).unwrap();
        assert!((coins.standard_error() - 0.05).abs() < 0.001, "{}", coins.standard_error());
        let [low, high] = coins.interval().ends;
        assert!((low - 0.40).abs() < 0.011 && (high - 0.60).abs() < 0.011, "{low} to {high}");
        assert!((coins.least_effect() - 2.8 * 0.05).abs() < 0.003);
    }

    #[test]
    fn objects_of_a_block_come_together() {
        let apart: Vec<u32> = (0..100).map(|it| it % 2).collect();
        let together: Vec<u32> = (0..10).map(|it| 10 * (it % 2)).collect();
        let [apart, together] = [(apart, 1), (together, 10)]
            .map(|(found, n)| distribution(&blocks(&found, n)).unwrap().standard_error());
        // Ten times as few independent draws: √10 times the error, of n − 1 instead of n blocks.
        assert!((together / apart - 11.0_f64.sqrt()).abs() < 0.1, "{together} {apart}");
    }

    #[test]
    fn one_block_and_nothing_defined_show_nothing() {
        assert!(distribution(&blocks(&[3], 4)).is_none());
        assert!(distribution(&blocks(&[0; 5], 0)).is_none());
        assert!(distribution(&[]).is_none());
    }

    #[test]
    fn quantiles_are_those_of_printed_tables() {
        for (degrees_of_freedom, at_80, at_97_5) in
            [(1, 1.376_382, 12.706_205), (9, 0.883_404, 2.262_157), (27, 0.855_137, 2.051_831)]
        {
            assert!((student_quantile(0.8, degrees_of_freedom) - at_80).abs() < 1e-5);
            assert!((student_quantile(0.975, degrees_of_freedom) - at_97_5).abs() < 1e-5);
        }
    }

    #[test]
    fn the_fewer_blocks_the_farther_out_are_the_percentiles() {
        // Hesterberg 2015, table 5: α/2 of 95 % for n of 5, 10, 20, 40 and 100.
        for (n, tail) in [(5, 0.0010), (10, 0.0086), (20, 0.0159), (40, 0.0203), (100, 0.0231)] {
            assert!((expanded_tail(drives(n)) - tail).abs() < 1e-4, "{n}: {}", expanded_tail(drives(n)));
        }
        assert!((expanded_tail(drives(1_000_000)) - 0.025).abs() < 1e-5);
        // Three data sets of ten drives are surer than one, and less sure than thirty drives of one.
        let three = expanded_tail(drives(10).with(drives(10)).with(drives(10)));
        assert!(expanded_tail(drives(10)) < three && three < expanded_tail(drives(30)));
    }

    #[test]
    fn ten_blocks_are_less_sure_than_resamples_look() {
        let found: Vec<u32> = (0..10).map(|it| it % 2).collect();
        let ten = distribution(&blocks(&found, 1)).unwrap();
        // The unbiased standard error of ten coins, half of them heads: √(0.25 · 10 / 9 / 10).
        assert!((ten.standard_error() - (0.25_f64 / 9.0).sqrt()).abs() < 0.002, "{}", ten.standard_error());
        let factor = 2.262_157 + 0.883_404;
        assert!((ten.least_effect() / ten.standard_error() - factor).abs() < 1e-4);
        // 50 % ± 2.26 standard errors of 16.7 points, in steps of ten.
        assert_eq!(ten.interval().ends, [0.1, 0.9]);
    }
}
