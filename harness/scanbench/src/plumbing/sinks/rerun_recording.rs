//! The recording for the Rerun viewer.

use evaluation::run::scan_recorder::{RecordedScan, ScanRecorder as _, Served};
use evaluation::run::sink::{JudgedScan, RunSink};

use crate::plumbing::failure::Failure;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::recorder::{Recorder, report_ending};

/// Records the run while it goes on.
pub struct RerunRecording<'a> {
    recorder: Recorder,
    progress: RunProgress,
    served: &'a mut Option<Box<dyn Served>>,
}

impl<'a> RerunRecording<'a> {
    /// Records with `recorder`, and leaves in `served` the server that still serves the recording in the end.
    pub fn new(recorder: Recorder, progress: &RunProgress, served: &'a mut Option<Box<dyn Served>>) -> Self {
        Self { recorder, progress: progress.clone(), served }
    }
}

impl RunSink<Failure> for RerunRecording<'_> {
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        if let Some(warning) = self.recorder.record(&RecordedScan { judged, marks: &[] })? {
            self.progress.warn(&warning);
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        let Self { recorder, served, .. } = *self;
        *served = report_ending(recorder.finish()?);
        Ok(())
    }
}
