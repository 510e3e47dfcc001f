//! Scans that are in memory, as a data set.

use scans::annotation::LabeledScan;
use scans::dataset::{AnnotatedClasses, Dataset, DatasetDescription, DatasetError, Listing};

/// A data set of scans that are in memory.
pub struct ScansInMemory {
    listing: Listing,
    scans: Vec<LabeledScan>,
    times_s: Vec<Option<f64>>,
}

impl ScansInMemory {
    /// The data set called `id`; `times_s` is when each scan was taken.
    pub fn new(
        id: &str,
        annotated: AnnotatedClasses,
        sensor_height_m: f32,
        scans: Vec<LabeledScan>,
        times_s: Vec<Option<f64>>,
    ) -> Self {
        let description = DatasetDescription {
            id: id.to_owned(),
            format: "memory".to_owned(),
            root: None,
            annotated,
            sensor_height_m,
            sensor: "unknown".to_owned(),
            licence: None,
            checksum: None,
            simulation: None,
        };
        let scan_ids = scans.iter().map(|it| it.id.clone()).collect();
        Self { listing: Listing { description, scan_ids }, scans, times_s }
    }
}

impl Dataset for ScansInMemory {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        Ok(self.scans[scan_idx].clone())
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        Some((1e9 * self.times_s[scan_idx]?).round() as u64)
    }
}
