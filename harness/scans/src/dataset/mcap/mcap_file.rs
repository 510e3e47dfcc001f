//! Reads messages from an MCAP file, at any position.

use std::collections::VecDeque;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use mcap::records::op;
use reports::files::regular_file::RegularFile;

use super::chunk::{N_RECORD_HEADER_BYTES, record_at, split_header};
use super::mcap_index::{ChunkError, ChunkPosition, MessagePosition, read_chunk};
use crate::dataset::DatasetError;

/// Chunks kept in memory: neighbouring messages are often in the same one.
const N_CHUNKS_KEPT: usize = 4;

/// Channel, sequence number and two times come before the message itself.
const N_MESSAGE_HEADER_BYTES: usize = 2 + 4 + 8 + 8;

/// A file whose messages are read one at a time, from any thread.
#[derive(Debug)]
pub struct McapFile {
    path: PathBuf,
    chunks: Vec<ChunkPosition>,
    kept: Mutex<VecDeque<(u32, Arc<Vec<u8>>)>>,
}

/// A message in its encoding.
#[derive(Debug, Clone)]
pub struct MessageBytes {
    records: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl MessageBytes {
    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        &self.records[self.range.clone()]
    }
}

impl McapFile {
    /// The file at `path` with these chunks.
    pub fn new(path: &Path, chunks: Vec<ChunkPosition>) -> Self {
        Self { path: path.to_path_buf(), chunks, kept: Mutex::new(VecDeque::new()) }
    }

    /// Reads the message at `position`.
    pub fn message(&self, position: MessagePosition) -> Result<MessageBytes, DatasetError> {
        let (records, offset) = match position.chunk_idx {
            Some(chunk_idx) => (self.chunk(chunk_idx)?, position.offset),
            None => (Arc::new(self.record(position.offset)?), 0),
        };
        let message = usize::try_from(offset).ok().and_then(|offset| record_at(&records, offset));
        match message {
            Some((op::MESSAGE, body, end)) if body.len() >= N_MESSAGE_HEADER_BYTES => {
                let range = end - body.len() + N_MESSAGE_HEADER_BYTES..end;
                Ok(MessageBytes { records, range })
            }
            _ => {
                let problem =
                    format!("has no message where its index says, logged at {} ns", position.log_time_ns);
                Err(self.damaged(problem))
            }
        }
    }

    /// An error about this file.
    pub fn damaged(&self, problem: String) -> DatasetError {
        DatasetError::Damaged { path: self.path.clone(), problem }
    }

    fn io_error(&self, source: std::io::Error) -> DatasetError {
        DatasetError::Io { path: self.path.clone(), source }
    }

    fn chunk(&self, chunk_idx: u32) -> Result<Arc<Vec<u8>>, DatasetError> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, records)) = kept().iter().find(|(idx, _)| *idx == chunk_idx) {
            return Ok(Arc::clone(records));
        }
        let mut file = RegularFile::open(&self.path).map_err(|error| self.io_error(error))?;
        let records =
            read_chunk(&mut file, self.chunks[chunk_idx as usize]).map_err(|error| match error {
                ChunkError::Io(source) => self.io_error(source),
                ChunkError::Damaged(problem) => self.damaged(problem),
            })?;
        let records = Arc::new(records);
        let mut kept = kept();
        kept.push_back((chunk_idx, Arc::clone(&records)));
        if kept.len() > N_CHUNKS_KEPT {
            kept.pop_front();
        }
        Ok(records)
    }

    /// The record at `offset` of the file, with its header; its length was checked when the file was indexed.
    fn record(&self, offset: u64) -> Result<Vec<u8>, DatasetError> {
        let mut file = RegularFile::open(&self.path).map_err(|error| self.io_error(error))?;
        let mut read = || -> std::io::Result<Vec<u8>> {
            file.seek(SeekFrom::Start(offset))?;
            let mut header = [0; N_RECORD_HEADER_BYTES];
            file.read_exact(&mut header)?;
            let (_, n_bytes) = split_header(&header);
            let mut record = header.to_vec();
            Read::by_ref(&mut file).take(n_bytes).read_to_end(&mut record)?;
            Ok(record)
        };
        read().map_err(|error| self.io_error(error))
    }
}
