//! How sure ratios of sums over scans are.

use std::collections::BTreeMap;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::annotation::ScanId;

/// Number of times that blocks are drawn.
pub const N_RESAMPLES: usize = 10_000;
const SEED: u64 = 1;
/// Scans whose numbers begin alike when divided by this are one block: a second or more, at ten scans a second or fewer.
const SCANS_PER_BLOCK: u32 = 10;

/// The scans of a data set in blocks, and how often each block is drawn.
///
/// Neighbouring scans show the same objects, so whole blocks are drawn, with replacement, as many as there are.
#[derive(Debug, Clone)]
pub struct BlockResamples {
    block_of_scan: Vec<usize>,
    n_blocks: usize,
    // Resample by resample, `n_blocks` numbers each.
    times_drawn: Vec<u16>,
}

impl BlockResamples {
    /// Draws blocks of `scans` of `dataset`; the same whatever else is looked at, and with any number of threads.
    pub fn draw<'a>(dataset: &str, scans: impl Iterator<Item = &'a ScanId>) -> Self {
        let mut blocks = BTreeMap::new();
        let block_of_scan = scans.map(|it| {
            let n_blocks = blocks.len();
            *blocks.entry((it.sequence.clone(), it.index / SCANS_PER_BLOCK)).or_insert(n_blocks)
        });
        let block_of_scan: Vec<usize> = block_of_scan.collect();
        let n_blocks = blocks.len();
        let mut times_drawn = vec![0_u16; N_RESAMPLES * n_blocks];
        let seed = SEED ^ fingerprint(dataset);
        times_drawn.par_chunks_mut(n_blocks.max(1)).enumerate().for_each(|(resample_idx, times_drawn)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(resample_idx as u64);
            for _ in 0..n_blocks {
                let block_idx = rng.random_range(0..n_blocks);
                times_drawn[block_idx] = times_drawn[block_idx].saturating_add(1);
            }
        });
        Self { block_of_scan, n_blocks, times_drawn }
    }

    /// Number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.n_blocks
    }

    /// Adds numerators and denominators, one pair for each scan, to those of each resample.
    fn add_to(&self, resampled: &mut [[f64; 2]], of_scans: &[[f64; 2]]) {
        let mut of_blocks = vec![[0.0; 2]; self.n_blocks];
        for (&block_idx, terms) in self.block_of_scan.iter().zip(of_scans) {
            of_blocks[block_idx] = [0, 1].map(|it| of_blocks[block_idx][it] + terms[it]);
        }
        let resamples = self.times_drawn.chunks(self.n_blocks.max(1));
        for (sum, times_drawn) in resampled.iter_mut().zip(resamples) {
            for (times, terms) in times_drawn.iter().zip(&of_blocks) {
                let times = f64::from(*times);
                *sum = [sum[0] + times * terms[0], sum[1] + times * terms[1]];
            }
        }
    }
}

/// The 95 % interval of a ratio of sums over the scans of several data sets, whose numerators and denominators are given
/// scan by scan: from the 2.5th to the 97.5th percentile of the resamples, by nearest rank. `None` of a single block, or if
/// more than one in twenty resamples has no ratio.
pub fn ratio_interval(datasets: &[(&BlockResamples, Vec<[f64; 2]>)]) -> Option<[f64; 2]> {
    if datasets.iter().map(|(it, _)| it.n_blocks).sum::<usize>() < 2 {
        return None;
    }
    let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
    for (resamples, of_scans) in datasets {
        resamples.add_to(&mut resampled, of_scans);
    }
    let ratios =
        resampled.iter().filter(|it| it[1] != 0.0).map(|[numerator, denominator]| numerator / denominator);
    let mut sorted: Vec<f64> = ratios.filter(|it| it.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted[((share * sorted.len() as f64).ceil() as usize).clamp(1, sorted.len()) - 1];
    (20 * sorted.len() >= 19 * N_RESAMPLES).then(|| [at(0.025), at(0.975)])
}

/// Tells names apart (FNV-1a).
fn fingerprint(name: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    name.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scans(indices: impl Iterator<Item = u32>) -> Vec<ScanId> {
        indices.map(|index| ScanId { sequence: "0000".to_owned(), index }).collect()
    }

    fn interval(indices: impl Iterator<Item = u32>, terms: impl Fn(usize) -> [f64; 2]) -> Option<[f64; 2]> {
        let scans = scans(indices);
        let resamples = BlockResamples::draw("street", scans.iter());
        ratio_interval(&[(&resamples, (0..scans.len()).map(terms).collect())])
    }

    #[test]
    fn coins_are_as_sure_as_the_binomial_says() {
        // A hundred scans a second apart, half of them found: standard error √(0.25 / 100).
        let coin = |it: usize| [(it % 2) as f64, 1.0];
        let [low, high] = interval((0..100).map(|it| 10 * it), coin).unwrap();
        assert!((low - 0.40).abs() < 0.011 && (high - 0.60).abs() < 0.011, "{low} to {high}");
        // Ten to a second, and all of them alike, are ten coins.
        let block = |it: usize| [(it / 10 % 2) as f64, 1.0];
        let [low, high] = interval(0..100, block).unwrap();
        assert!((low - 0.2).abs() < 0.011 && (high - 0.8).abs() < 0.011, "{low} to {high}");
    }

    #[test]
    fn one_second_and_nothing_tell_nothing() {
        assert_eq!(interval(0..10, |_| [1.0, 1.0]), None);
        assert_eq!(interval((0..10).map(|it| 10 * it), |_| [1.0, 0.0]), None);
        assert_eq!(ratio_interval(&[]), None);
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let scans = scans((0..20).map(|it| 10 * it));
        let draw = |n_threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| BlockResamples::draw("street", scans.iter()).times_drawn)
        };
        assert_eq!(draw(1), draw(5));
        assert_ne!(draw(1), BlockResamples::draw("another", scans.iter()).times_drawn);
    }
}
