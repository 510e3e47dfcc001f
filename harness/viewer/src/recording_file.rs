//! The file a recording is written to.
//!
//! Rerun's own file sink does not report a full disk before it is flushed, and never an error in the footer. This one keeps
//! the first error, so that the stream can ask for it after every scan and at the end.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use reports::files::new_file::create_file;
use rerun::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use rerun::external::re_log_types::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

use super::error::StreamError;

/// A handle on the file; clones share it, so that one can be given to Rerun to write to.
#[derive(Clone)]
pub struct RecordingFile {
    path: PathBuf,
    state: Arc<Mutex<FileState>>,
}

enum FileState {
    Open(Box<Encoder<BufWriter<File>>>),
    Failed(String),
    Finished,
}

impl RecordingFile {
    /// Creates the file, in place of one that is there, and writes its header.
    ///
    /// # Errors
    ///
    /// [`StreamError::Create`] if it cannot be created, [`StreamError::Write`] if it cannot be written.
    pub fn create(path: &Path) -> Result<Self, StreamError> {
        Self::begin(path, create_file(path))
    }

    /// Writes to the device or the pipe at `path`.
    ///
    /// # Errors
    ///
    /// As [`Self::create`].
    pub fn write_to(path: &Path) -> Result<Self, StreamError> {
        Self::begin(path, File::options().write(true).open(path))
    }

    fn begin(path: &Path, file: std::io::Result<File>) -> Result<Self, StreamError> {
        let file = file.map_err(|source| StreamError::Create { path: path.to_owned(), source })?;
        let options = EncodingOptions::PROTOBUF_COMPRESSED;
        let mut encoder = Encoder::new_eager(rerun::build_info().version, options, BufWriter::new(file))
            .map_err(|error| write_error(path, &error))?;
        // The header sits in the buffer until now; a full disk shows here and not after the first scans.
        encoder.flush_blocking().map_err(|error| write_error(path, &error))?;
        let state = FileState::Open(Box::new(encoder));
        Ok(Self { path: path.to_owned(), state: Arc::new(Mutex::new(state)) })
    }

    /// Reports the first error so far.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if something could not be written.
    pub fn check(&self) -> Result<(), StreamError> {
        match &*self.lock() {
            FileState::Open(_) | FileState::Finished => Ok(()),
            FileState::Failed(reason) => {
                Err(StreamError::Write { path: self.path.clone(), reason: reason.clone() })
            }
        }
    }

    /// Writes the footer and hands everything to the operating system. Data that Rerun sends later are not written.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if this or something before it could not be written.
    pub fn finish(&self) -> Result<(), StreamError> {
        self.attempt(|encoder| {
            encoder.finish()?;
            encoder.flush_blocking()
        });
        self.check()?;
        *self.lock() = FileState::Finished;
        Ok(())
    }

    /// Does `write` if nothing failed before, and remembers its error.
    fn attempt(&self, write: impl FnOnce(&mut Encoder<BufWriter<File>>) -> Result<(), EncodeError>) {
        let mut state = self.lock();
        if let FileState::Open(encoder) = &mut *state
            && let Err(error) = write(encoder)
        {
            *state = FileState::Failed(error.to_string());
        }
    }

    fn lock(&self) -> MutexGuard<'_, FileState> {
        // A panic while the lock was held leaves an encoder that is complete up to its latest message.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LogSink for RecordingFile {
    fn send(&self, message: LogMsg) {
        self.attempt(|encoder| encoder.append(&message).map(|_n_bytes| ()));
    }

    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        self.attempt(Encoder::flush_blocking);
        self.check().map_err(|error| SinkFlushError::failed(error.to_string()))
    }
}

fn write_error(path: &Path, error: &EncodeError) -> StreamError {
    StreamError::Write { path: path.to_owned(), reason: error.to_string() }
}
