//! Files that claim more than they hold, in the smallest records there are: refused at once, with little memory.

use std::path::Path;
use std::time::{Duration, Instant};

use scans::dataset::source::DamagePolicy;

use super::made;
use super::mutations::{Limits, read_within};
use crate::program::Workplace;

/// Reads the data set at `path` with this content under this name and expects `part` in the message.
#[track_caller]
fn check(name: &str, content: &[u8], part: &str) {
    let workplace = Workplace::new();
    workplace.write(name, content);
    let path = if Path::new(name).extension().is_some_and(|it| it == "mcap") {
        workplace.path(name)
    } else {
        workplace.folder().to_owned()
    };
    let limits = Limits { time: Duration::from_secs(10), memory_bytes: 400 << 20 };
    for damage in [DamagePolicy::Refuse, DamagePolicy::Skip] {
        let read = read_within(&path, damage, limits, name);
        let message = read.expect_err("more than there is");
        assert!(damage == DamagePolicy::Skip || message.contains(part), "{name}: {message}");
    }
}

#[test]
fn points_of_no_bytes_are_refused_whatever_their_number() {
    const MOST: &str = "18446744073709551615";
    for n_points in ["4294967295", MOST] {
        for encoding in ["ascii", "binary", "binary_compressed"] {
            let pcd = |fields: &str| format!("{fields}POINTS {n_points}\nDATA {encoding}\n\0\0\0\0\0\0\0\0");
            let empty = pcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 0 0 0\n");
            check("a.pcd", empty.as_bytes(), "has an empty field");
            let one_empty = pcd("FIELDS x y z w\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 0\n");
            check("a.pcd", one_empty.as_bytes(), "has an empty field");
            check("a.pcd", pcd("FIELDS x y z\nSIZE 0 0 0\nTYPE F F F\n").as_bytes(), "size 0");
            check("a.pcd", pcd("FIELDS\nSIZE\nTYPE\nCOUNT\n").as_bytes(), "has 0 fields");
        }
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let ply = format!("ply\nformat {format} 1.0\nelement vertex {n_points}\nend_header\n");
            check("a.ply", ply.as_bytes(), if format == "ascii" { "but has 0" } else { "a.ply" });
        }
        for (shape, order) in [("0", "False"), ("0", "True"), ("3", "False"), ("3", "True")] {
            let header =
                format!("{{'descr': '<f4', 'fortran_order': {order}, 'shape': ({n_points}, {shape})}}");
            let npy =
                [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes()].concat();
            check("a.npy", &npy, "a.npy");
        }
    }
}

#[test]
fn the_program_ends_where_a_compressed_cloud_claims_points_of_no_bytes() {
    let workplace = Workplace::new();
    let header = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 0 0 0\nPOINTS 18446744073709551615\n";
    workplace.write("a.pcd", &format!("{header}DATA binary_compressed\n\0\0\0\0\0\0\0\0"));
    let mut child = workplace.start("detect a.pcd");
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_mins(1) {
        if let Some(status) = child.try_wait().unwrap() {
            assert_eq!(status.code(), Some(3));
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    panic!("it goes on for ever");
}

/// A record of MCAP.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// A chunk that holds `n_bytes` zeros, which are records of no length.
fn chunk_of_zeros(n_bytes: usize) -> Vec<u8> {
    let compressed = zstd::encode_all(&vec![0; n_bytes][..], 3).unwrap();
    let mut body = vec![0; 16];
    body.extend((n_bytes as u64).to_le_bytes());
    body.extend(0_u32.to_le_bytes());
    body.extend(4_u32.to_le_bytes());
    body.extend(b"zstd");
    body.extend((compressed.len() as u64).to_le_bytes());
    body.extend(compressed);
    record(6, &body)
}

#[test]
fn chunks_that_grow_beyond_all_measure_are_refused() {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let header = record(1, &[0; 8]);
    let chunk = chunk_of_zeros(9 * 7_000_000);
    // Each of them is within its limit, and all together are not.
    let file = [MAGIC, &header, &chunk.repeat(6)].concat();
    assert!(file.len() < 1 << 20, "{} bytes", file.len());
    check("a.mcap", &file, "chunks that become too large");
}

/// Where the compressed points of a LAZ file begin, and where its table of chunks is.
fn laz_positions(bytes: &[u8]) -> (usize, usize) {
    let begin = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    let table = i64::from_le_bytes(bytes[begin..begin + 8].try_into().unwrap()) as usize;
    (begin, table)
}

#[test]
fn chunks_and_layers_of_laz_hold_no_more_than_is_there() {
    let points: Vec<[i32; 3]> = (0..2000).map(|it| [it * 7 % 4000, it * 13 % 3000, it % 200]).collect();
    for format in [0, 6] {
        let sound = made::las_file(&points, [0.0; 3], format, true);
        let (begin, table) = laz_positions(&sound);
        // More chunks than there are bytes for their first points.
        let mut many = sound.clone();
        let n_chunks = (sound.len() / 20 + 2) as u32;
        many[table + 4..table + 8].copy_from_slice(&n_chunks.to_le_bytes());
        check("a.laz", &many, "has no table of chunks, or one larger than the file");
        // The lengths of layers come behind a whole point and a number.
        if format == 6 {
            let mut large = sound.clone();
            let at = begin + 8 + 30 + 4;
            large[at..at + 4].fill(0xff);
            check("a.laz", &large, "has layers of ");
        }
    }
}

#[test]
fn what_is_sound_is_read_within_the_same_limits() {
    let workplace = super::scan_folder::drawn();
    let limits = Limits { time: Duration::from_secs(10), memory_bytes: 64 << 20 };
    let path: &Path = &workplace.path("drive");
    read_within(path, DamagePolicy::Refuse, limits, "sound").unwrap();
}
