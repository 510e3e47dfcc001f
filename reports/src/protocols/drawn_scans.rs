//! Scans that numbers of protocols are made of, and how often each is drawn.

use crate::numbers::blocks::{BlockCount, Blocks, DriveSecond};
use crate::numbers::tally::Tally;
use crate::rows::scan_name::ScanName;
use crate::uncertainty::bootstrap::Resamples;

/// Number of draws: fewer than for other rates, since each draw needs its own pass over the ranking.
pub const N_PROTOCOL_RESAMPLES: usize = 1_000;

/// Number of draws in one pass: as many numbers as fill a line of the processor's cache.
pub const N_LANES: usize = 8;

/// How often a scan occurs in each of `N` draws. Whole numbers, which sums keep exactly.
pub type Times<const N: usize> = [f64; N];

/// Scans by name, with the blocks that they are drawn in. The draws are the first of those that other rates have.
#[derive(Debug, Clone)]
pub struct DrawnScans {
    // Invariant: ascending, and as many as `index_of_scan`.
    names: Vec<ScanName>,
    // For each scan the index of its data set among `resamples`, and that of its block in it.
    index_of_scan: Vec<(usize, usize)>,
    resamples: Vec<Resamples>,
}

impl DrawnScans {
    /// Scans of the data sets that `extent` names; each data set is drawn from separately.
    pub fn of(tally: &Tally, extent: &str) -> Self {
        Self::of_datasets(tally.datasets_in(extent).into_iter().map(|dataset_idx| {
            let id = &tally.datasets()[dataset_idx];
            let name =
                |sequence: &str, scan| ScanName { dataset: id.clone(), sequence: sequence.to_owned(), scan };
            let scans =
                tally.scans(dataset_idx).map(|(sequence, scan, second)| (name(sequence, scan), second));
            (id.as_str(), scans.collect())
        }))
    }

    /// Scans of data sets, given with their ids, each with the second that it was taken in. Each data set is drawn from
    /// separately.
    pub fn of_datasets<'a>(datasets: impl Iterator<Item = (&'a str, Vec<(ScanName, DriveSecond)>)>) -> Self {
        let (mut scans, mut resamples) = (Vec::new(), Vec::new());
        for (id, of_dataset) in datasets {
            let blocks = Blocks::of(of_dataset.iter().map(|(_, second)| second.clone()));
            for (name, second) in of_dataset {
                let block = blocks.index_of(&second).expect("blocks are made of the same scans");
                scans.push((name, (resamples.len(), block)));
            }
            resamples.push(Resamples::first(N_PROTOCOL_RESAMPLES, id, blocks.count()));
        }
        scans.sort();
        let (names, index_of_scan) = scans.into_iter().unzip();
        Self { names, index_of_scan, resamples }
    }

    /// These scans without draws, where only the numbers themselves matter.
    pub fn undrawn(mut names: Vec<ScanName>) -> Self {
        names.sort();
        names.dedup();
        let index_of_scan = vec![(0, 0); names.len()];
        Self { names, index_of_scan, resamples: Vec::new() }
    }

    /// The scans, ascending.
    pub fn names(&self) -> &[ScanName] {
        &self.names
    }

    /// The blocks that are drawn from; `None` without any scan.
    pub fn blocks(&self) -> Option<BlockCount> {
        self.resamples.iter().map(Resamples::blocks).reduce(BlockCount::with)
    }

    /// Number of draws.
    pub fn n_draws(&self) -> usize {
        if self.resamples.is_empty() { 0 } else { N_PROTOCOL_RESAMPLES }
    }

    /// How often each scan occurs in draw `first` and those after it; 0 in a draw beyond the last.
    pub fn times(&self, first: usize) -> Vec<Times<N_LANES>> {
        let mut times = vec![[0.0; N_LANES]; self.index_of_scan.len()];
        for (lane, draw) in (first..self.n_draws()).take(N_LANES).enumerate() {
            let drawn: Vec<&[u16]> = self.resamples.iter().map(|it| it.times_drawn(draw)).collect();
            for (times, (dataset, block)) in times.iter_mut().zip(&self.index_of_scan) {
                times[lane] = f64::from(drawn[*dataset][*block]);
            }
        }
        times
    }
}

/// Adds `terms` to `sums`, draw by draw.
#[inline(always)]
pub(super) fn add<const N: usize>(sums: &mut [f64; N], terms: &[f64; N]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

/// Sums of `counts` in each draw: pairs of the index of a scan and its count.
pub(super) fn n_in_draws<const N: usize>(counts: &[(u32, u32)], times: &[Times<N>]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (scan, n) in counts {
        add(&mut sums, &times[*scan as usize].map(|it| it * f64::from(*n)));
    }
    sums
}

/// One draw, in which scan *i* occurs `times[i]` times.
pub(super) fn single_draw(times: &[u16]) -> Vec<Times<1>> {
    times.iter().map(|it| [f64::from(*it)]).collect()
}
