//! How long each detector takes for each scan.

use std::collections::BTreeMap;

use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::ScanRow;
use reports::streaming::stream_sums::lower_median;

use super::logged_drive::{LoggedDrive, LoggedScan, is_latency};

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

/// Times of detection in milliseconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Latencies {
    /// By detector, drive and scan.
    pub ms: Vec<Vec<Vec<f64>>>,
    /// How many of them are the median of the detector's others, because they are not known.
    pub n_filled_in: usize,
}

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
                let latency_ms = row.numbers()?.latency_ms.filter(|it| is_latency(*it))?;
                Some(((row.detector.as_str(), row.scan_name()), latency_ms))
            });
            timed.collect::<BTreeMap<(&str, ScanName), f64>>()
        });
        let mut latencies = Latencies { ms: Vec::new(), n_filled_in: 0 };
        for (detector_idx, detector) in detectors.iter().enumerate() {
            let known = |scan: &LoggedScan| match (self.fixed_ms.get(*detector), &elsewhere) {
                (Some(fixed_ms), _) => Some(*fixed_ms),
                (None, Some(elsewhere)) => elsewhere.get(&(*detector, scan.name.clone())).copied(),
                (None, None) => scan.latencies_ms[detector_idx],
            };
            let known: Vec<Vec<Option<f64>>> =
                drives.iter().map(|it| it.scans.iter().map(known).collect()).collect();
            let all: Vec<f64> = known.iter().flatten().copied().flatten().collect();
            latencies.n_filled_in += known.iter().flatten().count() - all.len();
            let median = lower_median(&all).ok_or_else(|| NoLatency { detector: (*detector).to_owned() })?;
            let filled =
                |of_drive: Vec<Option<f64>>| of_drive.into_iter().map(|it| it.unwrap_or(median)).collect();
            latencies.ms.push(known.into_iter().map(filled).collect());
        }
        Ok(latencies)
    }
}
