//! The Rerun recording of a run, where the program was built with Rerun.

use std::path::PathBuf;

use crate::cli::StreamArgs;
use crate::run::scores::DatasetScores;
use crate::run::side_by_side::ScanResults;
use crate::stream::{DetectorView, RunningFRate, Stream, StreamOptions, ViewerChoice, ViewerState};
use crate::task::Task;

/// An open recording that follows a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Recording {
    stream: Stream,
    n_scans: u32,
    viewer_was_lost: bool,
}

impl Recording {
    /// Begins the recording that `arguments` ask for; `None` if they want none. `default_file` is where it is written
    /// unless they say otherwise, `shown_task` what it shows at first.
    ///
    /// # Errors
    ///
    /// If the file cannot be written or the viewer not be started.
    pub fn begin(
        arguments: &StreamArgs,
        default_file: PathBuf,
        name: &str,
        shown_task: Task,
        detectors: &[&str],
    ) -> anyhow::Result<Option<Self>> {
        if arguments.no_rrd {
            return Ok(None);
        }
        let viewer = match (&arguments.connect, arguments.spawn) {
            (Some(url), _) => ViewerChoice::Connect(url.parse()?),
            (None, true) => ViewerChoice::Spawn,
            (None, false) => ViewerChoice::None,
        };
        let file = arguments.save_rrd.clone().flatten().unwrap_or(default_file);
        let options = StreamOptions { name: name.to_owned(), file, viewer, shown_task };
        Ok(Some(Self { stream: Stream::open(&options, detectors)?, n_scans: 0, viewer_was_lost: false }))
    }

    /// Logs one scan and what all detectors made of it. Returns a warning the first time the viewer is lost.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn log(
        &mut self,
        results: &ScanResults<'_>,
        scores: &DatasetScores,
    ) -> anyhow::Result<Option<String>> {
        self.stream.log_scan(self.n_scans, results.scan)?;
        self.n_scans += 1;
        for (detector_idx, (result, detector)) in results.results.iter().zip(results.detectors).enumerate() {
            let f_rates = scores.f_rates(detector_idx).into_iter();
            let f_rates_so_far: Vec<_> =
                f_rates.map(|(task, f_rate)| RunningFRate { task, f_rate }).collect();
            let view = DetectorView {
                name: result.detector,
                output: &result.output,
                products: &detector.stage_products(&results.scan.cloud),
                assignments: &result.assignments,
                f_rates_so_far: &f_rates_so_far,
                latency: result.latency,
            };
            self.stream.log_detector(results.scan, &view)?;
        }
        match self.stream.viewer_state() {
            ViewerState::Lost { reason } if !self.viewer_was_lost => {
                self.viewer_was_lost = true;
                Ok(Some(format!("the viewer was lost ({reason}); the recording goes on to the file alone")))
            }
            _ => Ok(None),
        }
    }

    /// Writes the end of the file.
    ///
    /// # Errors
    ///
    /// If the file is not complete.
    pub fn finish(self) -> anyhow::Result<()> {
        self.stream.finish()?;
        Ok(())
    }
}
