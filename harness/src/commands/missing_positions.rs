//! Says of every data set, once it is done with, how many points had no position.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use nalgebra::Isometry3;

use crate::annotation::{LabeledScan, ScanId};
use crate::commands::standard_streams::print_diagnostic;
use crate::dataset::position_check::n_without_position;
use crate::dataset::{Dataset, DatasetDescription, DatasetError};

/// A data set that counts the points without a position of the scans that are read, and warns of them when it is dropped.
pub struct PositionsCounted {
    dataset: Box<dyn Dataset>,
    // By scan, so that a scan that is read twice counts once: points, and those without a position.
    incomplete: Mutex<BTreeMap<usize, [usize; 2]>>,
}

impl PositionsCounted {
    /// Counts for `dataset`.
    pub fn new(dataset: Box<dyn Dataset>) -> Self {
        Self { dataset, incomplete: Mutex::default() }
    }

    /// What is to be said; `None` if all points read so far have a position.
    fn warning(&self) -> Option<String> {
        let incomplete = self.incomplete.lock().unwrap_or_else(PoisonError::into_inner);
        let [n_points, n_without] =
            incomplete.values().fold([0; 2], |sum, it| [sum[0] + it[0], sum[1] + it[1]]);
        (n_without > 0).then(|| {
            format!(
                "{}: {n_without} of the {n_points} points of {} scans have no position (a coordinate is NaN or infinite); \
                 they are left out",
                self.dataset.description().id,
                incomplete.len()
            )
        })
    }
}

impl Drop for PositionsCounted {
    fn drop(&mut self) {
        if let Some(warning) = self.warning() {
            print_diagnostic(format_args!("warning: {warning}"));
        }
    }
}

impl Dataset for PositionsCounted {
    fn description(&self) -> &DatasetDescription {
        self.dataset.description()
    }

    fn scan_ids(&self) -> &[ScanId] {
        self.dataset.scan_ids()
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let scan = self.dataset.read_scan(scan_idx)?;
        let n_without = n_without_position(&scan.cloud);
        if n_without > 0 {
            let mut incomplete = self.incomplete.lock().unwrap_or_else(PoisonError::into_inner);
            incomplete.insert(scan_idx, [scan.cloud.len(), n_without]);
        }
        Ok(scan)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        self.dataset.scan_time_ns(scan_idx)
    }

    fn left_out(&self) -> Option<&str> {
        self.dataset.left_out()
    }

    fn labels_without_scans(&self) -> Result<Option<String>, DatasetError> {
        self.dataset.labels_without_scans()
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        self.dataset.world_from_sensor(scan_idx)
    }
}
