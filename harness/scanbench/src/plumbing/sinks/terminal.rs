//! Progress of a run and, with `--verbose`, a line for each scan.

use std::fmt::Write as _;
use std::time::Duration;

use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};

use crate::plumbing::failure::Failure;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_detail};

/// Moves the progress bar.
pub struct Terminal(RunProgress);

impl Terminal {
    pub fn new(progress: &RunProgress) -> Self {
        Self(progress.clone())
    }
}

impl RunSink<Failure> for Terminal {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.0.begin(watched.n_scans, &watched.dataset.description().id);
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        if is_said(Verbosity::Verbose) {
            self.0.suspend(|| print_detail(scan_line(judged)));
        }
        self.0.advance();
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        self.0.clear();
        Ok(())
    }
}

/// A line with the time, the longest stage and the number of detections of each detector.
fn scan_line(judged: &JudgedScan<'_>) -> String {
    let results = judged.results;
    let scan = results.scan;
    let mut line = format!("{} {}: {} points", judged.dataset().id, scan.id, scan.cloud.len());
    for result in results.results {
        let ms = |time: Duration| 1e3 * time.as_secs_f64();
        let n_detections = result.output.detections.len();
        let _ = write!(line, "; {}", result.detector);
        if let Some(failure) = &result.failure {
            let _ = write!(line, " failed: {}", failure.problem);
            continue;
        }
        if let Some(first) = result.times.first {
            let _ = write!(line, " {:.2} ms,", ms(first));
        }
        let _ = write!(line, " {n_detections} detections");
        if let Some(longest) = result.output.stage_times.iter().max_by_key(|it| it.duration) {
            let _ = write!(line, " ({} {:.2} ms)", longest.stage, ms(longest.duration));
        }
    }
    line
}
