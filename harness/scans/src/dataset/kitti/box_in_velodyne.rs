//! From KITTI's boxes in the camera frame to ours in the velodyne frame.

use detector::OrientedBox;
use nalgebra::{Matrix4, Vector4};

use super::label::CameraBox;

/// The box in the velodyne frame.
///
/// Heading and centre of the bottom are carried over exactly. KITTI's box stands upright in the camera frame, ours in the
/// velodyne frame; these are tilted against each other by about a degree, so that the roof of a car may be off by some
/// two centimetres and its bumpers by as much in height.
pub fn box_in_velodyne(camera_box: &CameraBox, velodyne_from_camera: &Matrix4<f64>) -> OrientedBox {
    let [x, y, z] = camera_box.bottom_center_m;
    let [height_m, width_m, length_m] = camera_box.height_width_length_m;
    let bottom_center_m = velodyne_from_camera * Vector4::new(x, y, z, 1.0);
    let center_z_m = bottom_center_m.z + height_m / 2.0;
    let (sin, cos) = camera_box.rotation_y_rad.sin_cos();
    // A direction, hence 0 in the last place. The turn about y takes x to (cos, 0, -sin).
    let heading = velodyne_from_camera * Vector4::new(cos, 0.0, -sin, 0.0);
    OrientedBox {
        center_m: [bottom_center_m.x as f32, bottom_center_m.y as f32, center_z_m as f32],
        length_width_height_m: [length_m as f32, width_m as f32, height_m as f32],
        yaw_rad: heading.y.atan2(heading.x) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::calibration::tests::FORWARD_CAMERA;
    use std::f32::consts::{FRAC_PI_2, PI};
    use std::path::Path;

    /// A car 10 m ahead and 2 m to the right of a camera 1.7 m above the road.
    #[track_caller]
    fn check(rotation_y_rad: f64, expected_yaw_rad: f32) {
        let calibration = parse_calibration(Path::new("c.txt"), FORWARD_CAMERA).unwrap();
        let camera_box = CameraBox {
            bottom_center_m: [2.0, 1.7, 10.0],
            height_width_length_m: [1.4, 1.6, 4.0],
            rotation_y_rad,
        };
        let found = box_in_velodyne(&camera_box, &calibration.velodyne_from_camera);
        let found_m = found.center_m.into_iter().chain(found.length_width_height_m);
        for (found_m, expected_m) in found_m.zip([10.0, -2.0, -1.0, 4.0, 1.6, 1.4]) {
            assert!((found_m - expected_m).abs() < 1e-6, "{found:?}");
        }
        assert!((found.yaw_rad - expected_yaw_rad).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn what_heads_to_the_right_of_the_camera_heads_to_minus_y() {
        check(0.0, -FRAC_PI_2);
    }

    #[test]
    fn what_drives_ahead_heads_along_x() {
        check(-f64::from(FRAC_PI_2), 0.0);
    }

    #[test]
    fn turns_have_opposite_signs() {
        check(-f64::from(FRAC_PI_2) - 0.3, 0.3);
    }

    #[test]
    fn what_heads_to_the_left_heads_to_y() {
        check(f64::from(PI), FRAC_PI_2);
    }
}
