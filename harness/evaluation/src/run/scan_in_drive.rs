//! A scan with its place in its drive, as detectors are asked for it.

use std::sync::atomic::AtomicBool;

use scans::annotation::LabeledScan;
use scans::dataset::Dataset;
use scans::dataset::scan_times::ScanTime;

/// A scan that a detector is asked for.
#[derive(Clone, Copy)]
pub struct ScanInDrive<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Seconds from the first scan of its drive.
    pub time_s: f64,
    /// Its place; `None` if it stands for itself, such as a scan of a file.
    pub place: Option<Place<'a>>,
}

/// Place of a scan in its data set.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// Index of the scan in [`Dataset::scan_ids`].
    pub scan_idx: usize,
    /// The scans before it; `None` where detectors are asked for scans in any order.
    pub before: Option<ScansBefore<'a>>,
}

/// The scans of a drive that are asked for before another one of it.
#[derive(Clone, Copy)]
pub struct ScansBefore<'a> {
    /// Their indices in [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// The times of all scans of the data set.
    pub times: &'a [ScanTime],
    /// No more of them are asked for once it is set.
    pub interrupted: &'a AtomicBool,
}

impl<'a> ScanInDrive<'a> {
    /// A scan that stands for itself.
    pub fn alone(scan: &'a LabeledScan) -> Self {
        Self { scan, time_s: 0.0, place: None }
    }

    /// `scan`, which is scan `scan_idx` of `dataset` and is asked for in any order.
    pub fn anywhere(scan: &'a LabeledScan, time_s: f64, dataset: &'a dyn Dataset, scan_idx: usize) -> Self {
        Self { scan, time_s, place: Some(Place { dataset, scan_idx, before: None }) }
    }
}

/// Those of `scan_indices` before the one at `run_idx` that are of its drive, without another drive in between.
pub fn selected_before<'a>(dataset: &dyn Dataset, scan_indices: &'a [usize], run_idx: usize) -> &'a [usize] {
    let drive = |run_idx: usize| &dataset.scan_ids()[scan_indices[run_idx]].sequence;
    let n = (0..run_idx).rev().take_while(|it| drive(*it) == drive(run_idx)).count();
    &scan_indices[run_idx - n..run_idx]
}
