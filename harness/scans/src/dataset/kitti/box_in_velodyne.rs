//! Converts KITTI's boxes in the camera frame to ours in the velodyne frame, and back.

use std::f64::consts::TAU;

use detector::OrientedBox;
use nalgebra::{Matrix4, Vector4};

use super::label::CameraBox;

/// The box in the velodyne frame.
///
/// The heading and the centre of the bottom are converted exactly. KITTI's box stands upright in the camera frame, ours in
/// the velodyne frame; the two are tilted against each other by about a degree, so that the roof of a car may be off by some
/// two centimetres and its bumpers by as much in height. Whole turns are kept: they show that angles are in degrees.
pub fn box_in_velodyne(camera_box: &CameraBox, velodyne_from_camera: &Matrix4<f64>) -> OrientedBox {
    let [x, y, z] = camera_box.bottom_center_m;
    let [height_m, width_m, length_m] = camera_box.height_width_length_m;
    let bottom_center_m = velodyne_from_camera * Vector4::new(x, y, z, 1.0);
    let center_z_m = bottom_center_m.z + height_m / 2.0;
    let (sin, cos) = camera_box.rotation_y_rad.sin_cos();
    // A direction, hence 0 as the last component. The turn about y takes x to (cos, 0, -sin).
    let heading = velodyne_from_camera * Vector4::new(cos, 0.0, -sin, 0.0);
    let whole_turns_rad = (camera_box.rotation_y_rad / TAU).trunc() * TAU;
    OrientedBox {
        center_m: [bottom_center_m.x as f32, bottom_center_m.y as f32, center_z_m as f32],
        length_width_height_m: [length_m as f32, width_m as f32, height_m as f32],
        yaw_rad: (heading.y.atan2(heading.x) - whole_turns_rad) as f32,
    }
}

/// The box in the rectified camera frame: [`box_in_velodyne`] of it is `bounding_box`.
pub fn box_in_camera(bounding_box: &OrientedBox, velodyne_from_camera: &Matrix4<f64>) -> CameraBox {
    let [x, y, center_z] = bounding_box.center_m.map(f64::from);
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m.map(f64::from);
    let bottom_center_m = Vector4::new(x, y, center_z - height_m / 2.0, 1.0);
    let camera_from_velodyne = velodyne_from_camera.try_inverse().unwrap_or_else(Matrix4::identity);
    let bottom_center_m = camera_from_velodyne * bottom_center_m;
    // The turn whose direction, (cos, 0, -sin), points along the heading, and not against it, seen from above in the
    // velodyne frame.
    let (yaw_sin, yaw_cos) = f64::from(bounding_box.yaw_rad).sin_cos();
    let across = |column: usize| {
        velodyne_from_camera[(0, column)] * yaw_sin - velodyne_from_camera[(1, column)] * yaw_cos
    };
    let (sin, cos) = (across(0), across(2));
    let along = |sin: f64, cos: f64| {
        let heading = velodyne_from_camera * Vector4::new(cos, 0.0, -sin, 0.0);
        heading.x * yaw_cos + heading.y * yaw_sin
    };
    let sign = if along(sin, cos) < 0.0 { -1.0 } else { 1.0 };
    CameraBox {
        bottom_center_m: [bottom_center_m.x, bottom_center_m.y, bottom_center_m.z],
        height_width_length_m: [height_m, width_m, length_m],
        rotation_y_rad: (sign * sin).atan2(sign * cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::calibration::tests::FORWARD_CAMERA;
    use nalgebra::Rotation3;
    use proptest::prelude::*;
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

    proptest! {
        #[test]
        fn a_box_comes_back_from_a_camera_that_is_tilted(
            center_m in prop::array::uniform3(-80.0_f32..80.0),
            length_width_height_m in prop::array::uniform3(0.1_f32..20.0),
            yaw_rad in -3.1_f32..3.1,
            tilt_rad in prop::array::uniform3(-0.1_f64..0.1),
        ) {
            let forward = parse_calibration(Path::new("c.txt"), FORWARD_CAMERA).unwrap().velodyne_from_camera;
            let [roll, pitch, yaw] = tilt_rad;
            let mut tilted = forward * Rotation3::from_euler_angles(roll, pitch, yaw).to_homogeneous();
            (tilted[(0, 3)], tilted[(2, 3)]) = (0.27, -0.08);
            let written = OrientedBox { center_m, length_width_height_m, yaw_rad };
            let read = box_in_velodyne(&box_in_camera(&written, &tilted), &tilted);
            prop_assert_eq!(read.length_width_height_m, written.length_width_height_m);
            for axis in 0..3 {
                prop_assert!((read.center_m[axis] - written.center_m[axis]).abs() < 1e-4, "{:?}", read);
            }
            prop_assert!((read.yaw_rad - written.yaw_rad).abs() < 1e-5, "{:?}", read);
        }
    }
}
