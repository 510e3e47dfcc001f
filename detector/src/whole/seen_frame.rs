//! The frame of the seen part of a vehicle.

use crate::oriented_box::OrientedBox;
use crate::portable_math::single;

/// A box whose sides are named by how near they are to the sensor, which is the origin of the scan.
///
/// In its frame u runs along the length and v along the width, both from the centre and away from the sensor. So the near
/// end is at the lowest u, and the near side at the lowest v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenFrame {
    center_m: [f32; 2],
    /// Unit vectors of u and v in the scan; a left-handed pair where that leads away from the sensor.
    axes: [[f32; 2]; 2],
    /// Half the length and half the width, in metres.
    pub half_m: [f32; 2],
    /// Distance of the centre from the sensor along u and along v, in metres; neither is negative.
    pub from_sensor_m: [f32; 2],
}

impl SeenFrame {
    /// The frame of a box.
    pub fn of(seen: &OrientedBox) -> Self {
        let [x_m, y_m, _] = seen.center_m;
        let [length_m, width_m, _] = seen.length_width_height_m;
        let (sin, cos) = single::sin_cos(seen.yaw_rad);
        let away = |[x, y]: [f32; 2]| if x * x_m + y * y_m < 0.0 { [-x, -y] } else { [x, y] };
        let axes = [away([cos, sin]), away([-sin, cos])];
        Self {
            center_m: [x_m, y_m],
            axes,
            half_m: [0.5 * length_m, 0.5 * width_m],
            from_sensor_m: axes.map(|[x, y]| x * x_m + y * y_m),
        }
    }

    /// A position of the scan in this frame, in metres.
    pub fn position_m(&self, [x_m, y_m]: [f32; 2]) -> [f32; 2] {
        let (dx, dy) = (x_m - self.center_m[0], y_m - self.center_m[1]);
        self.axes.map(|[x, y]| x * dx + y * dy)
    }

    /// A position of this frame in the scan, in metres.
    pub fn in_scan_m(&self, [u_m, v_m]: [f32; 2]) -> [f32; 2] {
        let [[ux, uy], [vx, vy]] = self.axes;
        [self.center_m[0] + u_m * ux + v_m * vx, self.center_m[1] + u_m * uy + v_m * vy]
    }

    /// The direction of an axis in the scan, a unit vector: 0 is u, 1 is v.
    pub fn axis(&self, axis: usize) -> [f32; 2] {
        self.axes[axis]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_sensor_is_beyond_the_near_end_and_the_near_side(
            x in -30.0_f32..30.0, y in -30.0_f32..30.0, yaw_rad in -3.1_f32..3.1, at in prop::array::uniform2(-9.0_f32..9.0),
        ) {
            let seen = OrientedBox { center_m: [x, y, 0.0], length_width_height_m: [4.0, 1.8, 1.5], yaw_rad };
            let frame = SeenFrame::of(&seen);
            let [u_m, v_m] = frame.position_m([0.0, 0.0]);
            prop_assert!(u_m <= 1e-4 && v_m <= 1e-4);
            prop_assert!((u_m + frame.from_sensor_m[0]).abs() < 1e-3 && (v_m + frame.from_sensor_m[1]).abs() < 1e-3);
            let again_m = frame.position_m(frame.in_scan_m(at));
            prop_assert!((0..2).all(|axis| (again_m[axis] - at[axis]).abs() < 1e-4));
            for [x_m, y_m] in seen.footprint_m() {
                let [u_m, v_m] = frame.position_m([x_m, y_m]);
                prop_assert!((u_m.abs() - 2.0).abs() < 1e-4 && (v_m.abs() - 0.9).abs() < 1e-4);
            }
        }
    }
}
