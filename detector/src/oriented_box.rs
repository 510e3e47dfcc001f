//! A box that stands upright and is turned about the vertical.

use crate::portable_math::single;

/// An upright box in the sensor frame.
///
/// ```
/// use detector::OrientedBox;
///
/// // A car ahead that drives to the left.
/// let car = OrientedBox {
///     center_m: [10.0, 0.0, -0.9],
///     length_width_height_m: [4.2, 1.8, 1.5],
///     yaw_rad: std::f32::consts::FRAC_PI_2,
/// };
/// assert!(car.contains([10.0, 2.0, -0.9]));
/// assert!(!car.contains([12.0, 0.0, -0.9]));
/// assert_eq!(car.range_m(), 10.0);
/// let [front_left_m, ..] = car.footprint_m();
/// assert!((front_left_m[0] - 9.1).abs() < 1e-5 && (front_left_m[1] - 2.1).abs() < 1e-5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Centre x, y, z in metres.
    pub center_m: [f32; 3],
    /// Length (along the heading), width and height in metres.
    pub length_width_height_m: [f32; 3],
    /// Heading in radians, counter-clockwise from x seen from above.
    pub yaw_rad: f32,
}

impl OrientedBox {
    /// Whether `position_m` lies inside or on the surface.
    pub fn contains(&self, position_m: [f32; 3]) -> bool {
        let [along_m, across_m, up_m] = self.in_box_frame(position_m);
        let [length_m, width_m, height_m] = self.length_width_height_m;
        along_m.abs() <= length_m / 2.0 && across_m.abs() <= width_m / 2.0 && up_m.abs() <= height_m / 2.0
    }

    /// `position_m` relative to the centre, along length, width and height.
    pub fn in_box_frame(&self, position_m: [f32; 3]) -> [f32; 3] {
        let (sin, cos) = single::sin_cos(self.yaw_rad);
        let dx = position_m[0] - self.center_m[0];
        let dy = position_m[1] - self.center_m[1];
        [cos * dx + sin * dy, cos * dy - sin * dx, position_m[2] - self.center_m[2]]
    }

    /// The four ground-plan corners in metres, counter-clockwise from front left.
    pub fn footprint_m(&self) -> [[f32; 2]; 4] {
        let (sin, cos) = single::sin_cos(self.yaw_rad);
        let [length_m, width_m, _] = self.length_width_height_m;
        [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].map(|(along, across)| {
            let (along_m, across_m) = (along * length_m, across * width_m);
            [
                self.center_m[0] + cos * along_m - sin * across_m,
                self.center_m[1] + sin * along_m + cos * across_m,
            ]
        })
    }

    /// The ground-plan corners of [`Self::footprint_m`] at the elevation of the bottom.
    pub fn bottom_m(&self) -> [[f32; 3]; 4] {
        let bottom_m = self.center_m[2] - 0.5 * self.length_width_height_m[2];
        self.footprint_m().map(|[x_m, y_m]| [x_m, y_m, bottom_m])
    }

    /// Distance of the centre from the sensor on the ground plan, in metres.
    pub fn range_m(&self) -> f32 {
        single::hypot(self.center_m[0], self.center_m[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn car(yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [10.0, -3.0, -0.9], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad }
    }

    #[test]
    fn a_turned_box_contains_what_lies_along_its_heading() {
        let turned = car(std::f32::consts::FRAC_PI_2);
        assert!(turned.contains([10.0, -1.1, -0.9]));
        assert!(!turned.contains([11.9, -3.0, -0.9]));
    }

    #[test]
    fn a_box_does_not_contain_nan() {
        assert!(!car(0.0).contains([f32::NAN, -3.0, -0.9]));
    }

    proptest! {
        #[test]
        fn shrunken_corners_are_inside_and_grown_ones_outside(yaw_rad in -7.0_f32..7.0) {
            let it = car(yaw_rad);
            for [x, y] in it.footprint_m() {
                let toward = |factor: f32| [
                    it.center_m[0] + factor * (x - it.center_m[0]),
                    it.center_m[1] + factor * (y - it.center_m[1]),
                    it.center_m[2],
                ];
                prop_assert!(it.contains(toward(0.99)));
                prop_assert!(!it.contains(toward(1.01)));
            }
        }
    }
}
