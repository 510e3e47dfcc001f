//! Times of the scans of a data set.

use std::collections::HashMap;

use reports::numbers::blocks::DriveSecond;

use super::{Dataset, Nearness};
use crate::annotation::ScanId;

/// Seconds from one scan number to the next where a data set has no times.
pub(super) const SECONDS_PER_NUMBER: f64 = 0.1;

/// The time of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanTime {
    /// Seconds since the first scan of its drive, in whole milliseconds; in a drive without time stamps a tenth of a second
    /// for each scan number.
    pub time_s: f64,
    /// `time_s`; `None` if that is no real time, or does not matter because the user has named blocks.
    pub known_s: Option<f64>,
    /// The unit that it is drawn with when intervals are estimated.
    pub second: DriveSecond,
}

/// The time of each scan of `dataset`, and the unit that it is drawn with.
pub fn scan_times(dataset: &dyn Dataset) -> Vec<ScanTime> {
    let scan = |(scan_idx, time_s): (usize, f64)| {
        let id = &dataset.scan_ids()[scan_idx];
        let known_s = match dataset.nearness() {
            Nearness::Times => Some(time_s),
            Nearness::Unknown | Nearness::Named => None,
        };
        let second = DriveSecond::of_scan(&id.sequence, id.index, dataset.scan_block(scan_idx), known_s);
        ScanTime { time_s, known_s, second }
    };
    scan_times_s(dataset).into_iter().enumerate().map(scan).collect()
}

/// The time of each scan of `dataset`, in seconds since the first scan of its drive, in whole milliseconds: by the time
/// stamps of the data set or, in a drive without them, a tenth of a second for each scan number.
fn scan_times_s(dataset: &dyn Dataset) -> Vec<f64> {
    let scan_ids = dataset.scan_ids();
    let stamps_ns: Vec<Option<u64>> = (0..scan_ids.len()).map(|it| dataset.scan_time_ns(it)).collect();
    // By drive; `None` once one of its scans has no time.
    let mut starts_ns: HashMap<&str, Option<u64>> = HashMap::new();
    let drives: Vec<&str> =
        scan_ids.iter().enumerate().map(|(scan_idx, id)| drive(dataset, scan_idx, id)).collect();
    for (drive, stamp_ns) in drives.iter().zip(&stamps_ns) {
        let start_ns = starts_ns.entry(drive).or_insert(*stamp_ns);
        *start_ns = start_ns.zip(*stamp_ns).map(|(start_ns, stamp_ns)| start_ns.min(stamp_ns));
    }
    let time_s =
        |((id, drive), stamp_ns): ((&ScanId, &&str), &Option<u64>)| match starts_ns[drive].zip(*stamp_ns) {
            Some((start_ns, stamp_ns)) => ((stamp_ns - start_ns) / 1_000_000) as f64 / 1000.0,
            None => (f64::from(id.index) * SECONDS_PER_NUMBER * 1000.0).round() / 1000.0,
        };
    scan_ids.iter().zip(&drives).zip(&stamps_ns).map(time_s).collect()
}

/// The drive whose first scan the time of a scan is counted from.
fn drive<'a>(dataset: &'a dyn Dataset, scan_idx: usize, id: &'a ScanId) -> &'a str {
    match dataset.nearness() {
        Nearness::Times => dataset.scan_block(scan_idx).unwrap_or(&id.sequence),
        Nearness::Unknown | Nearness::Named => &id.sequence,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::LabeledScan;
    use crate::dataset::{DatasetError, Listing};

    struct Stamped {
        scan_ids: Vec<ScanId>,
        stamps_ns: Vec<Option<u64>>,
    }

    impl Dataset for Stamped {
        fn listing(&self) -> &Listing {
            unreachable!("nobody asks")
        }

        fn scan_ids(&self) -> &[ScanId] {
            &self.scan_ids
        }

        fn read_scan(&self, _: usize) -> Result<LabeledScan, DatasetError> {
            unreachable!("nobody asks")
        }

        fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
            self.stamps_ns[scan_idx]
        }
    }

    #[track_caller]
    fn check(scans: &[(&str, u32, Option<u64>)], expected_s: &[f64]) {
        let id = |(drive, index, _): &(&str, u32, _)| ScanId { sequence: (*drive).to_owned(), index: *index };
        let stamps_ns = scans.iter().map(|it| it.2).collect();
        let dataset = Stamped { scan_ids: scans.iter().map(id).collect(), stamps_ns };
        assert_eq!(scan_times_s(&dataset), expected_s);
    }

    #[test]
    fn time_runs_from_the_first_scan_of_each_drive() {
        let start_ns = 1_532_402_927_647_951_000;
        check(
            &[
                ("a", 0, Some(start_ns)),
                ("a", 1, Some(start_ns + 500_499_999)),
                ("b", 0, Some(7)),
                ("b", 1, Some(103_735_907)),
            ],
            &[0.0, 0.5, 0.0, 0.103],
        );
        // Stamps that do not ascend are kept.
        check(&[("a", 0, Some(2_000_000_000)), ("a", 1, Some(1_000_000_000))], &[1.0, 0.0]);
    }

    #[test]
    fn a_drive_without_stamps_goes_by_numbers() {
        check(
            &[("a", 3, None), ("a", 29, None), ("b", 5, Some(9)), ("b", 6, Some(9))],
            &[0.3, 2.9, 0.0, 0.0],
        );
        // If one stamp is missing, the others do not tell how far apart it is.
        check(&[("a", 0, Some(0)), ("a", 1, None), ("a", 2, Some(900_000_000))], &[0.0, 0.1, 0.2]);
    }
}
