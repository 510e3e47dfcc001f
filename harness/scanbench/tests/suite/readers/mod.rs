//! The readers of other formats than KITTI's, on real data where they are there and on drawn ones.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use reports::files::causes::with_causes;
use scans::dataset::{Dataset, DatasetError};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

pub mod argoverse2;
mod bounds;
mod class_names;
mod commands;
mod conversion;
mod foreign_results;
mod kitti_raw;
mod labelled_and_empty;
mod las;
mod made;
mod recordings;
mod mcap;
mod mutations;
mod names;
mod nuscenes;
mod positions;
mod prelabel;
mod result_mutations;
mod results_mcap;
mod ros_results;
mod scan_folder;
mod semantic_kitti;
mod velodyne_capture;
mod whole_or_not;

fn try_open(path: &Path) -> Result<Box<dyn Dataset>, DatasetError> {
    open_dataset(path.to_str().unwrap(), &OpenOptions::default(), &built_in_catalogue().unwrap())
}

#[track_caller]
fn open(path: &Path) -> Box<dyn Dataset> {
    try_open(path).unwrap_or_else(|error| panic!("{error}"))
}

/// Opening, or else reading all scans, fails with a message that has all of `parts`.
#[track_caller]
fn check_damaged(path: &Path, parts: &[&str]) {
    let read_all = |dataset: Box<dyn Dataset>| {
        (0..dataset.scan_ids().len()).try_for_each(|scan_idx| dataset.read_scan(scan_idx).map(drop))
    };
    let error = try_open(path).and_then(read_all).expect_err("damaged");
    assert!(!error.is_usage_error(), "{error}");
    let message = with_causes(&error);
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
}
