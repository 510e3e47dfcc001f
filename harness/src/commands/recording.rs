//! The Rerun recording of a run, where the program was built with Rerun.

use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::cli::StreamArgs;
use crate::run::scores::DatasetScores;
use crate::run::side_by_side::ScanResults;
use crate::stream::{
    DetectorView, RunningFRate, Stream, StreamError, StreamOptions, ViewerChoice, ViewerState,
};
use crate::task::Task;

/// An open recording that follows a run.
#[must_use = "a recording that is not finished may be incomplete without anyone knowing"]
pub struct Recording {
    stream: Stream,
    elsewhere: Option<RecordingElsewhere>,
    n_scans: u32,
    viewer_was_lost: bool,
}

/// A recording outside of the run directory.
struct RecordingElsewhere {
    file: PathBuf,
    /// Where it is written until it is complete; `None` for devices and pipes, which are written at once.
    unfinished: Option<NamedTempFile>,
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
        let elsewhere = arguments.save_rrd.as_ref().and_then(Option::as_deref);
        let elsewhere = elsewhere.map(RecordingElsewhere::begin).transpose()?;
        let file = elsewhere.as_ref().map_or(default_file, |it| it.path().to_owned());
        let options = StreamOptions { name: name.to_owned(), file, viewer, shown_task };
        let stream = Stream::open(&options, detectors)?;
        Ok(Some(Self { stream, elsewhere, n_scans: 0, viewer_was_lost: false }))
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

    /// Writes the end of the file. Returns a warning if the viewer is lost only now.
    ///
    /// # Errors
    ///
    /// If the file is not complete.
    pub fn finish(self) -> anyhow::Result<Option<String>> {
        let ending = self.stream.finish()?;
        if let Some(elsewhere) = self.elsewhere {
            elsewhere.finish()?;
        }
        Ok(match ending.viewer {
            ViewerState::Lost { reason } if !self.viewer_was_lost => {
                Some(format!("the viewer was lost ({reason}) and may lack the end; the file is complete"))
            }
            _ => None,
        })
    }
}

impl RecordingElsewhere {
    fn begin(file: &Path) -> Result<Self, StreamError> {
        let create_error = |source| StreamError::Create { path: file.to_owned(), source };
        if file.is_dir() {
            return Err(create_error(std::io::ErrorKind::IsADirectory.into()));
        }
        // A link stays one, and a device is not replaced by a file.
        let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        if file.exists() && !file.is_file() {
            return Ok(Self { file, unfinished: None });
        }
        let folder = file.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".recording-").suffix(".rrd");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As for any other file: the umask decides who may read it.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let unfinished = Some(builder.tempfile_in(folder).map_err(create_error)?);
        Ok(Self { file, unfinished })
    }

    /// Where to write.
    fn path(&self) -> &Path {
        self.unfinished.as_ref().map_or(&self.file, NamedTempFile::path)
    }

    fn finish(self) -> Result<(), StreamError> {
        if let Some(unfinished) = self.unfinished {
            let persisted = unfinished.persist(&self.file);
            persisted.map_err(|it| StreamError::Create { path: self.file, source: it.error })?;
        }
        Ok(())
    }
}
