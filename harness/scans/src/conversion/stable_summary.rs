//! Makes equal recordings equal in every byte: the library lists schemas and channels at the end of a file in the order of a
//! hash map, which differs each time. Here they are sorted by their numbers before they reach the file.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;

/// Bytes of the kind and the length at the beginning of a record.
const N_HEAD_BYTES: usize = 9;

/// Bytes at the end: the last record, with its head and the checksum as its last four bytes, and the mark of the format.
const N_FOOTER_BYTES: usize = N_HEAD_BYTES + 20;
const N_MARK_BYTES: usize = 8;

/// Passes on the bytes written to it, until its [`Ending`] says that the end begins; from then on it keeps them.
pub struct StableSummary<W> {
    inner: W,
    n_passed_on: u64,
    is_ending: Arc<AtomicBool>,
    end: Vec<u8>,
}

/// Tells a [`StableSummary`] with another owner that the end begins.
#[derive(Clone)]
pub struct Ending(Arc<AtomicBool>);

impl Ending {
    /// Begins the end: bytes written from now on are kept.
    pub fn begin(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl<W: Write> StableSummary<W> {
    /// Passes bytes on to `inner`.
    pub fn new(inner: W) -> (Self, Ending) {
        let is_ending = Arc::new(AtomicBool::new(false));
        let ending = Ending(Arc::clone(&is_ending));
        (Self { inner, n_passed_on: 0, is_ending, end: Vec::new() }, ending)
    }

    /// Passes on the bytes that were kept, in order.
    pub fn finish(mut self) -> io::Result<W> {
        // A summary that cannot be parsed is written unsorted, which is no worse than before.
        let _ = sort_summary(&mut self.end, self.n_passed_on);
        self.inner.write_all(&self.end)?;
        Ok(self.inner)
    }
}

impl<W: Write> Write for StableSummary<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_ending.load(Ordering::Relaxed) {
            self.end.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        let n_written = self.inner.write(bytes)?;
        self.n_passed_on += n_written as u64;
        Ok(n_written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Sorts schemas and channels in the summary of a recording. `end` are the last bytes of the recording, from byte `begin`
/// on; `None` if they do not hold such a summary.
fn sort_summary(end: &mut [u8], begin: u64) -> Option<()> {
    let footer = end.len().checked_sub(N_FOOTER_BYTES + N_MARK_BYTES)?;
    let summary_start = u64::from_le_bytes(*end.get(footer + N_HEAD_BYTES..)?.first_chunk()?);
    let start = usize::try_from(summary_start.checked_sub(begin)?).ok()?;
    let summary = end.get_mut(start..footer)?;
    let mut at = 0;
    for kind in [SCHEMA, CHANNEL] {
        let first = at;
        let mut records: Vec<(u16, Vec<u8>)> = Vec::new();
        while summary.get(at) == Some(&kind) {
            let n_bytes = u64::from_le_bytes(*summary.get(at + 1..)?.first_chunk()?);
            let next = at.checked_add(N_HEAD_BYTES)?.checked_add(usize::try_from(n_bytes).ok()?)?;
            let record = summary.get(at..next)?;
            records.push((u16::from_le_bytes(*record.get(N_HEAD_BYTES..)?.first_chunk()?), record.to_vec()));
            at = next;
        }
        records.sort_unstable();
        let sorted: Vec<u8> = records.into_iter().flat_map(|(_, record)| record).collect();
        summary.get_mut(first..at)?.copy_from_slice(&sorted);
    }
    let checksum = footer + N_FOOTER_BYTES - 4;
    let crc = crc32fast::hash(end.get(start..checksum)?);
    end.get_mut(checksum..checksum + 4)?.copy_from_slice(&crc.to_le_bytes());
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::write::NoSeek;
    use mcap::{Summary, WriteOptions};
    use std::collections::BTreeMap;

    const N_CHANNELS: u16 = 20;

    /// A recording with a message on each of twenty topics.
    fn recording() -> Vec<u8> {
        let (output, ending) = StableSummary::new(Vec::new());
        let options = WriteOptions::new().compression_threads(0).disable_seeking(true);
        let mut writer = options.create(NoSeek::new(output)).unwrap();
        for number in 0..N_CHANNELS {
            let schema = writer.add_schema(&format!("schema {number}"), "jsonschema", b"{}").unwrap();
            let channel =
                writer.add_channel(schema, &format!("/{number}"), "json", &BTreeMap::new()).unwrap();
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: 0,
                log_time: u64::from(number),
                publish_time: 0,
            };
            writer.write_to_known_channel(&header, b"{}").unwrap();
        }
        ending.begin();
        writer.finish().unwrap();
        writer.into_inner().into_inner().finish().unwrap()
    }

    #[test]
    fn the_same_messages_give_the_same_bytes() {
        let first = recording();
        assert!((0..5).all(|_| recording() == first));
        let summary = Summary::read(&first).unwrap().unwrap();
        assert_eq!((summary.channels.len(), summary.schemas.len()), (20, 20));
        assert_eq!(mcap::MessageStream::new(&first).unwrap().count(), 20);
    }

    #[test]
    fn the_checksum_of_the_summary_is_right() {
        let bytes = recording();
        let footer = bytes.len() - N_FOOTER_BYTES - N_MARK_BYTES;
        let start = u64::from_le_bytes(*bytes[footer + N_HEAD_BYTES..].first_chunk().unwrap()) as usize;
        let checksum = u32::from_le_bytes(*bytes[bytes.len() - 12..].first_chunk().unwrap());
        assert_eq!(crc32fast::hash(&bytes[start..bytes.len() - 12]), checksum);
        let numbers: Vec<u8> = bytes[start..].iter().copied().take(1).collect();
        assert_eq!(numbers, [SCHEMA]);
    }

    #[test]
    fn what_is_no_end_of_a_recording_stays_as_it_is() {
        for length in [0, 10, 37, 60] {
            let mut bytes = vec![3; length];
            let _ = sort_summary(&mut bytes, 0);
            assert_eq!(bytes, vec![3; length]);
        }
    }
}
