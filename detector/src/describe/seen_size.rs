//! Which objects may be road users at all by their size.

use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::oriented_box::OrientedBox;
use crate::road_user::{MayBe, N_ROAD_USERS};

/// Bounds of the seen part of a road user, in metres: 99 of 100 clusters on the simulated streets that models are trained on
/// are within, parts of them and trucks with their trailers among them. Of the other clusters more than half are not.
#[expect(clippy::struct_field_names, reason = "a unit is no part of a name")]
struct Bounds {
    length_m: RangeInclusive<f32>,
    width_m: RangeInclusive<f32>,
    // Above the ground.
    top_m: RangeInclusive<f32>,
}

/// Those of each road user, in their order.
const BOUNDS: [Bounds; N_ROAD_USERS] = [
    Bounds { length_m: 0.8..=13.0, width_m: 0.0..=4.4, top_m: 0.65..=3.1 },
    Bounds { length_m: 0.1..=1.6, width_m: 0.0..=1.2, top_m: 0.65..=2.2 },
    Bounds { length_m: 0.3..=2.6, width_m: 0.0..=1.5, top_m: 0.65..=2.3 },
];

/// Which objects a model of road users is asked about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleBoundsParams {
    /// Whether objects of a size that no road user of a class has are refused without asking the model.
    pub enabled: bool,
}

impl VehicleBoundsParams {
    /// The classes that the model is asked about for an object with this box above ground of elevation `ground_m`.
    pub fn allow(self, bounding_box: &OrientedBox, ground_m: f32) -> MayBe {
        if self.enabled { may_be(bounding_box, ground_m) } else { MayBe::ALL }
    }
}

/// The classes of road users whose seen part may have this box above ground of elevation `ground_m`. No model is asked about
/// others, nor trained on them.
pub fn may_be(bounding_box: &OrientedBox, ground_m: f32) -> MayBe {
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    let top_m = bounding_box.center_m[2] + 0.5 * height_m - ground_m;
    let allows = |it: &Bounds| {
        it.length_m.contains(&length_m) && it.width_m.contains(&width_m) && it.top_m.contains(&top_m)
    };
    MayBe(BOUNDS.each_ref().map(allows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cars_people_and_cyclists_may_be_what_they_are_and_houses_nothing() {
        let may_be = |length_width_height_m: [f32; 3]| {
            let center_m = [9.0, 2.0, -1.7 + 0.5 * length_width_height_m[2]];
            may_be(&OrientedBox { center_m, length_width_height_m, yaw_rad: 0.3 }, -1.7)
        };
        for car in [[4.3, 1.8, 1.5], [12.0, 2.5, 3.0], [2.8, 0.2, 1.0]] {
            assert_eq!(may_be(car), MayBe([true, false, false]), "{car:?}");
        }
        assert_eq!(may_be([0.5, 0.4, 1.7]), MayBe([false, true, true]));
        assert_eq!(may_be([1.8, 0.6, 1.7]), MayBe([true, false, true]));
        for other in [[12.0, 6.0, 2.0], [20.0, 2.5, 3.0], [4.0, 2.0, 3.5], [2.0, 1.0, 0.4]] {
            assert!(!may_be(other).allows_any(), "{other:?}");
        }
    }

    #[test]
    fn without_bounds_the_model_is_asked_about_a_house() {
        let house =
            OrientedBox { center_m: [9.0, 2.0, 1.3], length_width_height_m: [20.0, 8.0, 6.0], yaw_rad: 0.3 };
        assert!(!VehicleBoundsParams { enabled: true }.allow(&house, -1.7).allows_any());
        assert_eq!(VehicleBoundsParams { enabled: false }.allow(&house, -1.7), MayBe::ALL);
    }
}
