//! A data set that counts which points its scans lack, whoever reads them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Isometry3;
use scans::annotation::LabeledScan;
use scans::dataset::foreign_frame::ForeignFrame;
use scans::dataset::kitti::label::KittiLabel;
use scans::dataset::official::OfficialScan;
use scans::dataset::{Dataset, DatasetError, Listing, Nearness};

/// How many points without a position each scan has, of the scans that were read and have any.
#[derive(Debug, Clone, Default)]
pub struct PointsLeftOut(Arc<Mutex<BTreeMap<usize, usize>>>);

impl PointsLeftOut {
    /// The number of points, the number of scans, and the first of them, by its place in the data set; `None` if there are none.
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

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let scan = self.dataset.read_scan(scan_idx)?;
        self.points_left_out.note(scan_idx, scan.points_left_out.len());
        Ok(scan)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        self.dataset.scan_time_ns(scan_idx)
    }

    fn point_labels(&self, scan_idx: usize, scan: &LabeledScan) -> Result<Option<Vec<u32>>, DatasetError> {
        self.dataset.point_labels(scan_idx, scan)
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        self.dataset.oddities()
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

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        self.dataset.scan_n_bytes(scan_idx)
    }

    fn left_out(&self) -> Option<&str> {
        self.dataset.left_out()
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        self.dataset.world_from_sensor(scan_idx)
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        self.dataset.foreign_frame(scan_idx)
    }

    fn kitti_labels(&self, scan_idx: usize) -> Option<&[KittiLabel]> {
        self.dataset.kitti_labels(scan_idx)
    }

    fn official_scan(&self, scan_idx: usize) -> Result<Option<OfficialScan>, DatasetError> {
        self.dataset.official_scan(scan_idx)
    }
}
