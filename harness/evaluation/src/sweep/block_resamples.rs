//! How sure ratios of sums over scans are.

use reports::numbers::blocks::{BlockCount, Blocks, DriveSecond};
use reports::uncertainty::bootstrap::{Distribution, N_RESAMPLES, Resamples};

/// The blocks that the scans of a data set are in, and how often each block is drawn.
#[derive(Debug, Clone)]
pub struct BlockResamples {
    blocks: Blocks,
    resamples: Resamples,
}

impl BlockResamples {
    /// Draws blocks of the scans of `dataset`, which were taken in these seconds.
    pub fn draw(dataset: &str, seconds: impl IntoIterator<Item = DriveSecond>) -> Self {
        let blocks = Blocks::of(seconds);
        let resamples = Resamples::draw(dataset, blocks.count());
        Self { blocks, resamples }
    }

    /// The blocks.
    pub fn blocks(&self) -> BlockCount {
        self.resamples.blocks()
    }

    /// Numerators and denominators of a ratio, summed by blocks, which are given for seconds.
    pub fn of_blocks<'a>(
        &self,
        of_seconds: impl Iterator<Item = (&'a DriveSecond, [f64; 2])>,
    ) -> Vec<[f64; 2]> {
        let mut of_blocks = vec![[0.0; 2]; self.blocks.len()];
        for (second, terms) in of_seconds {
            let block_idx = self.blocks.place_of(second).expect("the blocks are of these seconds");
            of_blocks[block_idx] = [0, 1].map(|it| of_blocks[block_idx][it] + terms[it]);
        }
        of_blocks
    }
}

/// The 95 % interval of a ratio of sums over the scans of several data sets, whose numerators and denominators are given
/// block by block; `None` if a data set has a single block, or if more than one in twenty resamples has no ratio.
pub fn ratio_interval(datasets: &[(&BlockResamples, Vec<[f64; 2]>)]) -> Option<[f64; 2]> {
    let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
    for (blocks, of_blocks) in datasets {
        blocks.resamples.add_terms(of_blocks, &mut resampled);
    }
    let ratios = resampled
        .iter()
        .map(|[numerator, denominator]| (*denominator != 0.0).then(|| numerator / denominator));
    let blocks = datasets.iter().map(|(it, _)| it.blocks()).reduce(BlockCount::with)?;
    Distribution::new(ratios, blocks).map(|it| it.interval().ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of scans of one drive, a tenth of a second apart.
    fn interval(indices: impl Iterator<Item = u32>, terms: impl Fn(usize) -> [f64; 2]) -> Option<[f64; 2]> {
        let seconds: Vec<DriveSecond> =
            indices.map(|index| DriveSecond::of("0000", f64::from(index) / 10.0)).collect();
        let resamples = BlockResamples::draw("street", seconds.iter().cloned());
        let of_scans = seconds.iter().enumerate().map(|(place, second)| (second, terms(place)));
        let of_blocks = resamples.of_blocks(of_scans);
        ratio_interval(&[(&resamples, of_blocks)])
    }

    #[test]
    fn coins_are_as_sure_as_the_binomial_says() {
        // A hundred scans a second apart, half of them found: standard error √(0.25 / 100).
        let coin = |it: usize| [(it % 2) as f64, 1.0];
        let [low, high] = interval((0..100).map(|it| 10 * it), coin).unwrap();
        assert!((low - 0.40).abs() < 0.011 && (high - 0.60).abs() < 0.011, "{low} to {high}");
        // Ten to a second, and all of them alike, are ten coins: 50 % ± 2.26 standard errors of 16.7 points, in steps of ten.
        let block = |it: usize| [(it / 10 % 2) as f64, 1.0];
        let [low, high] = interval(0..100, block).unwrap();
        assert!((low - 0.1).abs() < 0.011 && (high - 0.9).abs() < 0.011, "{low} to {high}");
    }

    #[test]
    fn one_second_and_nothing_tell_nothing() {
        assert_eq!(interval(0..10, |_| [1.0, 1.0]), None);
        assert_eq!(interval((0..10).map(|it| 10 * it), |_| [1.0, 0.0]), None);
        assert_eq!(ratio_interval(&[]), None);
    }
}
