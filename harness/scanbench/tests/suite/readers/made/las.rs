//! LAS and LAZ.

use laz::laszip::LazVlrBuilder;
use laz::{LasZipCompressor, LazItemRecordBuilder, LazItemType};

/// A file of version 1.4 with points of format 0, or 6 in layers, compressed or not.
pub fn las_file(points: &[[i32; 3]], offset_m: [f64; 3], format: u8, is_compressed: bool) -> Vec<u8> {
    let record_length = if format == 6 { 30 } else { 20 };
    let mut records = Vec::new();
    for point in points {
        let begin = records.len();
        records.extend(point.iter().flat_map(|it| it.to_le_bytes()));
        records.extend(1000_u16.to_le_bytes());
        records.push(if format == 6 { 0x11 } else { 9 });
        records.resize(begin + record_length, 0);
    }
    let (mut compression, mut data) = (Vec::new(), records.clone());
    if is_compressed {
        let mut items = LazItemRecordBuilder::new();
        items.add_item(if format == 6 { LazItemType::Point14 } else { LazItemType::Point10 });
        let vlr = LazVlrBuilder::new(items.build()).with_fixed_chunk_size(700).build();
        vlr.write_to(&mut compression).unwrap();
        // The table says where chunks begin from the beginning of the file on.
        let mut out = std::io::Cursor::new(vec![0; 375 + 54 + compression.len()]);
        out.set_position(out.get_ref().len() as u64);
        let mut compressor = LasZipCompressor::new(out, vlr).unwrap();
        compressor.compress_many(&records).unwrap();
        compressor.done().unwrap();
        data = compressor.into_inner().into_inner().split_off(375 + 54 + compression.len());
    }
    let mut bytes = vec![0; 375];
    bytes[..4].copy_from_slice(b"LASF");
    bytes[24..26].copy_from_slice(&[1, 4]);
    bytes[94..96].copy_from_slice(&375_u16.to_le_bytes());
    let n_before = 375 + if is_compressed { 54 + compression.len() } else { 0 };
    bytes[96..100].copy_from_slice(&(n_before as u32).to_le_bytes());
    bytes[100] = u8::from(is_compressed);
    bytes[104] = format | if is_compressed { 0x80 } else { 0 };
    bytes[105..107].copy_from_slice(&(record_length as u16).to_le_bytes());
    bytes[247..255].copy_from_slice(&(points.len() as u64).to_le_bytes());
    for axis in 0..3 {
        bytes[131 + 8 * axis..139 + 8 * axis].copy_from_slice(&0.01_f64.to_le_bytes());
        bytes[155 + 8 * axis..163 + 8 * axis].copy_from_slice(&offset_m[axis].to_le_bytes());
        let values = || points.iter().map(|it| f64::from(it[axis]) * 0.01 + offset_m[axis]);
        let (most, least) = (values().fold(f64::MIN, f64::max), values().fold(f64::MAX, f64::min));
        bytes[179 + 16 * axis..187 + 16 * axis].copy_from_slice(&most.to_le_bytes());
        bytes[187 + 16 * axis..195 + 16 * axis].copy_from_slice(&least.to_le_bytes());
    }
    if is_compressed {
        let mut head = vec![0; 54];
        head[2..16].copy_from_slice(b"laszip encoded");
        head[18..20].copy_from_slice(&22_204_u16.to_le_bytes());
        head[20..22].copy_from_slice(&(compression.len() as u16).to_le_bytes());
        bytes.extend(head);
        bytes.extend(compression);
    }
    bytes.extend(data);
    bytes
}
