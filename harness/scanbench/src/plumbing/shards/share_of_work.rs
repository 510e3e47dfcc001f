//! The scans that a shard has.

use std::fmt::Write as _;

use reports::numbers::shard_cut::{ScanToCut, scans_of_shard};
use reports::run_folder::shard_record::{ShardPart, WorkMeasure};
use reports::vocabulary::shard::Shard;
use scans::dataset::checksum::sha256;
use scans::dataset::scan_times::{ScanTime, scan_times};

use crate::plumbing::open_datasets::OpenedDataset;

pub struct ShareOfWork {
    /// Measure by which the work was cut.
    pub cut_by: WorkMeasure,
    /// Its scans of each data set; their labels are not counted yet.
    pub parts: Vec<ShardPart>,
}

/// Cuts the parts of `datasets` that are run to the scans of `shard`.
pub fn claim_share(datasets: &mut [OpenedDataset], shard: Shard) -> ShareOfWork {
    let sizes: Option<Vec<Vec<u64>>> = datasets.iter().map(file_sizes).collect();
    let cut_by = if sizes.is_some() { WorkMeasure::FileSizes } else { WorkMeasure::Scans };
    let times: Vec<Vec<ScanTime>> = datasets.iter().map(times_of_selected).collect();
    let scan = |(dataset_idx, index): (usize, usize)| ScanToCut {
        second: times[dataset_idx][index].second.clone(),
        work: sizes.as_ref().map_or(1, |it| it[dataset_idx][index]),
    };
    let scans: Vec<Vec<ScanToCut>> = (0..datasets.len())
        .map(|dataset_idx| {
            (0..datasets[dataset_idx].scan_indices.len()).map(|index| scan((dataset_idx, index))).collect()
        })
        .collect();
    let ranges = scans_of_shard(&scans, shard);
    let mut parts = Vec::new();
    for ((opened, times), range) in datasets.iter_mut().zip(times).zip(ranges) {
        let selected = checksum_of_selected(opened, &times);
        parts.push(ShardPart {
            first: range.start as u64,
            end: range.end as u64,
            selected,
            n_labels: 0,
            n_labeled_scans: 0,
        });
        opened.part = range;
    }
    ShareOfWork { cut_by, parts }
}

/// Sizes of the files of the selected scans; `None` if a scan has no file of its own.
fn file_sizes(opened: &OpenedDataset) -> Option<Vec<u64>> {
    opened.scan_indices.iter().map(|it| opened.dataset.scan_n_bytes(*it)).collect()
}

fn times_of_selected(opened: &OpenedDataset) -> Vec<ScanTime> {
    let times = scan_times(&*opened.dataset);
    opened.scan_indices.iter().map(|it| times[*it].clone()).collect()
}

/// SHA-256 of the names of the selected scans and of when they were taken, a line each.
fn checksum_of_selected(opened: &OpenedDataset, times: &[ScanTime]) -> String {
    let mut lines = String::new();
    for (scan_idx, ScanTime { time_s, .. }) in opened.scan_indices.iter().zip(times) {
        let id = &opened.dataset.scan_ids()[*scan_idx];
        // Writing to a string cannot fail.
        let _ = writeln!(lines, "{} {} {time_s:.3}", id.sequence, id.index);
    }
    sha256(lines)
}
