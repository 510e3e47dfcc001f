//! How long each detector takes for each scan.

use std::collections::BTreeMap;

use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::ScanRow;

use super::logged_drive::LoggedDrive;

/// Where times of detection come from, beside the run itself.
#[derive(Debug, Clone, Default)]
pub struct LatencySource<'a> {
    /// One time for every scan, in milliseconds, by the name of the detector.
    pub fixed_ms: BTreeMap<String, f64>,
    /// Rows of the same scans on another machine.
    pub elsewhere: Option<&'a [ScanRow]>,
}

/// A detector whose times are not known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoLatency {
    /// Its name.
    pub detector: String,
}

/// Times in milliseconds by detector, drive and scan.
pub type Latencies = Vec<Vec<Vec<f64>>>;

impl LatencySource<'_> {
    /// The times of all `detectors` of a run on its `drives`. A scan whose time does not count, as while warming up, takes the
    /// median of the detector's others.
    ///
    /// # Errors
    ///
    /// [`NoLatency`] if no time of a detector is known.
    pub fn latencies(&self, drives: &[LoggedDrive], detectors: &[&str]) -> Result<Latencies, NoLatency> {
        let elsewhere = self.elsewhere.map(|rows| {
            let timed = rows.iter().filter_map(|row| {
                Some(((row.detector.as_str(), row.scan_name()), row.numbers()?.latency_ms?))
            });
            timed.collect::<BTreeMap<(&str, ScanName), f64>>()
        });
        let of_detector = |(detector_idx, detector): (usize, &&str)| {
            let known =
                |scan: &super::logged_drive::LoggedScan| match (self.fixed_ms.get(*detector), &elsewhere) {
                    (Some(fixed_ms), _) => Some(*fixed_ms),
                    (None, Some(elsewhere)) => elsewhere.get(&(*detector, scan.name.clone())).copied(),
                    (None, None) => scan.latencies_ms[detector_idx],
                };
            let known: Vec<Vec<Option<f64>>> =
                drives.iter().map(|it| it.scans.iter().map(known).collect()).collect();
            let mut sorted: Vec<f64> = known.iter().flatten().copied().flatten().collect();
            sorted.sort_by(f64::total_cmp);
            let median = sorted.get(sorted.len().saturating_sub(1) / 2).copied();
            let median = median.ok_or_else(|| NoLatency { detector: (*detector).to_owned() })?;
            Ok(known.into_iter().map(|it| it.into_iter().map(|it| it.unwrap_or(median)).collect()).collect())
        };
        detectors.iter().enumerate().map(of_detector).collect()
    }
}
