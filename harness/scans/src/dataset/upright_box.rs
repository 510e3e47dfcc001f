//! Upright boxes from poses in space, and back.

use detector::OrientedBox;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// The box with the centre and turn `frame_from_box`, set upright: its heading on the ground plan is kept. Metres.
pub fn upright_box(frame_from_box: &Isometry3<f64>, length_width_height_m: [f64; 3]) -> OrientedBox {
    let center_m: [f64; 3] = frame_from_box.translation.vector.into();
    let heading = frame_from_box.rotation * Vector3::x();
    OrientedBox {
        center_m: center_m.map(|it| it as f32),
        length_width_height_m: length_width_height_m.map(|it| it as f32),
        yaw_rad: heading.y.atan2(heading.x) as f32,
    }
}

/// The pose of `bounding_box`, in the frame that its values are in.
pub fn pose_of_box(bounding_box: &OrientedBox) -> Isometry3<f64> {
    let [x_m, y_m, z_m] = bounding_box.center_m.map(f64::from);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(bounding_box.yaw_rad));
    Isometry3::from_parts(Translation3::new(x_m, y_m, z_m), turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_tilted_box_keeps_its_heading() {
        let turn = UnitQuaternion::from_euler_angles(0.2, 0.1, 0.5);
        let tilted = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn);
        let upright = upright_box(&tilted, [4.0, 2.0, 1.5]);
        assert_eq!((upright.center_m, upright.length_width_height_m), ([1.0, 2.0, 3.0], [4.0, 2.0, 1.5]));
        assert!((upright.yaw_rad - 0.5).abs() < 1e-6, "{upright:?}");
    }

    proptest! {
        #[test]
        fn a_box_is_that_of_its_pose(
            center_m in prop::array::uniform3(-200.0_f32..200.0),
            length_width_height_m in prop::array::uniform3(0.01_f32..30.0),
            yaw_rad in -3.1_f32..3.1,
        ) {
            let written = OrientedBox { center_m, length_width_height_m, yaw_rad };
            let read = upright_box(&pose_of_box(&written), length_width_height_m.map(f64::from));
            prop_assert_eq!((read.center_m, read.length_width_height_m), (center_m, length_width_height_m));
            prop_assert!((read.yaw_rad - yaw_rad).abs() < 1e-6);
        }
    }
}
