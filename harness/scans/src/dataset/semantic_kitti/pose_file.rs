//! `poses.txt`, `times.txt` and `calib.txt` of a drive: poses of the sensor and their times.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::dataset::DatasetError;
use crate::dataset::text_file::text_lines;

/// A matrix whose columns are off right angles and unit length by more than this is no rotation.
const MAX_ROTATION_DEVIATION: f64 = 1e-3;

/// Reads one pose per line, twelve numbers each: the upper three rows of a matrix, row by row.
pub fn parse_poses(path: &Path, text: &str) -> Result<Vec<Isometry3<f64>>, DatasetError> {
    text_lines(path, text)
        .map(|mut line| {
            let rows: [f64; 12] = line.numbers("pose")?;
            line.clone().end()?;
            isometry_of(&rows).ok_or_else(|| line.error("a pose whose matrix is not a rotation".to_owned()))
        })
        .collect()
}

/// Reads one time per line, in seconds, and converts it to nanoseconds.
pub fn parse_times(path: &Path, text: &str) -> Result<Vec<u64>, DatasetError> {
    text_lines(path, text)
        .map(|mut line| {
            let seconds = line.number("time")?;
            line.clone().end()?;
            if seconds < 0.0 {
                return Err(line.error(format!("time {seconds} is negative")));
            }
            Ok((seconds * 1e9).round() as u64)
        })
        .collect()
}

/// The pose of the sensor in the frame of the camera that the poses are of: the line `Tr` of `calib.txt`.
pub fn parse_camera_from_sensor(path: &Path, text: &str) -> Result<Isometry3<f64>, DatasetError> {
    for mut line in text_lines(path, text) {
        if line.word("name")? == "Tr:" {
            let rows: [f64; 12] = line.numbers("matrix")?;
            line.clone().end()?;
            return isometry_of(&rows)
                .ok_or_else(|| line.error("a pose whose matrix is not a rotation".to_owned()));
        }
    }
    Err(DatasetError::calibration_entry(path, "Tr"))
}

fn isometry_of(rows: &[f64; 12]) -> Option<Isometry3<f64>> {
    let [a, b, c, x, d, e, f, y, g, h, i, z] = *rows;
    let matrix = Matrix3::new(a, b, c, d, e, f, g, h, i);
    let deviation = (matrix * matrix.transpose() - Matrix3::identity()).abs().max();
    if matrix.determinant() <= 0.0 || deviation > MAX_ROTATION_DEVIATION {
        return None;
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Some(Isometry3::from_parts(Translation3::from(Vector3::new(x, y, z)), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_refused<T: std::fmt::Debug>(found: Result<T, DatasetError>, message: &str) {
        assert_eq!(found.expect_err("damaged").to_string(), message);
    }

    #[test]
    fn a_pose_goes_row_by_row() {
        let poses = parse_poses(Path::new("p.txt"), "0 -1 0 4 1 0 0 5 0 0 1 6\n").unwrap();
        let moved = poses[0] * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((moved - nalgebra::Point3::new(4.0, 6.0, 6.0)).norm() < 1e-9, "{moved}");
    }

    #[test]
    fn times_are_nanoseconds() {
        assert_eq!(parse_times(Path::new("t.txt"), "0\n1.037359e-01\n").unwrap(), [0, 103_735_900]);
        check_refused(parse_times(Path::new("t.txt"), "0\n-1"), r#""t.txt", line 2: time -1 is negative"#);
    }

    #[test]
    fn what_is_no_pose_is_refused() {
        let parse = |text: &str| parse_poses(Path::new("p.txt"), text);
        check_refused(parse("1 0 0 0 0 1 0 0 0 0 1"), r#""p.txt", line 1: ends before its pose"#);
        check_refused(
            parse("2 0 0 0 0 1 0 0 0 0 1 0"),
            r#""p.txt", line 1: a pose whose matrix is not a rotation"#,
        );
        check_refused(
            parse("1 0 0 0 0 1 0 0 0 0 -1 0"),
            r#""p.txt", line 1: a pose whose matrix is not a rotation"#,
        );
        let without = parse_camera_from_sensor(Path::new("c.txt"), "P0: 1");
        check_refused(without, r#""c.txt" has no line Tr"#);
    }
}
