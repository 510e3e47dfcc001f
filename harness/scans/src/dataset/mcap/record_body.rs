//! The bodies of MCAP's records, as far as they are used.
//!
//! The format's own crate would trust the lengths of texts in the file.

use std::collections::BTreeMap;

use mcap::records::{ChunkHeader, MessageIndexEntry};

/// Reads the parts of a record from front to back. Errors are the rest of a sentence about the file.
#[derive(Debug, Clone)]
pub struct RecordBody<'a> {
    rest: &'a [u8],
}

/// The beginning of a schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaName {
    /// Its number.
    pub id: u16,
    /// Its name.
    pub name: String,
}

/// The beginning of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelRecord {
    /// Its number.
    pub id: u16,
    /// The number of its schema.
    pub schema_id: u16,
    /// Its topic.
    pub topic: String,
    /// How its messages are encoded.
    pub encoding: String,
}

impl<'a> RecordBody<'a> {
    /// The record with this body.
    pub fn new(body: &'a [u8]) -> Self {
        Self { rest: body }
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or("has a record that is cut off")?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn u16(&mut self) -> Result<u16, String> {
        self.bytes().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.bytes().map(u64::from_le_bytes)
    }

    /// Bytes, after their number.
    fn block(&mut self) -> Result<&'a [u8], String> {
        let n = self.u32()? as usize;
        let (block, rest) = self.rest.split_at_checked(n).ok_or("has a record that is cut off")?;
        self.rest = rest;
        Ok(block)
    }

    fn text(&mut self) -> Result<String, String> {
        let text =
            std::str::from_utf8(self.block()?).map_err(|_| "has a record with a text that is not UTF-8")?;
        Ok(text.to_owned())
    }

    /// Number and name of a schema.
    pub fn schema(mut self) -> Result<SchemaName, String> {
        Ok(SchemaName { id: self.u16()?, name: self.text()? })
    }

    /// A channel without its metadata.
    pub fn channel(mut self) -> Result<ChannelRecord, String> {
        let (id, schema_id) = (self.u16()?, self.u16()?);
        Ok(ChannelRecord { id, schema_id, topic: self.text()?, encoding: self.text()? })
    }

    /// The channel of a message, and its log time in nanoseconds.
    pub fn message(mut self) -> Result<(u16, u64), String> {
        let (channel_id, _sequence) = (self.u16()?, self.u32()?);
        Ok((channel_id, self.u64()?))
    }

    /// The channel of a message index, and its entries.
    pub fn message_index(mut self) -> Result<(u16, Vec<MessageIndexEntry>), String> {
        let channel_id = self.u16()?;
        let (entries, _) = self.block()?.as_chunks::<16>();
        let entry = |entry: &[u8; 16]| {
            let mut entry = RecordBody { rest: entry };
            Ok(MessageIndexEntry { log_time: entry.u64()?, offset: entry.u64()? })
        };
        Ok((channel_id, entries.iter().map(entry).collect::<Result<_, String>>()?))
    }

    /// The header of a chunk, and the length of that header.
    pub fn chunk_header(mut self) -> Result<(ChunkHeader, usize), String> {
        let n_bytes = self.rest.len();
        let header = ChunkHeader {
            message_start_time: self.u64()?,
            message_end_time: self.u64()?,
            uncompressed_size: self.u64()?,
            uncompressed_crc: self.u32()?,
            compression: self.text()?,
            compressed_size: self.u64()?,
        };
        Ok((header, n_bytes - self.rest.len()))
    }

    /// The name of a metadata record, and its pairs of names and values.
    pub fn metadata(mut self) -> Result<(String, BTreeMap<String, String>), String> {
        let name = self.text()?;
        let mut pairs = RecordBody { rest: self.block()? };
        let mut metadata = BTreeMap::new();
        while !pairs.rest.is_empty() {
            metadata.insert(pairs.text()?, pairs.text()?);
        }
        Ok((name, metadata))
    }

    /// The start of the summary from the footer; 0 if there is none.
    pub fn footer(mut self) -> Result<u64, String> {
        self.u64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_claim_more_than_there_is_are_refused() {
        let schema = [1, 0, 2, 0, 0, 0, b'a', b'b'];
        assert_eq!(RecordBody::new(&schema).schema(), Ok(SchemaName { id: 1, name: "ab".to_owned() }));
        for claim in [3, 255] {
            let mut damaged = schema;
            damaged[2] = claim;
            damaged[5] = claim;
            assert!(RecordBody::new(&damaged).schema().unwrap_err().contains("cut off"));
        }
        assert!(RecordBody::new(&[1, 0, 1, 0, 0, 0, 255]).schema().unwrap_err().contains("UTF-8"));
        assert!(RecordBody::new(&[1]).channel().is_err() && RecordBody::new(&[]).footer().is_err());
    }

    #[test]
    fn indexes_and_metadata_are_taken_apart() {
        let mut index = vec![7, 0, 16, 0, 0, 0];
        index.extend(5_u64.to_le_bytes());
        index.extend(9_u64.to_le_bytes());
        let expected = vec![MessageIndexEntry { log_time: 5, offset: 9 }];
        assert_eq!(RecordBody::new(&index).message_index(), Ok((7, expected)));
        let metadata = [1, 0, 0, 0, b'n', 10, 0, 0, 0, 1, 0, 0, 0, b'k', 1, 0, 0, 0, b'v'];
        let expected = BTreeMap::from([("k".to_owned(), "v".to_owned())]);
        assert_eq!(RecordBody::new(&metadata).metadata(), Ok(("n".to_owned(), expected)));
    }
}
