//! Index of the messages in an MCAP file that are used.
//!
//! The file is walked once from record to record; only headers and message indexes of chunks are read. A recording that was
//! never finished has no summary that lists its channels: then its chunks are read.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::op;
use reports::files::regular_file::RegularFile;

use super::chunk::{N_RECORD_HEADER_BYTES, decompressed, record_at, split_header};
use super::record_body::RecordBody;
use crate::dataset::DatasetError;

/// Records other than chunks are read whole; larger ones are no part of a sensible recording.
const MAX_RECORD_BYTES: u64 = 256 << 20;

/// Without a summary, chunks are read: all together may grow to this many bytes, or to this many times the size of the file,
/// whichever is more.
const MAX_PLAIN_BYTES: u64 = 256 << 20;
const MAX_GROWTH: u64 = 64;

/// A chunk's header fits in here, with the name of its compression.
const MAX_CHUNK_HEADER_BYTES: u64 = 256;

/// Footer: opcode, length, two offsets and a checksum.
const N_FOOTER_BYTES: i64 = 9 + 8 + 8 + 4;

/// The content of a recording, with positions.
#[derive(Debug, Clone, Default)]
pub struct McapIndex {
    /// The channels by their numbers.
    pub channels: BTreeMap<u16, ChannelInfo>,
    /// The positions of the messages of the channels that were asked for, by time.
    pub messages: BTreeMap<u16, Vec<MessagePosition>>,
    /// The positions of the chunks, and their checksums.
    pub chunks: Vec<ChunkPosition>,
    /// The content of the metadata record with this program's name.
    pub metadata: BTreeMap<String, String>,
    /// Why the walk ended early, in a file that was cut off or is damaged.
    pub cut_off: Option<String>,
}

/// Topic, schema and encoding of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its name.
    pub topic: String,
    /// The name of the schema of its messages; empty if it has none.
    pub schema: String,
    /// How messages are encoded, such as `cdr`.
    pub encoding: String,
}

/// The position of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MessagePosition {
    /// When it was logged, in nanoseconds.
    pub log_time_ns: u64,
    /// The index of its chunk; `None` for a message outside of chunks.
    pub chunk_idx: Option<u32>,
    /// The start of its record: in the decompressed chunk, or in the file.
    pub offset: u64,
}

impl std::fmt::Display for MessagePosition {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "the message logged at {} ns", self.log_time_ns)
    }
}

/// The positions from `begin_ns` to `end_ns`, both included; `positions` ascend by time.
pub fn window(positions: &[MessagePosition], begin_ns: u64, end_ns: u64) -> &[MessagePosition] {
    let begin = positions.partition_point(|it| it.log_time_ns < begin_ns);
    let end = positions.partition_point(|it| it.log_time_ns <= end_ns);
    &positions[begin..end.max(begin)]
}

/// The position of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkPosition {
    /// The start of its record in the file.
    pub offset: u64,
    /// Length of the body of its record.
    pub n_bytes: u64,
    /// Checksum of its decompressed records; 0 if there is none.
    pub crc: u32,
}

/// Walks the file at `path` and notes the messages of the channels that `matters` picks, and the metadata called `name`.
///
/// Of a file that is cut off, it notes the part before the cut.
pub fn index_mcap(
    path: &Path,
    name: &str,
    matters: impl Fn(&ChannelInfo) -> bool,
) -> Result<McapIndex, DatasetError> {
    let io_error = DatasetError::io(path);
    let mut file = RegularFile::open(path).map_err(io_error)?;
    let n_file_bytes = file.n_bytes();
    let mut magic = [0; 8];
    let is_mcap = file.read_exact(&mut magic).is_ok() && magic == mcap::MAGIC;
    if !is_mcap {
        let problem = "is not an MCAP file".to_owned();
        return Err(DatasetError::Damaged { path: path.to_path_buf(), problem });
    }
    let mut walk = Walk {
        schemas: BTreeMap::new(),
        index: McapIndex::default(),
        name,
        matters: &matters,
        n_plain_bytes_left: MAX_PLAIN_BYTES.max(n_file_bytes.saturating_mul(MAX_GROWTH)),
    };
    // A whole summary names all channels, so that chunks need not be read.
    let has_summary = walk.read_summary(&mut file).is_some();
    match walk.walk(&mut file, n_file_bytes, has_summary) {
        Ok(()) => {}
        Err(WalkError::Io(source)) => return Err(io_error(source)),
        Err(WalkError::Damaged(problem)) => walk.index.cut_off = Some(problem),
    }
    let mut n_repeated = 0;
    for positions in walk.index.messages.values_mut() {
        n_repeated += leave_out_repeated(positions);
        positions.sort_by_key(|position| position.log_time_ns);
    }
    if n_repeated > 0 {
        let problem = format!("has an index that names {n_repeated} messages more than once");
        walk.index.cut_off.get_or_insert(problem);
    }
    Ok(walk.index)
}

/// Keeps each message once, in the order of the file, and returns how many were removed.
fn leave_out_repeated(positions: &mut Vec<MessagePosition>) -> usize {
    let n_before = positions.len();
    let mut seen = BTreeSet::new();
    positions.retain(|it| seen.insert((it.chunk_idx, it.offset)));
    n_before - positions.len()
}

enum WalkError {
    Io(std::io::Error),
    Damaged(String),
}

impl From<std::io::Error> for WalkError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<String> for WalkError {
    fn from(problem: String) -> Self {
        Self::Damaged(problem)
    }
}

struct Walk<'a> {
    schemas: BTreeMap<u16, String>,
    index: McapIndex,
    name: &'a str,
    matters: &'a dyn Fn(&ChannelInfo) -> bool,
    n_plain_bytes_left: u64,
}

impl Walk<'_> {
    /// Takes schemas and channels from the end of the file; `None` if there is no readable summary.
    fn read_summary(&mut self, file: &mut RegularFile) -> Option<()> {
        let mut footer = [0; N_FOOTER_BYTES as usize];
        let end = file.seek(SeekFrom::End(-N_FOOTER_BYTES - 8)).ok()?;
        file.read_exact(&mut footer).ok()?;
        let (op::FOOTER, body, _) = record_at(&footer, 0)? else { return None };
        let begin = RecordBody::new(body).footer().ok()?;
        let n_bytes = end.checked_sub(begin)?;
        if begin == 0 || n_bytes > MAX_RECORD_BYTES {
            return None;
        }
        file.seek(SeekFrom::Start(begin)).ok()?;
        let mut summary = Vec::new();
        file.take(n_bytes).read_to_end(&mut summary).ok()?;
        let mut offset = 0;
        while let Some((opcode, body, next)) = record_at(&summary, offset) {
            if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                self.note(opcode, body).ok()?;
            }
            offset = next;
        }
        (!self.index.channels.is_empty()).then_some(())
    }

    fn walk(
        &mut self,
        file: &mut RegularFile,
        n_file_bytes: u64,
        has_summary: bool,
    ) -> Result<(), WalkError> {
        let mut offset = mcap::MAGIC.len() as u64;
        // The chunk whose message indexes may follow, and whether none has come yet: indexes may be left out.
        let (mut open_chunk, mut lacks_index) = (None, false);
        loop {
            file.seek(SeekFrom::Start(offset))?;
            let mut header = [0; N_RECORD_HEADER_BYTES];
            if n_file_bytes < offset + N_RECORD_HEADER_BYTES as u64 {
                return Err(WalkError::Damaged(format!("is cut off at byte {n_file_bytes}")));
            }
            file.read_exact(&mut header)?;
            let (opcode, n_bytes) = split_header(&header);
            let body_offset = offset + N_RECORD_HEADER_BYTES as u64;
            let end = body_offset.checked_add(n_bytes).filter(|end| *end <= n_file_bytes).ok_or_else(|| {
                format!("is cut off: a record at byte {offset} has {n_bytes} bytes, the file has {n_file_bytes}")
            })?;
            if let Some(chunk_idx) = open_chunk
                && lacks_index
                && opcode != op::MESSAGE_INDEX
            {
                self.look_into(file, chunk_idx)?;
                (open_chunk, lacks_index) = (None, false);
                continue;
            }
            match opcode {
                op::DATA_END | op::FOOTER => return Ok(()),
                op::CHUNK => {
                    let chunk_idx = self.note_chunk(file, offset, n_bytes)?;
                    if has_summary {
                        (open_chunk, lacks_index) = (Some(chunk_idx), true);
                    } else {
                        self.look_into(file, chunk_idx)?;
                    }
                }
                op::MESSAGE_INDEX if has_summary => {
                    let body = read_body(file, n_bytes)?;
                    lacks_index = false;
                    self.note_message_index(&body, open_chunk)?;
                }
                op::MESSAGE => {
                    let mut start = [0; 22];
                    let n_read = start.len().min(n_bytes as usize);
                    file.read_exact(&mut start[..n_read])?;
                    self.note_message(&start[..n_read], None, offset)?;
                }
                op::SCHEMA | op::CHANNEL | op::METADATA => self.note(opcode, &read_body(file, n_bytes)?)?,
                _ => {}
            }
            offset = end;
        }
    }

    fn note(&mut self, opcode: u8, body: &[u8]) -> Result<(), String> {
        let body = RecordBody::new(body);
        match opcode {
            op::SCHEMA => {
                let schema = body.schema()?;
                self.schemas.insert(schema.id, schema.name);
            }
            op::CHANNEL => {
                let channel = body.channel()?;
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let info = ChannelInfo { topic: channel.topic, schema, encoding: channel.encoding };
                self.index.channels.insert(channel.id, info);
            }
            op::METADATA => {
                let (name, metadata) = body.metadata()?;
                if name == self.name {
                    self.index.metadata = metadata;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn note_chunk(&mut self, file: &mut RegularFile, offset: u64, n_bytes: u64) -> Result<u32, WalkError> {
        let start = read_body(file, n_bytes.min(MAX_CHUNK_HEADER_BYTES))?;
        let (header, _) = RecordBody::new(&start).chunk_header()?;
        self.index.chunks.push(ChunkPosition { offset, n_bytes, crc: header.uncompressed_crc });
        u32::try_from(self.index.chunks.len() - 1)
            .map_err(|_| WalkError::Damaged("has too many chunks".to_owned()))
    }

    fn look_into(&mut self, file: &mut RegularFile, chunk_idx: u32) -> Result<(), WalkError> {
        let position = self.index.chunks[chunk_idx as usize];
        let records = read_chunk(file, position)?;
        let n_left = self.n_plain_bytes_left.checked_sub(records.len() as u64);
        self.n_plain_bytes_left = n_left.ok_or("has chunks that become too large".to_owned())?;
        let mut offset = 0;
        while offset < records.len() {
            let (opcode, body, next) =
                record_at(&records, offset).ok_or("has a chunk that ends within a record".to_owned())?;
            match opcode {
                op::MESSAGE => self.note_message(body, Some(chunk_idx), offset as u64)?,
                op::SCHEMA | op::CHANNEL => self.note(opcode, body)?,
                _ => {}
            }
            offset = next;
        }
        Ok(())
    }

    fn note_message(&mut self, body: &[u8], chunk_idx: Option<u32>, offset: u64) -> Result<(), String> {
        let (channel_id, log_time_ns) = RecordBody::new(body).message()?;
        if self.index.channels.get(&channel_id).is_some_and(self.matters) {
            let position = MessagePosition { log_time_ns, chunk_idx, offset };
            self.index.messages.entry(channel_id).or_default().push(position);
        }
        Ok(())
    }

    fn note_message_index(&mut self, body: &[u8], chunk_idx: Option<u32>) -> Result<(), String> {
        let (channel_id, entries) = RecordBody::new(body).message_index()?;
        if chunk_idx.is_some() && self.index.channels.get(&channel_id).is_some_and(self.matters) {
            let positions = entries.into_iter().map(|it| MessagePosition {
                log_time_ns: it.log_time,
                chunk_idx,
                offset: it.offset,
            });
            self.index.messages.entry(channel_id).or_default().extend(positions);
        }
        Ok(())
    }
}

/// The next `n_bytes` of `file`, which must have as many.
fn read_body(file: &mut RegularFile, n_bytes: u64) -> Result<Vec<u8>, WalkError> {
    if n_bytes > MAX_RECORD_BYTES {
        return Err(WalkError::Damaged(format!("has a record of {n_bytes} bytes")));
    }
    let mut body = Vec::new();
    file.take(n_bytes).read_to_end(&mut body)?;
    Ok(body)
}

/// The decompressed records of the chunk at `position`.
pub fn read_chunk(file: &mut RegularFile, position: ChunkPosition) -> Result<Vec<u8>, ChunkError> {
    file.seek(SeekFrom::Start(position.offset + N_RECORD_HEADER_BYTES as u64)).map_err(ChunkError::Io)?;
    let mut body = Vec::new();
    file.take(position.n_bytes).read_to_end(&mut body).map_err(ChunkError::Io)?;
    let (header, begin) = RecordBody::new(&body).chunk_header().map_err(ChunkError::Damaged)?;
    let end = usize::try_from(header.compressed_size).ok().and_then(|size| begin.checked_add(size));
    let compressed = end
        .and_then(|end| body.get(begin..end))
        .ok_or_else(|| ChunkError::Damaged("has a chunk that is cut off".to_owned()))?;
    decompressed(&header, compressed).map_err(ChunkError::Damaged)
}

/// Why a chunk cannot be read.
#[derive(Debug)]
pub enum ChunkError {
    /// The operating system refused.
    Io(std::io::Error),
    /// The error, as the rest of a sentence about the file.
    Damaged(String),
}

impl From<ChunkError> for WalkError {
    fn from(error: ChunkError) -> Self {
        match error {
            ChunkError::Io(error) => Self::Io(error),
            ChunkError::Damaged(problem) => Self::Damaged(problem),
        }
    }
}
