//! Which objects may be vehicles at all by their size.

use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::oriented_box::OrientedBox;

/// 99 of 100 clusters of vehicles on the simulated streets that models are trained on, parts of vehicles and trucks with
/// their trailers among them, are as long as this, and as wide, and end at this height above the ground, in metres. Of the
/// other clusters more than half do not.
const LENGTHS_M: RangeInclusive<f32> = 0.8..=13.0;
const MOST_WIDTH_M: f32 = 4.4;
const TOPS_M: RangeInclusive<f32> = 0.65..=3.1;

/// Which objects a vehicle model is asked about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleBoundsParams {
    /// Whether objects of a size that no vehicle has are refused without asking the model.
    pub enabled: bool,
}

impl VehicleBoundsParams {
    /// Whether the model is asked about an object with this box above ground of elevation `ground_m`.
    pub fn allow(self, bounding_box: &OrientedBox, ground_m: f32) -> bool {
        !self.enabled || may_be_vehicle(bounding_box, ground_m)
    }
}

/// Whether the seen part of a vehicle may have this box above ground of elevation `ground_m`. If not, no model is asked
/// about it, nor trained on it.
pub fn may_be_vehicle(bounding_box: &OrientedBox, ground_m: f32) -> bool {
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    let top_m = bounding_box.center_m[2] + 0.5 * height_m - ground_m;
    LENGTHS_M.contains(&length_m) && width_m <= MOST_WIDTH_M && TOPS_M.contains(&top_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cars_and_trucks_may_be_vehicles_and_people_and_houses_may_not() {
        let may_be = |length_width_height_m: [f32; 3]| {
            let center_m = [9.0, 2.0, -1.7 + 0.5 * length_width_height_m[2]];
            may_be_vehicle(&OrientedBox { center_m, length_width_height_m, yaw_rad: 0.3 }, -1.7)
        };
        assert!(may_be([4.3, 1.8, 1.5]) && may_be([12.0, 2.5, 3.0]) && may_be([1.8, 0.2, 1.0]));
        for other in [[0.5, 0.4, 1.7], [12.0, 6.0, 2.0], [20.0, 2.5, 3.0], [4.0, 2.0, 3.5], [2.0, 1.0, 0.4]] {
            assert!(!may_be(other), "{other:?}");
        }
    }

    #[test]
    fn without_bounds_the_model_is_asked_about_a_house() {
        let house =
            OrientedBox { center_m: [9.0, 2.0, 1.3], length_width_height_m: [20.0, 8.0, 6.0], yaw_rad: 0.3 };
        assert!(!VehicleBoundsParams { enabled: true }.allow(&house, -1.7));
        assert!(VehicleBoundsParams { enabled: false }.allow(&house, -1.7));
    }
}
