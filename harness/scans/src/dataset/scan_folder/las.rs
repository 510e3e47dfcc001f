//! LAS and LAZ, the formats of surveys: a header, then records whose coordinates are whole numbers, to be scaled and
//! shifted.
//!
//! LAZ is decompressed chunk by chunk, so that no value in a file decides how much memory is used.

use std::io::Cursor;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use laz::laszip::ChunkTable;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItem, LazItemType, LazVlr};

use super::scan_file::ScanPoints;
use crate::dataset::positioned_points::{MAX_COORDINATE_M, PositionedPoints};

/// Compressed points may grow to this many times the bytes of the file.
const MAX_GROWTH: u64 = 256;

/// The names of the record with the compression's parameters.
const LAZ_RECORD: (&[u8], u16) = (b"laszip encoded", 22_204);

/// The kinds of compression: all points in one, in chunks, in chunks with a layer for each field.
const POINTWISE: u16 = 1;
const CHUNKED: u16 = 2;
const LAYERED: u16 = 3;

/// Set in the format of points if they are compressed.
const COMPRESSED: u8 = 0x80;

struct Header {
    data_offset: usize,
    record_length: usize,
    n_points: u64,
    scale: [f64; 3],
    offset_m: [f64; 3],
    compression: Option<LazCompression>,
}

/// How points are compressed.
struct LazCompression {
    kind: u16,
    parameters: LazVlr,
}

/// The points in `bytes`, in metres. Errors are the rest of a sentence about the file.
///
/// If points are farther than 10 km from zero, as on a map (single precision would round them), the origin becomes a point
/// with whole coordinates: the middle of their extent on the ground plan, and its least height. The extent in the header is
/// ignored: writers leave it at zero, or at that of a whole tile.
pub fn parse_las(bytes: &[u8]) -> Result<ScanPoints, String> {
    let header = parse_header(bytes)?;
    let mut records = Vec::new();
    let mut take = |record: &[u8]| {
        let whole = |axis: usize| {
            let at = 4 * axis;
            i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
        };
        records.push(([0, 1, 2].map(whole), u16::from_le_bytes([record[12], record[13]])));
    };
    match &header.compression {
        None => {
            let data = &bytes[header.data_offset..];
            let n_held = (data.len() / header.record_length) as u64;
            if n_held < header.n_points {
                return Err(format!("announces {} points but has {n_held}", header.n_points));
            }
            data.chunks_exact(header.record_length).take(header.n_points as usize).for_each(&mut take);
        }
        Some(compression) => {
            // The decoder is not ours: a panic in it is taken as damage.
            let decompressed =
                catch_unwind(AssertUnwindSafe(|| decompress(bytes, &header, compression, &mut take)));
            decompressed.unwrap_or_else(|_| Err("has compressed points that cannot be read".to_owned()))?;
        }
    }
    positioned(&header, &records)
}

/// The points of `records`, which hold coordinates and intensity as in the file.
fn positioned(header: &Header, records: &[([i32; 3], u16)]) -> Result<ScanPoints, String> {
    let origin_m = origin_of(header, records);
    let mut points = PositionedPoints::with_capacity(records.len());
    for (whole, intensity) in records {
        let position_m: [f64; 3] = std::array::from_fn(|axis| {
            f64::from(whole[axis]) * header.scale[axis] + (header.offset_m[axis] - origin_m[axis])
        });
        let intensity = f32::from(*intensity) / f32::from(u16::MAX);
        points.push(position_m, intensity).map_err(|problem| match origin_m {
            [0.0, 0.0, 0.0] => problem,
            [x, y, z] => format!("{problem}, which is at {x} {y} {z} on its map: cut it into tiles"),
        })?;
    }
    Ok(ScanPoints { points, origin_m })
}

/// Reads numbers of a header whose length has been checked.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|index| self.0[at + index])
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.bytes(at))
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.bytes(at))
    }

    fn f64s<const N: usize>(&self, at: usize) -> [f64; N] {
        std::array::from_fn(|index| f64::from_le_bytes(self.bytes(at + 8 * index)))
    }
}

fn parse_header(bytes: &[u8]) -> Result<Header, String> {
    /// Lengths of the header of version 1.0, and of that of 1.4, which has the number of points as 64 bits.
    const LEAST: usize = 227;
    const WITH_LONG_COUNT: usize = 255;
    /// No scale or offset of a map is greater.
    const MOST: f64 = 1e9;
    if !bytes.starts_with(b"LASF") || bytes.len() < LEAST {
        return Err("is not a LAS file, or is cut off within its header".to_owned());
    }
    let fields = Fields(bytes);
    let (minor, header_length) = (bytes[25], usize::from(fields.u16(94)));
    let (data_offset, n_records) = (fields.u32(96) as usize, fields.u32(100));
    let (point_format, record_length) = (bytes[104], usize::from(fields.u16(105)));
    if !(LEAST..=bytes.len()).contains(&header_length)
        || !(header_length..=bytes.len()).contains(&data_offset)
        || record_length < 20
    {
        return Err(format!(
            "has a header of {header_length} bytes, points of {record_length} from byte {data_offset} on, and {} in all",
            bytes.len()
        ));
    }
    let n_points = if minor >= 4 && header_length >= WITH_LONG_COUNT {
        u64::from_le_bytes(fields.bytes(247))
    } else {
        u64::from(fields.u32(107))
    };
    let is_compressed = point_format & COMPRESSED != 0;
    let records = &bytes[header_length..data_offset];
    let header = Header {
        data_offset,
        record_length,
        n_points,
        scale: fields.f64s(131),
        offset_m: fields.f64s(155),
        compression: if is_compressed { Some(compression_of(records, n_records)?) } else { None },
    };
    let numbers = [header.scale, header.offset_m];
    if let Some(number) = numbers.as_flattened().iter().find(|it| it.is_nan() || it.abs() > MOST) {
        return Err(format!("has a header with the number {number}, which is not within {MOST} either way"));
    }
    Ok(header)
}

/// The parameters of the compression, from the records behind the header.
fn compression_of(mut records: &[u8], n_records: u32) -> Result<LazCompression, String> {
    const HEAD: usize = 54;
    for _ in 0..n_records {
        let Some((head, rest)) = records.split_at_checked(HEAD) else { break };
        let fields = Fields(head);
        let Some((content, rest)) = rest.split_at_checked(usize::from(fields.u16(20))) else { break };
        if head[2..18].starts_with(LAZ_RECORD.0) && fields.u16(18) == LAZ_RECORD.1 {
            let not_known = |error| format!("has an unknown compression: {error}");
            let parameters = LazVlr::from_buffer(content).map_err(not_known)?;
            let kind = Fields(content).u16(0);
            return if [POINTWISE, CHUNKED, LAYERED].contains(&kind) {
                Ok(LazCompression { kind, parameters })
            } else {
                Err(format!("has a compression of the unknown kind {kind}"))
            };
        }
        records = rest;
    }
    Err("has compressed points, but no record of the compression".to_owned())
}

fn origin_of(header: &Header, records: &[([i32; 3], u16)]) -> [f64; 3] {
    let extent_m = |axis: usize| {
        let of_axis = records.iter().map(|(whole, _)| whole[axis]);
        let ends = [of_axis.clone().min(), of_axis.max()].map(|it| f64::from(it.unwrap_or_default()));
        let ends_m = ends.map(|it| it * header.scale[axis] + header.offset_m[axis]);
        // A scale may be negative.
        [ends_m[0].min(ends_m[1]), ends_m[0].max(ends_m[1])]
    };
    let extents_m = [0, 1, 2].map(extent_m);
    if extents_m.as_flattened().iter().all(|it| it.abs() <= MAX_COORDINATE_M) {
        return [0.0; 3];
    }
    let middle_m = |[min_m, max_m]: [f64; 2]| f64::midpoint(min_m, max_m).round();
    [middle_m(extents_m[0]), middle_m(extents_m[1]), extents_m[2][0].floor()]
}

fn decompress(
    bytes: &[u8],
    header: &Header,
    compression: &LazCompression,
    take: &mut impl FnMut(&[u8]),
) -> Result<(), String> {
    let n_bytes = bytes.len() as u64;
    let items_size = compression.parameters.items_size();
    if items_size != header.record_length as u64 {
        return Err(format!("has points of {} bytes, but compresses {items_size}", header.record_length));
    }
    if header.n_points.saturating_mul(items_size) > n_bytes.saturating_mul(MAX_GROWTH) {
        return Err(format!("announces {} points in {n_bytes} bytes", header.n_points));
    }
    let mut n_left = header.n_points;
    let mut record = vec![0; header.record_length];
    for (position, n_points_at_most) in chunks_of(bytes, header, compression)? {
        if n_left == 0 {
            return Ok(());
        }
        let chunk = bytes.get(position).ok_or("has a chunk that ends beyond its end")?;
        // The first point of a chunk is not compressed, so there are no more chunks than bytes for such points.
        if n_points_at_most == 0 || chunk.len() < header.record_length {
            return Err(format!("has a chunk of {n_points_at_most} points in {} bytes", chunk.len()));
        }
        let is_layered = compression.kind == LAYERED;
        if is_layered {
            check_layers(chunk, header.record_length, n_layers_of(&compression.parameters))?;
        }
        let cursor = Cursor::new(chunk);
        let mut decompressor: Box<dyn RecordDecompressor<Cursor<&[u8]>>> = if is_layered {
            Box::new(LayeredPointRecordDecompressor::new(cursor))
        } else {
            Box::new(SequentialPointRecordDecompressor::new(cursor))
        };
        let unknown = |error: laz::LasZipError| format!("has points of an unknown kind: {error}");
        decompressor.set_fields_from(compression.parameters.items()).map_err(unknown)?;
        // No other fields are used.
        let wanted = DecompressionSelection::XY_RETURNS_CHANNEL
            | DecompressionSelection::Z
            | DecompressionSelection::INTENSITY;
        decompressor.set_selection(DecompressionSelection(wanted));
        for _ in 0..n_points_at_most.min(n_left) {
            let cut_off = |error| format!("has {n_left} points fewer than announced: {error}");
            decompressor.decompress_next(&mut record).map_err(cut_off)?;
            take(&record);
            n_left -= 1;
        }
    }
    if n_left == 0 { Ok(()) } else { Err(format!("has {n_left} points fewer than announced")) }
}

/// The range of bytes of each chunk, one behind the other, and the most points that it holds.
fn chunks_of(
    bytes: &[u8],
    header: &Header,
    compression: &LazCompression,
) -> Result<Vec<(Range<usize>, u64)>, String> {
    const TABLE_OFFSET: usize = 8;
    let begin = header.data_offset;
    if compression.kind == POINTWISE {
        return Ok(vec![(begin..bytes.len(), header.n_points)]);
    }
    // A writer that cannot go back leaves -1 here and writes the position at the end.
    let long = |at: usize| {
        let eight = bytes.get(at..at + 8)?;
        Some(i64::from_le_bytes(eight.try_into().ok()?))
    };
    let said = long(begin).and_then(|it| if it > 0 { Some(it) } else { long(bytes.len().checked_sub(8)?) });
    let position = said.and_then(|it| usize::try_from(it).ok()).filter(|it| *it > begin);
    let n_chunks = position.and_then(|it| bytes.get(it..)).and_then(|table| table.get(4..8));
    let n_chunks = n_chunks.and_then(|it| it.try_into().ok()).map(u32::from_le_bytes);
    match n_chunks {
        // Every chunk takes at least a point, except for an empty one at the end; this bounds the table.
        Some(n_chunks) if n_chunks as usize <= bytes.len() / header.record_length + 1 => {}
        _ => return Err("has no table of chunks, or one larger than the file".to_owned()),
    }
    let mut cursor = Cursor::new(bytes);
    cursor.set_position(begin as u64);
    let table = ChunkTable::read_from(&mut cursor, &compression.parameters);
    let table = table.map_err(|error| format!("has a table of chunks that cannot be read: {error}"))?;
    let mut chunks = Vec::with_capacity(table.as_ref().len());
    let mut at = (begin + TABLE_OFFSET) as u64;
    for entry in table.as_ref() {
        let end = at.saturating_add(entry.byte_count);
        let position = |at: u64| usize::try_from(at).unwrap_or(usize::MAX);
        chunks.push((position(at)..position(end), entry.point_count));
        at = end;
    }
    Ok(chunks)
}

/// Number of layers of a chunk: nine of the point itself, and those of its further fields.
fn n_layers_of(parameters: &LazVlr) -> usize {
    let n_layers = |it: &LazItem| match it.item_type() {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => usize::from(count),
        _ => 1,
    };
    parameters.items().iter().map(n_layers).sum()
}

/// Makes sure that the layers claim no more bytes than the chunk has.
///
/// A chunk begins with a whole point and a number of points, then come the lengths of the layers.
fn check_layers(chunk: &[u8], record_length: usize, n_layers: usize) -> Result<(), String> {
    let lengths = chunk.get(record_length + 4..record_length + 4 + 4 * n_layers);
    let lengths = lengths.ok_or("has a chunk that is cut off")?;
    let (lengths, _) = lengths.as_chunks::<4>();
    let n_bytes: u64 = lengths.iter().map(|it| u64::from(u32::from_le_bytes(*it))).sum();
    if n_bytes > chunk.len() as u64 {
        return Err(format!("has layers of {n_bytes} bytes in a chunk of {}", chunk.len()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of version 1.2 with points of format 0.
    fn file(points: &[[i32; 3]], offset_m: [f64; 3]) -> Vec<u8> {
        let mut bytes = vec![0; 227];
        bytes[..4].copy_from_slice(b"LASF");
        bytes[24..26].copy_from_slice(&[1, 2]);
        bytes[94..96].copy_from_slice(&227_u16.to_le_bytes());
        bytes[96..100].copy_from_slice(&227_u32.to_le_bytes());
        bytes[105..107].copy_from_slice(&20_u16.to_le_bytes());
        bytes[107..111].copy_from_slice(&(points.len() as u32).to_le_bytes());
        for axis in 0..3 {
            bytes[131 + 8 * axis..139 + 8 * axis].copy_from_slice(&0.01_f64.to_le_bytes());
            bytes[155 + 8 * axis..163 + 8 * axis].copy_from_slice(&offset_m[axis].to_le_bytes());
            let values = points.iter().map(|it| f64::from(it[axis]) * 0.01 + offset_m[axis]);
            let (least, most) =
                values.fold((f64::MAX, f64::MIN), |(least, most), it| (least.min(it), most.max(it)));
            bytes[179 + 16 * axis..187 + 16 * axis].copy_from_slice(&most.to_le_bytes());
            bytes[187 + 16 * axis..195 + 16 * axis].copy_from_slice(&least.to_le_bytes());
        }
        for point in points {
            bytes.extend(point.iter().flat_map(|it| it.to_le_bytes()));
            bytes.extend(32_768_u16.to_le_bytes());
            bytes.extend([0; 6]);
        }
        bytes
    }

    #[test]
    fn coordinates_are_scaled_and_shifted() {
        let found = parse_las(&file(&[[100, -250, 33], [0, 0, 0]], [0.5, 0.0, -1.0])).unwrap();
        let cloud = found.points.cloud();
        assert!(cloud.positions_m().eq([[1.5, -2.5, -0.67], [0.5, 0.0, -1.0]]), "{cloud:?}");
        assert!((cloud.intensity()[0] - 0.5).abs() < 1e-4);
        assert_eq!(found.origin_m, [0.0; 3]);
    }

    #[test]
    fn the_origin_moves_to_points_on_a_map() {
        let found =
            parse_las(&file(&[[0, 0, 0], [1001, 2000, 300]], [500_000.25, 5_400_000.0, 210.5])).unwrap();
        assert_eq!(found.origin_m, [500_005.0, 5_400_010.0, 210.0]);
        let [x, y, z] = found.points.cloud().position_m(0);
        assert!((x + 4.75).abs() < 1e-6 && (y + 10.0).abs() < 1e-6 && (z - 0.5).abs() < 1e-6);
    }

    #[test]
    fn the_extent_in_the_header_is_not_looked_at() {
        let on_map = || file(&[[0, 0, 0], [1000, 2000, 300]], [500_000.0, 5_400_000.0, 210.0]);
        let expected = parse_las(&on_map()).unwrap();
        assert_eq!(expected.origin_m, [500_005.0, 5_400_010.0, 210.0]);
        let near = || file(&[[0, 0, 0], [1000, 2000, 300]], [0.0; 3]);
        let of_near = parse_las(&near()).unwrap();
        for extent_m in [0.0, f64::NAN, -1e300, 500_000.0, 20_000.0] {
            // Greatest and least value take turns.
            let with_extent = |mut bytes: Vec<u8>| {
                for (at, sign) in (179..227).step_by(8).zip([1.0, -1.0].into_iter().cycle()) {
                    bytes[at..at + 8].copy_from_slice(&(sign * extent_m).to_le_bytes());
                }
                parse_las(&bytes).unwrap()
            };
            assert_eq!((with_extent(on_map()), with_extent(near())), (expected.clone(), of_near.clone()));
        }
    }

    #[test]
    fn what_is_damaged_is_refused() {
        let refused = |change: &dyn Fn(&mut Vec<u8>), part: &str| {
            let mut bytes = file(&[[1, 2, 3]; 3], [0.0; 3]);
            change(&mut bytes);
            let problem = parse_las(&bytes).expect_err("damaged");
            assert!(problem.contains(part), "{problem}");
        };
        refused(&|it| it.truncate(100), "cut off within its header");
        refused(&|it| it.truncate(280), "announces 3 points but has 2");
        refused(&|it| it[107..111].fill(0xff), "announces 4294967295 points");
        refused(&|it| it[96..100].fill(0xff), "from byte 4294967295 on");
        refused(&|it| it[105] = 4, "points of 4");
        refused(
            &|it| it[131..139].copy_from_slice(&f64::NAN.to_le_bytes()),
            "a header with the number NaN, which",
        );
        refused(
            &|it| it[155..163].copy_from_slice(&2e9_f64.to_le_bytes()),
            "a header with the number 2000000000, which is not within 1000000000 either way",
        );
        refused(&|it| it[104] = COMPRESSED, "no record of the compression");
        // A wider survey has no origin that is near all its points.
        let wide = file(&[[0, 0, 0], [2_400_000, 0, 0]], [500_000.0, 0.0, 0.0]);
        let problem = parse_las(&wide).expect_err("two ends");
        assert!(problem.ends_with("which is at 512000 0 0 on its map: cut it into tiles"), "{problem}");
    }
}
