//! A recording in a single file, without a viewer that waits for it.

use std::path::{Path, PathBuf};

use rerun::sink::LogSink;
use rerun::{RecordingStream, RecordingStreamBuilder};

use super::error::StreamError;
use super::layers::APPLICATION_ID;
use super::recording_file::RecordingFile;

/// A stream, and the file that it goes to.
pub struct SingleFile {
    pub stream: RecordingStream,
    path: PathBuf,
    file: RecordingFile,
}

impl SingleFile {
    /// Begins a recording called `name` in the file at `path`.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if recordings are switched off, or the file cannot be written.
    pub fn begin(path: &Path, name: &str) -> Result<Self, StreamError> {
        // Where the variable RERUN turns recordings off, Rerun itself would leave an empty file.
        if !rerun::decide_logging_enabled(true) {
            return Err(StreamError::SwitchedOff);
        }
        let file = RecordingFile::create(path)?;
        let sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        let not_begun = |error: rerun::RecordingStreamError| StreamError::Log {
            entity: "the recording".to_owned(),
            reason: error.to_string(),
        };
        let builder = RecordingStreamBuilder::new(APPLICATION_ID).recording_name(name);
        let stream = builder.set_sinks(sinks).map_err(not_begun)?;
        stream.set_log_tick_enabled(false);
        stream.set_log_time_enabled(false);
        Ok(Self { stream, path: path.to_owned(), file })
    }

    /// Completes the file.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if it cannot be written.
    pub fn finish(self) -> Result<(), StreamError> {
        let not_written = |error: rerun::sink::SinkFlushError| StreamError::Write {
            path: self.path.clone(),
            reason: error.to_string(),
        };
        self.stream.flush_blocking().map_err(not_written)?;
        self.file.finish()
    }
}
