//! From KITTI's boxes in the camera frame to ours in the velodyne frame.

use detector::OrientedBox;
use nalgebra::{Matrix4, Vector4};

use super::label::CameraBox;

/// The box in the velodyne frame.
///
/// Centre and heading are carried over exactly. The box stands upright in the camera frame and ours stands upright in the
/// velodyne frame; the frames are tilted by about a degree, so that ends of a car may differ by some centimetres.
pub fn box_in_velodyne(camera_box: &CameraBox, velodyne_from_camera: &Matrix4<f64>) -> OrientedBox {
    let [x, bottom_y, z] = camera_box.bottom_center_m;
    let [height_m, width_m, length_m] = camera_box.height_width_length_m;
    // The camera's y points down.
    let center_m = velodyne_from_camera * Vector4::new(x, bottom_y - height_m / 2.0, z, 1.0);
    let (sin, cos) = camera_box.rotation_y_rad.sin_cos();
    // A direction, hence 0 in the last place. The turn about y takes x to (cos, 0, -sin).
    let heading = velodyne_from_camera * Vector4::new(cos, 0.0, -sin, 0.0);
    OrientedBox {
        center_m: [center_m.x as f32, center_m.y as f32, center_m.z as f32],
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
        for (found_m, expected_m) in found.center_m.into_iter().zip([10.0, -2.0, -1.0]) {
            assert!((found_m - expected_m).abs() < 1e-6, "{found:?}");
        }
        assert_eq!(found.length_width_height_m, [4.0, 1.6, 1.4]);
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
