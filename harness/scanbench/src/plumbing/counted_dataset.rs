//! A data set that counts the points without a position in the scans that are read.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use scans::annotation::LabeledScan;
use scans::dataset::{Dataset, DatasetError, Listing, Nearness};

/// Points without a position in the scans that were read: their number by scan, and the scans that have no other points.
#[derive(Debug, Clone, Default)]
pub struct PointsLeftOut(Arc<Mutex<CountedScans>>);

/// Scans by their indices in the data set.
#[derive(Debug, Default)]
struct CountedScans {
    n_left_out: BTreeMap<usize, usize>,
    empty: BTreeSet<usize>,
}

impl PointsLeftOut {
    /// The number of points without a position, the number of scans that have some, and the index of the first of these in
    /// the data set; `None` if there are none.
    pub fn sum(&self) -> Option<(usize, usize, usize)> {
        let by_scan = &self.counted().n_left_out;
        let (first, _) = by_scan.first_key_value()?;
        Some((by_scan.values().sum(), by_scan.len(), *first))
    }

    /// The number of scans without points, and the index of the first of them; `None` if there are none.
    pub fn empty_scans(&self) -> Option<(usize, usize)> {
        let empty = &self.counted().empty;
        Some((empty.len(), *empty.first()?))
    }

    /// The number of points without a position in the scans at `scan_indices`.
    pub fn n_points_in(&self, scan_indices: &[usize]) -> usize {
        let by_scan = &self.counted().n_left_out;
        scan_indices.iter().filter_map(|it| by_scan.get(it)).sum()
    }

    // A scan may be read several times.
    fn note(&self, scan_idx: usize, scan: &LabeledScan) {
        if !scan.points_left_out.is_empty() {
            self.counted().n_left_out.insert(scan_idx, scan.points_left_out.len());
        }
        if scan.cloud.is_empty() {
            self.counted().empty.insert(scan_idx);
        }
    }

    fn counted(&self) -> MutexGuard<'_, CountedScans> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A data set with [`PointsLeftOut`], and with blocks of scans if the user has named some.
pub struct CountedDataset {
    dataset: Box<dyn Dataset>,
    points_left_out: PointsLeftOut,
    // By scan.
    blocks: Option<Vec<Option<String>>>,
}

impl CountedDataset {
    /// `dataset`, and the count that grows with the scans that are read.
    pub fn new(dataset: Box<dyn Dataset>) -> (Self, PointsLeftOut) {
        let points_left_out = PointsLeftOut::default();
        (Self { dataset, points_left_out: points_left_out.clone(), blocks: None }, points_left_out)
    }

    /// `dataset` with the block of each scan; scans without a block are not taken.
    pub fn with_blocks(dataset: Box<dyn Dataset>, blocks: Vec<Option<String>>) -> Self {
        Self { dataset, points_left_out: PointsLeftOut::default(), blocks: Some(blocks) }
    }
}

impl Dataset for CountedDataset {
    fn listing(&self) -> &Listing {
        self.dataset.listing()
    }

    fn inner(&self) -> Option<&dyn Dataset> {
        Some(&*self.dataset)
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let scan = self.dataset.read_scan(scan_idx)?;
        self.points_left_out.note(scan_idx, &scan);
        Ok(scan)
    }

    fn nearness(&self) -> Nearness {
        if self.blocks.is_some() { Nearness::Named } else { self.dataset.nearness() }
    }

    fn scan_block(&self, scan_idx: usize) -> Option<&str> {
        match &self.blocks {
            Some(blocks) => blocks[scan_idx].as_deref(),
            None => self.dataset.scan_block(scan_idx),
        }
    }
}
