//! `--detections-out`: detections in the files of other people's evaluators.

use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use scans::conversion::results::result_folder::ResultFolder;

use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_diagnostic;

/// Writes the detections of all detectors.
pub struct DetectionFiles(ResultFolder);

impl DetectionFiles {
    /// Writes them to `folder`, which appears at the end.
    pub fn new(folder: ResultFolder) -> Self {
        Self(folder)
    }
}

impl RunSink<Failure> for DetectionFiles {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.0.begin_dataset(watched.dataset.description());
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        let scan = judged.results.scan;
        let frame = judged.watched.dataset.foreign_frame(judged.scan_idx())?;
        for result in judged.results.results {
            self.0.add(result.detector, scan, &frame, &result.output)?;
        }
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        Ok(self.0.end_dataset()?)
    }

    /// Leaves no folder: it would look whole.
    fn break_off(self: Box<Self>) -> Result<(), Failure> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        let n_left_out = self.0.finish()?;
        if n_left_out > 0 {
            print_diagnostic(format_args!(
                "note: {n_left_out} detections are not in the files of --detections-out: they are no vehicles, and the format \
                 has no class for others"
            ));
        }
        Ok(())
    }
}
