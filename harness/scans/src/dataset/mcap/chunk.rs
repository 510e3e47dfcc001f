//! Chunks of an MCAP file: decompresses them, checks them, and divides them into records.

use std::io::Read as _;

use mcap::records::ChunkHeader;

/// A chunk may grow to this many bytes, or to this many times its compressed size, whichever is more. Real scans shrink to a
/// third; a chunk that claims more is no recording of a sensor.
const MAX_CHUNK_BYTES: u64 = 64 << 20;
const MAX_GROWTH: u64 = 64;

/// The decompressed records of a chunk, one after the other. Errors are the rest of a sentence about the file.
pub fn decompressed(header: &ChunkHeader, compressed: &[u8]) -> Result<Vec<u8>, String> {
    let limit = MAX_CHUNK_BYTES.max(compressed.len() as u64 * MAX_GROWTH);
    if header.uncompressed_size > limit {
        let (size, n) = (header.uncompressed_size, compressed.len());
        return Err(format!("has a chunk of {n} bytes that claims to be {size} uncompressed"));
    }
    let size = header.uncompressed_size as usize;
    let mut records = Vec::new();
    // One byte more than announced, so that a chunk that is too long is noticed.
    let read = match header.compression.as_str() {
        "" => {
            records.extend_from_slice(compressed);
            Ok(compressed.len())
        }
        "zstd" => zstd::Decoder::new(compressed)
            .and_then(|decoder| decoder.take(size as u64 + 1).read_to_end(&mut records)),
        "lz4" => lz4::Decoder::new(compressed)
            .and_then(|decoder| decoder.take(size as u64 + 1).read_to_end(&mut records)),
        other => return Err(format!("has a chunk with the unknown compression {other:?}")),
    };
    read.map_err(|error| format!("has a chunk that does not decompress: {error}"))?;
    if records.len() != size {
        let found = records.len();
        return Err(format!("has a chunk of at least {found} bytes that should have {size}"));
    }
    let crc = crc32fast::hash(&records);
    if header.uncompressed_crc != 0 && crc != header.uncompressed_crc {
        let expected = header.uncompressed_crc;
        return Err(format!("has a chunk with checksum {crc:08x} that should have {expected:08x}"));
    }
    Ok(records)
}

/// Opcode and length of a record.
pub const N_RECORD_HEADER_BYTES: usize = 9;

/// The record that begins at `offset` of `records`: its opcode, its body, and the start of the next one.
pub fn record_at(records: &[u8], offset: usize) -> Option<(u8, &[u8], usize)> {
    let header = records.get(offset..)?.first_chunk::<N_RECORD_HEADER_BYTES>()?;
    let (opcode, n_bytes) = split_header(header);
    let begin = offset + N_RECORD_HEADER_BYTES;
    let end = begin.checked_add(usize::try_from(n_bytes).ok()?)?;
    Some((opcode, records.get(begin..end)?, end))
}

/// Opcode of a record and length of its body.
pub fn split_header(header: &[u8; N_RECORD_HEADER_BYTES]) -> (u8, u64) {
    let [opcode, length @ ..] = header;
    (*opcode, u64::from_le_bytes(*length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(compression: &str, uncompressed_size: u64) -> ChunkHeader {
        ChunkHeader {
            message_start_time: 0,
            message_end_time: 0,
            uncompressed_size,
            uncompressed_crc: 0,
            compression: compression.to_owned(),
            compressed_size: 0,
        }
    }

    #[track_caller]
    fn check_refused(header: &ChunkHeader, compressed: &[u8], part: &str) {
        let problem = decompressed(header, compressed).expect_err("damaged");
        assert!(problem.contains(part), "{problem}");
    }

    #[test]
    fn what_was_compressed_comes_back() {
        let records = vec![7; 1000];
        let compressed = zstd::encode_all(&records[..], 0).unwrap();
        assert_eq!(decompressed(&header("zstd", 1000), &compressed).unwrap(), records);
        assert_eq!(decompressed(&header("", 1000), &records).unwrap(), records);
    }

    #[test]
    fn sizes_that_are_not_kept_are_refused() {
        let compressed = zstd::encode_all(&[7; 1000][..], 0).unwrap();
        check_refused(&header("zstd", 999), &compressed, "of at least 1000 bytes that should have 999");
        check_refused(&header("zstd", 1001), &compressed, "of at least 1000 bytes that should have 1001");
        check_refused(&header("", 4), &[0; 5], "of at least 5 bytes that should have 4");
        check_refused(&header("zstd", u64::MAX), &compressed, "claims to be 18446744073709551615");
        check_refused(&header("lz4", 1000), &compressed, "does not decompress");
        check_refused(&header("rar", 1000), &compressed, "\"rar\"");
    }

    #[test]
    fn a_wrong_checksum_is_refused() {
        let wrong = ChunkHeader { uncompressed_crc: 1, ..header("", 4) };
        check_refused(&wrong, &[0; 4], "checksum 2144df1c that should have 00000001");
    }

    #[test]
    fn a_record_that_ends_beyond_the_chunk_is_none() {
        let mut records = vec![5, 2, 0, 0, 0, 0, 0, 0, 0, 8, 9];
        assert_eq!(record_at(&records, 0), Some((5, &[8, 9][..], 11)));
        assert_eq!((record_at(&records, 11), record_at(&records, usize::MAX)), (None, None));
        records[1] = 3;
        assert_eq!(record_at(&records, 0), None);
        records[8] = 255;
        assert_eq!(record_at(&records, 0), None);
    }
}
