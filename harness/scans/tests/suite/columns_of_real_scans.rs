//! How many columns real scans have, by their numbers alone.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};

use scans::dataset::point_columns::PointColumns;
use scans::dataset::scan_columns::ScanColumns;
use test_data::test_data;

/// The scans below `folder`.
fn scans_below(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    entries.sort();
    let is_scan = |it: &PathBuf| it.extension().is_some_and(|it| it == "bin");
    let below = |it: PathBuf| if it.is_dir() { scans_below(&it) } else { vec![it] };
    entries.into_iter().flat_map(below).filter(is_scan).collect()
}

/// Rows of the first `n` points of `bytes`, which have four columns, with more columns behind.
fn with_columns(bytes: &[u8], n: usize, more: impl Fn(usize, [f32; 4]) -> Vec<f32>) -> Vec<u8> {
    let (rows, _) = bytes.as_chunks::<16>();
    let wider = |(index, row): (usize, &[u8; 16])| {
        let (values, _) = row.as_chunks::<4>();
        let values: [f32; 4] = std::array::from_fn(|it| f32::from_le_bytes(values[it]));
        [&values[..], &more(index, values)].concat()
    };
    rows.iter().enumerate().take(n).flat_map(wider).flat_map(f32::to_le_bytes).collect()
}

/// The laser of 64 that sees a point, nearly.
fn ring_of([x_m, y_m, z_m, _]: [f32; 4]) -> f32 {
    let elevation_deg = z_m.atan2(x_m.hypot(y_m)).to_degrees();
    ((elevation_deg + 25.0) / 27.0 * 63.0).round().clamp(0.0, 63.0)
}

/// Every scan by itself, as it is and with more columns, of a number of points that 16 and 20 bytes divide.
#[test]
#[ignore = "needs data in SCANBENCH_TEST_DATA"]
fn every_scan_is_read_alike_whatever_columns_follow() {
    let scans = scans_below(&test_data("data"));
    assert!(scans.len() >= 111, "{}", scans.len());
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("a.bin");
    for scan in &scans {
        let bytes = std::fs::read(scan).unwrap();
        let n = bytes.len() / 16 / 32 * 32;
        let columns = ScanColumns::new(None, PointColumns::of_kitti(), std::slice::from_ref(scan));
        let (original, _) = columns.read(scan).unwrap().into_parts();
        assert_eq!(original.len(), bytes.len() / 16, "{}", scan.display());
        let described = columns.described().unwrap().unwrap();
        assert_eq!(described, "x,y,z,intensity, as the numbers look", "{}", scan.display());
        let time_s = |index: usize| index as f32 * 1e-6;
        let variants: [(&str, Vec<u8>); 5] = [
            ("x,y,z,intensity", with_columns(&bytes, n, |_, _| Vec::new())),
            ("x,y,z,intensity,ring", with_columns(&bytes, n, |_, it| vec![ring_of(it)])),
            ("x,y,z,intensity,_", with_columns(&bytes, n, |index, _| vec![time_s(index)])),
            ("x,y,z,intensity,_", with_columns(&bytes, n, |_, _| vec![0.0])),
            ("x,y,z,intensity,ring,_", with_columns(&bytes, n, |index, it| vec![ring_of(it), time_s(index)])),
        ];
        for (expected, bytes) in variants {
            std::fs::write(&copy, &bytes).unwrap();
            let columns = ScanColumns::new(None, PointColumns::of_kitti(), std::slice::from_ref(&copy));
            let (cloud, _) = columns.read(&copy).unwrap().into_parts();
            let described = columns.described().unwrap().unwrap();
            assert_eq!(described, format!("{expected}, as the numbers look"), "{}", scan.display());
            assert!(cloud.positions_m().eq(original.positions_m().take(n)), "{}", scan.display());
            assert_eq!(cloud.intensity(), &original.intensity()[..n], "{}", scan.display());
        }
    }
}
