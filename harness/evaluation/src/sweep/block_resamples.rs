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
            let block_idx = self.blocks.index_of(second).expect("the blocks are of these seconds");
            of_blocks[block_idx] = [0, 1].map(|it| of_blocks[block_idx][it] + terms[it]);
        }
        of_blocks
    }
}

/// The 95 % interval of a ratio of sums over the scans of several data sets, whose numerators and denominators are given
/// block by block; `None` if a data set has a single block, or if more than one in twenty resamples has no ratio.
pub fn ratio_interval(datasets: &[OfDataset<'_>]) -> Option<[f64; 2]> {
    interval(ratios(datasets).into_iter(), datasets)
}

/// The same of the first of two ratios minus the second, both of the same draws of the same scans.
pub fn difference_interval([first, second]: &[Vec<OfDataset<'_>>; 2]) -> Option<[f64; 2]> {
    let pairs = ratios(first).into_iter().zip(ratios(second));
    interval(pairs.map(|(first, second)| Some(first? - second?)), first)
}

/// The blocks of a data set, with a numerator and a denominator for each.
pub type OfDataset<'a> = (&'a BlockResamples, Vec<[f64; 2]>);

/// Of every resample; `None` of one that has no ratio.
fn ratios(datasets: &[OfDataset<'_>]) -> Vec<Option<f64>> {
    let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
    for (blocks, of_blocks) in datasets {
        blocks.resamples.add_terms(of_blocks, &mut resampled);
    }
    let ratio = |[numerator, denominator]: [f64; 2]| (denominator != 0.0).then(|| numerator / denominator);
    resampled.into_iter().map(ratio).collect()
}

fn interval(values: impl Iterator<Item = Option<f64>>, datasets: &[OfDataset<'_>]) -> Option<[f64; 2]> {
    let blocks = datasets.iter().map(|(it, _)| it.blocks()).reduce(BlockCount::with)?;
    Distribution::new(values, blocks).map(|it| it.interval().ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of scans of one drive, a tenth of a second apart.
    fn interval_of(
        indices: impl Iterator<Item = u32>,
        terms: impl Fn(usize) -> [f64; 2],
    ) -> Option<[f64; 2]> {
        let seconds: Vec<DriveSecond> =
            indices.map(|index| DriveSecond::of("0000", f64::from(index) / 10.0)).collect();
        let resamples = BlockResamples::draw("street", seconds.iter().cloned());
        let of_scans = seconds.iter().enumerate().map(|(index, second)| (second, terms(index)));
        let of_blocks = resamples.of_blocks(of_scans);
        ratio_interval(&[(&resamples, of_blocks)])
    }

    #[test]
    fn coins_are_as_sure_as_the_binomial_says() {
        // A hundred scans a second apart, half of them found: standard error √(0.25 / 100).
        let coin = |it: usize| [(it % 2) as f64, 1.0];
        let [low, high] = interval_of((0..100).map(|it| 10 * it), coin).unwrap();
        assert!((low - 0.40).abs() < 0.011 && (high - 0.60).abs() < 0.011, "{low} to {high}");
        // Ten to a second, and all of them alike, are ten coins: 50 % ± 2.26 standard errors of 16.7 points, in steps of
        // ten.
        let block = |it: usize| [(it / 10 % 2) as f64, 1.0];
        let [low, high] = interval_of(0..100, block).unwrap();
        assert!((low - 0.1).abs() < 0.011 && (high - 0.9).abs() < 0.011, "{low} to {high}");
    }

    #[test]
    fn what_two_ratios_share_is_no_doubt_of_their_difference() {
        let seconds: Vec<DriveSecond> = (0..100).map(|it| DriveSecond::of("0000", f64::from(it))).collect();
        let resamples = BlockResamples::draw("street", seconds.iter().cloned());
        let of = |found: &dyn Fn(usize) -> f64| {
            let terms = seconds.iter().enumerate().map(|(index, second)| (second, [found(index), 2.0]));
            vec![(&resamples, resamples.of_blocks(terms))]
        };
        // Coins that fall alike, one side with one more everywhere.
        let coin = |it: usize| (it % 2) as f64;
        let [low, high] = difference_interval(&[of(&|it| coin(it) + 1.0), of(&coin)]).unwrap();
        assert!((low - 0.5).abs() < 1e-12 && (high - 0.5).abs() < 1e-12, "{low} to {high}");
    }

    #[test]
    fn one_second_and_nothing_give_no_interval() {
        assert_eq!(interval_of(0..10, |_| [1.0, 1.0]), None);
        assert_eq!(interval_of((0..10).map(|it| 10 * it), |_| [1.0, 0.0]), None);
        assert_eq!(ratio_interval(&[]), None);
    }
}
