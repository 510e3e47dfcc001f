//! A data set that counts which points its scans lack, whoever reads them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use scans::annotation::LabeledScan;
use scans::dataset::{Dataset, DatasetError, Listing, Nearness};

/// How many points without a position each scan has, of the scans that were read and have any.
#[derive(Debug, Clone, Default)]
pub struct PointsLeftOut(Arc<Mutex<BTreeMap<usize, usize>>>);

impl PointsLeftOut {
    /// The number of points, the number of scans, and the first of them, by its index in the data set; `None` if there are
    /// none.
    pub fn sum(&self) -> Option<(usize, usize, usize)> {
        let by_scan = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (first, _) = by_scan.first_key_value()?;
        Some((by_scan.values().sum(), by_scan.len(), *first))
    }

    /// The number of points in the scans at `scan_indices`.
    pub fn n_points_in(&self, scan_indices: &[usize]) -> usize {
        let by_scan = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        scan_indices.iter().filter_map(|it| by_scan.get(it)).sum()
    }

    fn note(&self, scan_idx: usize, n_points: usize) {
        if n_points > 0 {
            // A scan may be read several times.
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(scan_idx, n_points);
        }
    }
}

/// A data set with that count, and with blocks of scans if the user has named some.
pub struct CountedDataset {
    dataset: Box<dyn Dataset>,
    points_left_out: PointsLeftOut,
    // Of each scan.
    blocks: Option<Vec<Option<String>>>,
}

impl CountedDataset {
    /// `dataset`, and the count that grows with the scans that are read.
    pub fn new(dataset: Box<dyn Dataset>) -> (Self, PointsLeftOut) {
        let points_left_out = PointsLeftOut::default();
        (Self { dataset, points_left_out: points_left_out.clone(), blocks: None }, points_left_out)
    }

    /// `dataset`, each scan of which is in one of `blocks`, or is not taken.
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
        self.points_left_out.note(scan_idx, scan.points_left_out.len());
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
