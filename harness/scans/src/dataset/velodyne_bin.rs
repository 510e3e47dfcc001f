//! Scans as Velodyne `.bin` files: per point x, y, z in metres and intensity, as little-endian f32, and nothing else.

use std::path::Path;

use super::DatasetError;
use super::on_disk::bytes_of;
use super::positioned_points::PositionedPoints;

/// Four values of four bytes.
const N_BYTES_PER_POINT: usize = 16;

/// Reads the scan at `path`.
///
/// The file has no header, so that a file cut between two points cannot be distinguished from a shorter scan.
pub fn read_velodyne_bin(path: &Path) -> Result<PositionedPoints, DatasetError> {
    parse_velodyne_bin(path, &bytes_of(path)?)
}

/// The scan in `bytes`; `path` is named in errors.
pub fn parse_velodyne_bin(path: &Path, bytes: &[u8]) -> Result<PositionedPoints, DatasetError> {
    PositionedPoints::of_rows(path, bytes, |row| {
        let [x_m, y_m, z_m, intensity] = values_of(row);
        ([x_m, y_m, z_m], intensity)
    })
}

fn values_of(point: &[u8; N_BYTES_PER_POINT]) -> [f32; 4] {
    let (values, _) = point.as_chunks::<4>();
    std::array::from_fn(|column_idx| f32::from_le_bytes(values[column_idx]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes_of(points: &[[f32; 4]]) -> Vec<u8> {
        points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
    }

    #[track_caller]
    fn check_refused(bytes: &[u8], message: &str) {
        let error = parse_velodyne_bin(Path::new("a.bin"), bytes).expect_err("damaged");
        assert_eq!(error.to_string(), message);
        assert!(!error.is_usage_error());
    }

    #[test]
    fn points_come_out_as_they_went_in() {
        let bytes = bytes_of(&[[1.0, -2.0, 3.5, 0.25], [4.0, 5.0, -6.0, 0.0]]);
        let (cloud, _) = parse_velodyne_bin(Path::new("a.bin"), &bytes).expect("sound").into_parts();
        assert!(cloud.positions_m().eq([[1.0, -2.0, 3.5], [4.0, 5.0, -6.0]]));
        assert_eq!(cloud.intensity(), [0.25, 0.0]);
    }

    #[test]
    fn an_empty_scan_is_refused() {
        check_refused(&[], r#""a.bin" has no points"#);
    }

    #[test]
    fn a_scan_cut_within_a_point_is_refused_with_both_sizes() {
        let bytes = bytes_of(&[[1.0; 4]; 3]);
        check_refused(
            &bytes[..41],
            r#""a.bin" is damaged or cut off: its 41 bytes are not a multiple of the 16 of a point"#,
        );
    }

    #[test]
    fn a_scan_shorter_than_a_point_is_refused() {
        check_refused(
            &[0; 7],
            r#""a.bin" is damaged or cut off: its 7 bytes are not a multiple of the 16 of a point"#,
        );
    }

    #[test]
    fn a_point_without_a_position_is_left_out() {
        let bytes =
            bytes_of(&[[1.0; 4], [1.0, f32::NAN, 1.0, 1.0], [2.0; 4], [1.0, 1.0, f32::NEG_INFINITY, 1.0]]);
        let (cloud, left_out) = parse_velodyne_bin(Path::new("a.bin"), &bytes).expect("sound").into_parts();
        assert!(cloud.positions_m().eq([[1.0; 3], [2.0; 3]]), "{cloud:?}");
        assert_eq!(left_out, [1, 3]);
        check_refused(&bytes[16..32], r#""a.bin" has 1 points, but none with a position"#);
    }

    #[test]
    fn a_point_too_far_off_is_damage_with_its_index_and_value() {
        check_refused(
            &bytes_of(&[[1.0; 4], [1.0, 1.0, -12_000.5, 1.0]]),
            r#""a.bin" has point 1 at z = -12000.500 m, beyond 10000 m from the origin"#,
        );
    }

    proptest! {
        #[test]
        fn any_bytes_give_their_points_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            if let Ok(points) = parse_velodyne_bin(Path::new("a.bin"), &bytes) {
                prop_assert_eq!(points.n_in_file() * N_BYTES_PER_POINT, bytes.len());
                prop_assert!(points.cloud().positions_m().flatten().all(f32::is_finite));
            }
        }
    }
}
