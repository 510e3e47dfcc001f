//! How sure ratios of sums over scans are.

use reports::numbers::blocks::{BlockCount, Blocks, DriveSecond};
use reports::uncertainty::bootstrap::{Distribution, N_RESAMPLES, Resamples};
use scans::annotation::ScanId;

/// The blocks that the scans of a data set are in, and how often each block is drawn.
#[derive(Debug, Clone)]
pub struct BlockResamples {
    block_of_scan: Vec<usize>,
    resamples: Resamples,
}

impl BlockResamples {
    /// Draws blocks of `scans` of `dataset`, which come with the times that they were taken at, in seconds since the first of their
    /// drive.
    pub fn draw<'a>(dataset: &str, scans: impl Iterator<Item = (&'a ScanId, f64)>) -> Self {
        let seconds: Vec<DriveSecond> =
            scans.map(|(id, time_s)| DriveSecond::of(&id.sequence, time_s)).collect();
        let blocks = Blocks::of(seconds.iter().cloned());
        let place_of = |it: &DriveSecond| blocks.place_of(it).expect("the blocks are of these seconds");
        let block_of_scan = seconds.iter().map(place_of).collect();
        Self { block_of_scan, resamples: Resamples::draw(dataset, blocks.count()) }
    }

    /// The blocks.
    pub fn blocks(&self) -> BlockCount {
        self.resamples.blocks()
    }

    fn add_to(&self, resampled: &mut [[f64; 2]], of_scans: &[[f64; 2]]) {
        let mut of_blocks = vec![[0.0; 2]; self.blocks().n_blocks as usize];
        for (&block_idx, terms) in self.block_of_scan.iter().zip(of_scans) {
            of_blocks[block_idx] = [0, 1].map(|it| of_blocks[block_idx][it] + terms[it]);
        }
        self.resamples.add_terms(&of_blocks, resampled);
    }
}

/// The 95 % interval of a ratio of sums over the scans of several data sets, whose numerators and denominators are given
/// scan by scan; `None` if a data set has a single block, or if more than one in twenty resamples has no ratio.
pub fn ratio_interval(datasets: &[(&BlockResamples, Vec<[f64; 2]>)]) -> Option<[f64; 2]> {
    let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
    for (resamples, of_scans) in datasets {
        resamples.add_to(&mut resampled, of_scans);
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

    fn scans(indices: impl Iterator<Item = u32>) -> Vec<ScanId> {
        indices.map(|index| ScanId { sequence: "0000".to_owned(), index }).collect()
    }

    fn interval(indices: impl Iterator<Item = u32>, terms: impl Fn(usize) -> [f64; 2]) -> Option<[f64; 2]> {
        let scans = scans(indices);
        let times_s = scans.iter().map(|it| f64::from(it.index) / 10.0);
        let resamples = BlockResamples::draw("street", scans.iter().zip(times_s));
        ratio_interval(&[(&resamples, (0..scans.len()).map(terms).collect())])
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
