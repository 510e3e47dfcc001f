//! Scans as Velodyne `.bin` files: per point x, y, z in metres and intensity, as little-endian f32, and nothing else.

use std::path::Path;

use detector::PointCloud;

use super::DatasetError;
use super::position_check::check_positions;

/// Four values of four bytes.
const N_BYTES_PER_POINT: usize = 16;

/// Reads the scan at `path`.
///
/// The file has no header, so that one that was cut between two points cannot be told from a shorter scan. Points whose
/// coordinates are NaN or infinite have no position.
///
/// # Errors
///
/// [`DatasetError::Io`]; [`DatasetError::NoPoints`] for an empty file; [`DatasetError::PartialPoint`] for a size that is not
/// a multiple of 16 bytes; [`DatasetError::Damaged`] for a coordinate that no sensor sees.
pub fn read_velodyne_bin(path: &Path) -> Result<PointCloud, DatasetError> {
    // Read, not mapped into memory: a mapped file that another program cuts off ends the process.
    let bytes =
        std::fs::read(path).map_err(|source| DatasetError::Io { path: path.to_path_buf(), source })?;
    parse_velodyne_bin(path, &bytes)
}

/// The scan in `bytes`; `path` is named in errors.
///
/// # Errors
///
/// As [`read_velodyne_bin`].
pub fn parse_velodyne_bin(path: &Path, bytes: &[u8]) -> Result<PointCloud, DatasetError> {
    if bytes.is_empty() {
        return Err(DatasetError::NoPoints { path: path.to_path_buf() });
    }
    let (points, rest) = bytes.as_chunks::<N_BYTES_PER_POINT>();
    if !rest.is_empty() {
        return Err(DatasetError::PartialPoint {
            path: path.to_path_buf(),
            n_bytes: bytes.len(),
            n_bytes_per_point: N_BYTES_PER_POINT,
        });
    }
    let mut cloud = PointCloud::with_capacity(points.len());
    for point in points {
        let [x_m, y_m, z_m, intensity] = values_of(point);
        cloud.push([x_m, y_m, z_m], intensity);
    }
    check_positions(&cloud).map_err(|problem| DatasetError::Damaged { path: path.to_path_buf(), problem })?;
    Ok(cloud)
}

fn values_of(point: &[u8; N_BYTES_PER_POINT]) -> [f32; 4] {
    let (values, _) = point.as_chunks::<4>();
    std::array::from_fn(|column_idx| f32::from_le_bytes(values[column_idx]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::position_check::n_without_position;
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
        let cloud = parse_velodyne_bin(Path::new("a.bin"), &bytes).expect("sound");
        assert!(cloud.positions_m().eq([[1.0, -2.0, 3.5], [4.0, 5.0, -6.0]]));
        assert_eq!(cloud.intensity(), [0.25, 0.0]);
    }

    #[test]
    fn an_empty_scan_is_refused() {
        check_refused(&[], r#""a.bin" holds no points"#);
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
    fn points_without_a_position_keep_their_places() {
        let bytes =
            bytes_of(&[[1.0; 4], [1.0, f32::NAN, 1.0, 1.0], [1.0, 1.0, f32::NEG_INFINITY, 1.0], [2.0; 4]]);
        let cloud = parse_velodyne_bin(Path::new("a.bin"), &bytes).expect("sound");
        assert_eq!((cloud.len(), n_without_position(&cloud)), (4, 2));
        assert_eq!(cloud.position_m(3), [2.0; 3]);
    }

    #[test]
    fn a_coordinate_that_no_sensor_sees_is_refused_with_its_point() {
        let bytes = bytes_of(&[[1.0; 4], [1.0, -3e7, 1.0, 1.0]]);
        check_refused(
            &bytes,
            r#""a.bin" has point 1 with y = -30000000 m, but no sensor sees farther than 10000 m"#,
        );
    }

    proptest! {
        #[test]
        fn any_bytes_give_their_points_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            if let Ok(cloud) = parse_velodyne_bin(Path::new("a.bin"), &bytes) {
                prop_assert_eq!(cloud.len() * N_BYTES_PER_POINT, bytes.len());
                prop_assert!(cloud.positions_m().flatten().all(|it| !it.is_finite() || it.abs() <= 10_000.0));
            }
        }
    }
}
