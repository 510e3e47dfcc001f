//! The calibration of a day: transforms between sensor, cameras and the inertial unit.
//!
//! ```text
//! calib_velo_to_cam.txt   R, T: from the sensor to camera 0
//! calib_cam_to_cam.txt    R_rect_00, P_rect_02 and S_rect_02, the size of the image
//! calib_imu_to_velo.txt   R, T: from the inertial unit to the sensor
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Matrix3x4, Matrix4, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::dataset::DatasetError;
use crate::dataset::kitti::calibration::check_rotation;
use crate::dataset::text_file::text_lines;

/// The view of the left colour camera, and the rectified frame of the cameras.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraView {
    /// From homogeneous velodyne coordinates to homogeneous pixels of camera 2.
    pub image_from_velodyne: Matrix3x4<f64>,
    /// From homogeneous coordinates of the rectified frame to those of the sensor.
    pub velodyne_from_camera: Matrix4<f64>,
    /// Width and height of its image in pixels.
    pub image_size_px: [u32; 2],
}

/// Reads the view of the camera from the texts of `calib_velo_to_cam.txt` and `calib_cam_to_cam.txt`.
pub fn parse_camera_view(
    velo_to_cam: (&Path, &str),
    cam_to_cam: (&Path, &str),
) -> Result<CameraView, DatasetError> {
    let camera_from_velodyne = parse_transform(velo_to_cam.0, velo_to_cam.1)?;
    let entries = Entries::parse(cam_to_cam.0, cam_to_cam.1)?;
    let rectification: [f64; 9] = entries.numbers("R_rect_00")?;
    let rectification = Matrix3::from_row_slice(&rectification);
    check_rotation(cam_to_cam.0, "R_rect_00", &rectification)?;
    let projection: [f64; 12] = entries.numbers("P_rect_02")?;
    let [width_px, height_px] = entries.numbers("S_rect_02")?;
    let rectified_from_velodyne =
        rectification.to_homogeneous() * Matrix4::from(camera_from_velodyne.to_homogeneous());
    let velodyne_from_camera =
        rectified_from_velodyne.try_inverse().expect("two rotations and a shift can be undone");
    Ok(CameraView {
        image_from_velodyne: Matrix3x4::from_row_slice(&projection) * rectified_from_velodyne,
        velodyne_from_camera,
        // Negative and fractional sizes become small ones.
        image_size_px: [width_px as u32, height_px as u32],
    })
}

/// Reads the lines `R` and `T` of a calibration file.
pub fn parse_transform(path: &Path, text: &str) -> Result<Isometry3<f64>, DatasetError> {
    let entries = Entries::parse(path, text)?;
    let rotation: [f64; 9] = entries.numbers("R")?;
    let rotation = Matrix3::from_row_slice(&rotation);
    check_rotation(path, "R", &rotation)?;
    let shift: [f64; 3] = entries.numbers("T")?;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(shift)), rotation))
}

/// The numbers of the lines that are used, by name.
struct Entries<'a> {
    path: &'a Path,
    numbers: BTreeMap<&'static str, Vec<f64>>,
}

impl<'a> Entries<'a> {
    fn parse(path: &'a Path, text: &str) -> Result<Self, DatasetError> {
        const NAMES: [&str; 5] = ["R", "T", "R_rect_00", "P_rect_02", "S_rect_02"];
        let mut numbers = BTreeMap::new();
        for mut line in text_lines(path, text) {
            let word = line.word("name")?.trim_end_matches(':');
            let Some(name) = NAMES.iter().find(|name| **name == word) else { continue };
            let mut values = Vec::new();
            while line.has_more() {
                values.push(line.number(name)?);
            }
            if numbers.insert(*name, values).is_some() {
                return Err(line.error("gives a matrix twice".to_owned()));
            }
        }
        Ok(Self { path, numbers })
    }

    fn numbers<const N: usize>(&self, name: &'static str) -> Result<[f64; N], DatasetError> {
        let found = self.numbers.get(name).and_then(|it| it.as_slice().try_into().ok());
        found.ok_or_else(|| DatasetError::calibration_entry(self.path, name))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{Vector3, Vector4};

    pub(crate) const VELO_TO_CAM: &str =
        "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n";
    pub(crate) const CAM_TO_CAM: &str = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\nS_rect_02: 1242 375\n\
        R_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_02: 700 0 621 0 0 700 187 0 0 0 1 0\n";

    fn view(velo_to_cam: &str, cam_to_cam: &str) -> Result<CameraView, String> {
        let parsed = parse_camera_view((Path::new("v.txt"), velo_to_cam), (Path::new("c.txt"), cam_to_cam));
        parsed.map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_ahead_is_in_the_middle_of_the_image() {
        let view = view(VELO_TO_CAM, CAM_TO_CAM).unwrap();
        let pixel = view.image_from_velodyne * Vector4::new(10.0, 0.0, 0.0, 1.0);
        assert!((pixel - Vector3::new(6210.0, 1870.0, 10.0)).norm() < 1e-9, "{pixel}");
        assert_eq!(view.image_size_px, [1242, 375]);
    }

    #[test]
    fn what_is_missing_or_no_rotation_is_named() {
        let refused = |velo_to_cam: &str, cam_to_cam: &str, part: &str| {
            let message = view(velo_to_cam, cam_to_cam).expect_err("damaged");
            assert!(message.contains(part), "{message}");
        };
        refused("", CAM_TO_CAM, "\"v.txt\" has no line R");
        refused(VELO_TO_CAM, "", "\"c.txt\" has no line R_rect_00");
        refused(VELO_TO_CAM, &CAM_TO_CAM.replace("S_rect_02: 1242", "S_rect_02:"), "no line S_rect_02");
        refused(&VELO_TO_CAM.replace("R: 0 -1", "R: 0 -2"), CAM_TO_CAM, "not a rotation");
        refused(&format!("{VELO_TO_CAM}T: 1 2 3"), CAM_TO_CAM, "gives a matrix twice");
        refused(&VELO_TO_CAM.replace("T: 0", "T: x"), CAM_TO_CAM, "\"x\" is not a number");
    }
}
