//! KITTI's calibration files: transforms between camera 2, the rectified camera frame and the velodyne frame.

use std::path::Path;

use nalgebra::{Matrix3, Matrix3x4, Matrix4, SMatrix};

use crate::dataset::DatasetError;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::text_file::{TextLine, text_lines};

/// The published matrices are orthonormal to about 1e-6; a matrix that is off by more than this is no rotation.
const MAX_ROTATION_DEVIATION: f64 = 1e-3;

const PROJECTION: &str = "P2";
const RECTIFICATION: &str = "R0_rect or R_rect";
const VELODYNE_TO_CAMERA: &str = "Tr_velo_to_cam or Tr_velo_cam";

/// Transforms between the frames of one drive.
///
/// *Camera* is the rectified frame of KITTI's boxes: x right, y down, z forward, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct KittiCalibration {
    /// From homogeneous velodyne coordinates to homogeneous pixels of camera 2 (`P2 · R0_rect · Tr_velo_to_cam`).
    pub image_from_velodyne: Matrix3x4<f64>,
    /// The inverse of `R0_rect · Tr_velo_to_cam`.
    pub velodyne_from_camera: Matrix4<f64>,
}

impl KittiCalibration {
    /// The frame of results, for an image of this width and height in pixels.
    pub fn foreign_frame(&self, image_size_px: [u32; 2]) -> ForeignFrame {
        ForeignFrame::Camera {
            velodyne_from_camera: self.velodyne_from_camera,
            image_from_velodyne: self.image_from_velodyne,
            image_size_px,
        }
    }
}

/// Reads the calibration in `text`; `path` is named in errors.
///
/// Takes the spellings of both benchmarks: `R0_rect` or `R_rect`, `Tr_velo_to_cam` or `Tr_velo_cam`, with or without a
/// colon. Lines about other sensors are ignored.
pub fn parse_calibration(path: &Path, text: &str) -> Result<KittiCalibration, DatasetError> {
    let mut projection: Option<Matrix3x4<f64>> = None;
    let mut rectification: Option<Matrix3<f64>> = None;
    let mut camera_from_velodyne: Option<Matrix3x4<f64>> = None;
    for mut line in text_lines(path, text) {
        match line.word("name")?.trim_end_matches(':') {
            "P2" => set_once(&mut projection, line),
            "R0_rect" | "R_rect" => set_once(&mut rectification, line),
            "Tr_velo_to_cam" | "Tr_velo_cam" => set_once(&mut camera_from_velodyne, line),
            _ => Ok(()),
        }?;
    }
    let missing = |expected| DatasetError::calibration_entry(path, expected);
    let projection = projection.ok_or_else(|| missing(PROJECTION))?;
    let rectification = rectification.ok_or_else(|| missing(RECTIFICATION))?;
    let camera_from_velodyne = camera_from_velodyne.ok_or_else(|| missing(VELODYNE_TO_CAMERA))?;
    check_rotation(path, RECTIFICATION, &rectification)?;
    check_rotation(path, VELODYNE_TO_CAMERA, &camera_from_velodyne.fixed_columns::<3>(0).into_owned())?;

    let rectified_from_velodyne = rectification.to_homogeneous() * homogeneous(&camera_from_velodyne);
    let velodyne_from_camera =
        rectified_from_velodyne.try_inverse().expect("two rotations and a shift can be undone");
    Ok(KittiCalibration { image_from_velodyne: projection * rectified_from_velodyne, velodyne_from_camera })
}

/// Fills `matrix` with the rest of `line`, whose numbers go row by row.
fn set_once<const R: usize, const C: usize>(
    matrix: &mut Option<SMatrix<f64, R, C>>,
    mut line: TextLine<'_>,
) -> Result<(), DatasetError> {
    if matrix.is_some() {
        return Err(line.error("gives a matrix twice".to_owned()));
    }
    let mut rows = SMatrix::zeros();
    for row in 0..R {
        for column in 0..C {
            rows[(row, column)] = line.number("matrix")?;
        }
    }
    *matrix = Some(rows);
    line.end()
}

/// Makes sure that `matrix`, from the line `entry`, is a rotation up to rounding.
pub fn check_rotation(path: &Path, entry: &'static str, matrix: &Matrix3<f64>) -> Result<(), DatasetError> {
    let deviation = if matrix.determinant() > 0.0 {
        (matrix * matrix.transpose() - Matrix3::identity()).abs().max()
    } else {
        f64::INFINITY
    };
    if deviation <= MAX_ROTATION_DEVIATION {
        return Ok(());
    }
    Err(DatasetError::Unsound(format!(
        "{path:?}: {entry} is not a rotation: its columns differ from right angles and unit length by {deviation}, more than \
         {MAX_ROTATION_DEVIATION}"
    )))
}

/// `transform` with a last row, so that it can be multiplied with others.
fn homogeneous(transform: &Matrix3x4<f64>) -> Matrix4<f64> {
    let mut chainable = Matrix4::identity();
    chainable.fixed_rows_mut::<3>(0).copy_from(transform);
    chainable
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{Vector3, Vector4};
    use proptest::prelude::*;

    /// A camera at the sensor that looks along x: 700 px focal length, centre of the image at (621, 187).
    pub(crate) const FORWARD_CAMERA: &str = "\
P0: 1 0 0 0 0 1 0 0 0 0 1 0
P2: 700 0 621 0 0 700 187 0 0 0 1 0
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0
Tr_imu_to_velo: none of our business
";

    fn parse(text: &str) -> Result<KittiCalibration, DatasetError> {
        parse_calibration(Path::new("c.txt"), text)
    }

    #[track_caller]
    fn check_refused(text: &str, message: &str) {
        let error = parse(text).expect_err("damaged");
        assert_eq!(error.to_string(), message);
        assert!(!error.is_usage_error());
    }

    #[test]
    fn what_is_ahead_is_in_the_middle_of_the_image() {
        let calibration = parse(FORWARD_CAMERA).unwrap();
        let pixel = calibration.image_from_velodyne * Vector4::new(10.0, 0.0, 0.0, 1.0);
        assert_eq!(pixel, Vector3::new(6210.0, 1870.0, 10.0));
        let ahead = calibration.velodyne_from_camera * Vector4::new(0.0, 0.0, 10.0, 1.0);
        assert_eq!(ahead, Vector4::new(10.0, 0.0, 0.0, 1.0));
    }

    #[test]
    fn both_spellings_mean_the_same() {
        let other = FORWARD_CAMERA.replace("R0_rect:", "R_rect").replace("Tr_velo_to_cam:", "Tr_velo_cam");
        assert_eq!(parse(&other).unwrap(), parse(FORWARD_CAMERA).unwrap());
    }

    #[test]
    fn a_missing_matrix_is_named() {
        check_refused("", r#""c.txt" has no line P2"#);
        check_refused(&FORWARD_CAMERA.replace("P2", "P9"), r#""c.txt" has no line P2"#);
        check_refused(&FORWARD_CAMERA.replace("R0", "R9"), r#""c.txt" has no line R0_rect or R_rect"#);
        check_refused(
            &FORWARD_CAMERA.replace("Tr_velo", "Tr_radar"),
            r#""c.txt" has no line Tr_velo_to_cam or Tr_velo_cam"#,
        );
    }

    #[test]
    fn a_malformed_matrix_is_named_with_its_line() {
        check_refused(
            &FORWARD_CAMERA.replace("700 187 0 0 0 1 0", "700"),
            r#""c.txt", line 2: ends before its matrix"#,
        );
        check_refused(
            &FORWARD_CAMERA.replace("1 0 0 0 1 0 0 0 1\n", "1 0 0 0 1 0 0 0 1 7\n"),
            r#""c.txt", line 3: has more than expected: "7""#,
        );
        check_refused(
            &FORWARD_CAMERA.replace("621", "6x1"),
            r#""c.txt", line 2: matrix "6x1" is not a number"#,
        );
        check_refused(
            &format!("{FORWARD_CAMERA}R_rect: 1 0 0 0 1 0 0 0 1"),
            r#""c.txt", line 6: gives a matrix twice"#,
        );
    }

    #[test]
    fn what_is_no_rotation_is_refused_with_both_values() {
        check_refused(
            &FORWARD_CAMERA.replace("R0_rect: 1", "R0_rect: 2"),
            "\"c.txt\": R0_rect or R_rect is not a rotation: its columns differ from right angles and unit length by 3, \
             more than 0.001",
        );
        let reflected = FORWARD_CAMERA.replace("0 0 -1 0 1 0 0 0\n", "0 0 1 0 1 0 0 0\n");
        let message = parse(&reflected).expect_err("a mirror").to_string();
        assert!(message.ends_with("unit length by inf, more than 0.001"), "{message}");
    }

    proptest! {
        #[test]
        fn any_text_gives_a_calibration_or_an_error(text in "\\PC{0,200}") {
            let _ = parse(&text);
        }

        #[test]
        fn any_numbers_give_a_calibration_or_an_error(
            numbers in prop::collection::vec(prop_oneof![any::<f64>(), -2.0..2.0, Just(0.0), Just(1.0)], 33)
        ) {
            let join = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
            let _ = parse(&format!(
                "P2: {}\nR_rect {}\nTr_velo_cam {}",
                join(&numbers[..12]), join(&numbers[12..21]), join(&numbers[21..]),
            ));
        }
    }
}
