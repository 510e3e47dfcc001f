//! `.label` files: for every point of the scan a little-endian u32, the class in the lower half, the instance in the upper.

use std::path::Path;

use crate::annotation::LabeledScan;
use crate::dataset::DatasetError;
use crate::dataset::on_disk::bytes_of;
use crate::dataset::positioned_points::values_of_kept;

/// The labels of the points of `scan`, from the file at `path`, which has one for each point of the scan's file.
pub fn read_labels_of_kept(path: &Path, scan: &LabeledScan) -> Result<Vec<u32>, DatasetError> {
    let labels = parse_label_file(path, &bytes_of(path)?, scan.cloud.len() + scan.points_left_out.len())?;
    Ok(values_of_kept(&labels, &scan.points_left_out))
}

/// The labels in `bytes`, one for each of `n_points`; `path` is named in errors.
pub fn parse_label_file(path: &Path, bytes: &[u8], n_points: usize) -> Result<Vec<u32>, DatasetError> {
    let (labels, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(DatasetError::partial_point(path, bytes.len(), 4));
    }
    if labels.len() != n_points {
        return Err(DatasetError::label_count(path, labels.len(), n_points));
    }
    Ok(labels.iter().map(|label| u32::from_le_bytes(*label)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(bytes: &[u8], n_points: usize, expected: Result<&[u32], &str>) {
        let found = parse_label_file(Path::new("a.label"), bytes, n_points).map_err(|it| it.to_string());
        assert_eq!(found, expected.map(<[u32]>::to_vec).map_err(str::to_owned));
    }

    #[test]
    fn labels_are_read_in_order() {
        check(&[10, 0, 208, 0, 80, 0, 0, 0], 2, Ok(&[0x00d0_000a, 80]));
        check(&[], 0, Ok(&[]));
    }

    #[test]
    fn a_file_of_another_scan_is_refused_with_both_numbers() {
        check(&[0; 8], 3, Err(r#""a.label" has 2 labels, but its scan has 3 points"#));
        check(
            &[0; 7],
            2,
            Err(r#""a.label" is damaged or cut off: its 7 bytes are not a multiple of the 4 of a point"#),
        );
    }
}
