//! A street made of a few thousand points, seen from a sensor 1.73 m above the road.

use detector::PointCloud;

/// Height of the sensor above the road in metres.
pub const SENSOR_HEIGHT_M: f32 = 1.73;

/// Distance of neighbouring points on a surface in metres.
const SPACING_M: f32 = 0.1;

/// A street that is drawn surface by surface.
#[derive(Default)]
pub struct DrawnStreet {
    cloud: PointCloud,
}

impl DrawnStreet {
    /// A level road of 30 m by 20 m around the sensor.
    pub fn road() -> Self {
        let mut street = Self::default();
        let spacing_m = 2.0 * SPACING_M;
        for along in 0..150 {
            for across in 0..100 {
                let x_m = (along as f32 + 0.5) * spacing_m - 15.0;
                let y_m = (across as f32 + 0.5) * spacing_m - 10.0;
                street.cloud.push([x_m, y_m, -SENSOR_HEIGHT_M], 0.0);
            }
        }
        street
    }

    /// Adds the sides and the top of an upright block whose footprint is `x_m` by `y_m`, from the road up to
    /// `height_m` above it.
    pub fn block(mut self, x_m: [f32; 2], y_m: [f32; 2], height_m: f32) -> Self {
        // From clear of the road on, so that which points are foreground does not hang on rounding.
        let z_m = [0.2 - SENSOR_HEIGHT_M, height_m - SENSOR_HEIGHT_M];
        for &x in &steps(x_m) {
            for &y in &steps(y_m) {
                let is_side = x_m.contains(&x) || y_m.contains(&y);
                for &z in &steps(z_m) {
                    if is_side || z == z_m[1] {
                        self.cloud.push([x, y, z], 0.0);
                    }
                }
            }
        }
        self
    }

    /// Adds the surface of a vehicle with the side profile `contour_m` (along, up from the road), 1.8 m wide, whose middle
    /// is at `center_m` and whose front looks forward.
    pub fn vehicle(mut self, center_m: [f32; 2], contour_m: &[[f32; 2]]) -> Self {
        for (from_m, to_m) in contour_m.iter().zip(contour_m.iter().cycle().skip(1)) {
            let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
            for share in steps([0.0, length_m]).iter().map(|it| it / length_m) {
                let [along, up] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
                for &across in &steps([-0.9, 0.9]) {
                    let position_m = [center_m[0] + along, center_m[1] + across, up - SENSOR_HEIGHT_M];
                    self.cloud.push(position_m, 0.0);
                }
            }
        }
        self
    }

    /// The points.
    pub fn cloud(self) -> PointCloud {
        self.cloud
    }
}

/// Values from the first to the second end, both included, no more than [`SPACING_M`] apart.
fn steps(ends_m: [f32; 2]) -> Vec<f32> {
    let n_steps = ((ends_m[1] - ends_m[0]) / SPACING_M).ceil().max(1.0);
    let between =
        (0..n_steps as usize).map(|step| ends_m[0] + step as f32 * (ends_m[1] - ends_m[0]) / n_steps);
    between.chain([ends_m[1]]).collect()
}

/// Two cars 0.4 m apart, bumper to bumper in one coarse cell, a person, a pole and a façade.
pub fn main_road() -> PointCloud {
    DrawnStreet::road()
        .block([4.1, 8.3], [2.1, 3.9], 1.5)
        .block([8.7, 12.7], [2.2, 4.0], 1.5)
        .block([5.2, 5.7], [-4.3, -3.9], 1.8)
        .block([-6.1, -5.9], [3.1, 3.3], 5.0)
        .block([-12.0, 12.0], [-9.0, -8.5], 8.0)
        .cloud()
}
