//! LAS and LAZ in folders of scans, with labels on a map.

use harness::annotation::AnnotationClass;
use laz::laszip::LazVlrBuilder;
use laz::{LasZipCompressor, LazItemRecordBuilder, LazItemType};

use super::made::write;
use super::{check_damaged, open};
use crate::program::Workplace;

/// Points of a drawn hill, in centimetres from the offset.
fn hill(n_points: i32) -> Vec<[i32; 3]> {
    (0..n_points).map(|it| [it * 7 % 4000 - 2000, it * 13 % 3000 - 1500, it % 200]).collect()
}

/// A file of version 1.4 with points of format 0, or 6 in layers, compressed or not.
pub fn file(points: &[[i32; 3]], offset_m: [f64; 3], format: u8, is_compressed: bool) -> Vec<u8> {
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

/// A folder with each kind of file.
pub fn drawn() -> Workplace {
    let workplace = Workplace::new();
    for (number, (format, is_compressed)) in
        [(0, false), (0, true), (6, false), (6, true)].into_iter().enumerate()
    {
        let name = format!("drive/{number}.{}", if is_compressed { "laz" } else { "las" });
        write(&workplace.path(&name), file(&hill(2000), [0.0; 3], format, is_compressed));
    }
    workplace
}

#[test]
fn compressed_and_plain_points_are_the_same() {
    let workplace = drawn();
    let dataset = open(&workplace.path("drive"));
    assert_eq!(dataset.description().format, "scan-folder");
    for scan_idx in 0..4 {
        let scan = dataset.read_scan(scan_idx).unwrap();
        assert_eq!(scan.cloud.len(), 2000);
        for (found, expected) in scan.cloud.positions_m().zip(hill(2000)) {
            assert!(
                (0..3).all(|axis| (found[axis] - expected[axis] as f32 * 0.01).abs() < 1e-4),
                "{found:?}"
            );
        }
        assert!((scan.cloud.intensity()[7] - 1000.0 / 65535.0).abs() < 1e-6);
    }
    workplace.succeed(&["detect", "drive/1.laz", "--sensor-height", "0"]);
}

#[test]
fn points_and_labels_on_a_map_move_together() {
    let workplace = Workplace::new();
    let offset_m = [691_000.0, 5_336_000.0, 520.0];
    write(
        &workplace.path("map/labels/0.json"),
        r#"[{"class": "car", "center_m": [691010.0, 5336005.0, 521.0],
        "length_width_height_m": [8.0, 8.0, 4.0], "yaw_rad": 0.0}]"#,
    );
    write(&workplace.path("map/0.laz"), file(&hill(2000), offset_m, 6, true));
    let dataset = open(&workplace.path("map"));
    let pose = dataset.world_from_sensor(0).unwrap().unwrap();
    let origin = pose.translation.vector;
    assert_eq!([origin.x, origin.y, origin.z], [691_000.0, 5_336_000.0, 520.0]);
    let scan = dataset.read_scan(0).unwrap();
    let car = &scan.annotations[0];
    assert_eq!(car.class, AnnotationClass::Car);
    assert_eq!(car.bounding_box.unwrap().center_m, [10.0, 5.0, 1.0]);
    let inside =
        hill(2000).into_iter().filter(|[x, y, _]| (x - 1000).abs() <= 400 && (y - 500).abs() <= 400).count();
    assert!(
        inside > 50 && car.point_indices.len().abs_diff(inside) < 5,
        "{} {inside}",
        car.point_indices.len()
    );
}

#[test]
fn what_is_cut_off_is_named() {
    for (format, is_compressed) in [(0, true), (6, true), (0, false)] {
        let workplace = Workplace::new();
        let mut bytes = file(&hill(2000), [0.0; 3], format, is_compressed);
        bytes.truncate(bytes.len() - 100);
        write(&workplace.path("drive/0.las"), &bytes);
        check_damaged(&workplace.path("drive"), &["0.las"]);
        bytes.truncate(1000);
        write(&workplace.path("drive/0.las"), &bytes);
        check_damaged(&workplace.path("drive"), &["0.las"]);
    }
}
