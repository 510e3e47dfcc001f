//! The box of a whole vehicle.

use crate::detection::{BoxDetails, SeenOfVehicle, SeenSides};
use crate::oriented_box::OrientedBox;
use crate::portable_math::{exp, ln, single};
use crate::road_user::RoadUser;
use crate::whole::box_model::{BoxModel, N_GROWTHS};
use crate::whole::box_values::{IS_TURNED, N_BOX_VALUES, box_values};
use crate::whole::seen_frame::SeenFrame;

/// A box may be smaller than the seen part by this much at a side, in metres: a mirror, or a stray point.
const MOST_SHRINKAGE_M: f32 = 0.5;
/// And by no more than this share of it, so that something is left.
const MOST_SHRINKAGE: f32 = 0.25;
/// No side of a box is shorter, in metres.
const LEAST_SIDE_M: f32 = 0.3;

/// A side is seen if it faces the sensor, and the whole reaches no farther than this beyond the seen part there, in metres.
const MOST_BEYOND_SEEN_M: f32 = 0.25;
/// The front is sure from these log odds on: a probability of 0.9.
const SURE_LOG_ODDS: f32 = 2.2;

/// A road user whose whole box is predicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenRoadUser {
    /// The box of its seen part.
    pub seen: OrientedBox,
    /// Its frame.
    pub frame: SeenFrame,
    /// Elevation of the ground below it, in metres.
    pub ground_m: f32,
    /// The values, in which [`IS_TURNED`] is not set yet.
    pub values: [f32; N_BOX_VALUES],
}

impl SeenRoadUser {
    /// A road user with these points and this box around them but strays, above ground of elevation `ground_m`.
    pub fn new(seen: OrientedBox, ground_m: f32, positions_m: &[[f32; 3]]) -> Self {
        let frame = SeenFrame::of(&seen);
        let values = box_values(&seen, &frame, ground_m, positions_m);
        Self { seen, frame, ground_m, values }
    }

    /// `growth_m` beyond the seen part, limited so that most of the seen part stays in the box.
    fn limited_m(&self, growth_m: [f32; N_GROWTHS]) -> [f32; N_GROWTHS] {
        let least_m = |axis: usize| -MOST_SHRINKAGE_M.min(MOST_SHRINKAGE * 2.0 * self.frame.half_m[axis]);
        let [near_u_m, far_u_m, near_v_m, far_v_m, top_m] = growth_m;
        let [along_m, across_m] = [least_m(0), least_m(1)];
        let [near_u_m, far_u_m] = [near_u_m, far_u_m].map(|it| it.max(along_m));
        let [near_v_m, far_v_m] = [near_v_m, far_v_m].map(|it| it.max(across_m));
        [near_u_m, far_u_m, near_v_m, far_v_m, top_m]
    }

    /// The seen sides, if the whole reaches `growth_m` beyond the seen part and its front is the far or the near end.
    fn sides(&self, is_turned: bool, growth_m: [f32; N_GROWTHS], is_away: bool) -> SeenSides {
        let growth_m = self.limited_m(growth_m);
        let is_seen = |axis: usize| {
            let growth_m = growth_m[2 * axis];
            let faces_sensor = self.frame.from_sensor_m[axis] > self.frame.half_m[axis] + growth_m;
            faces_sensor && growth_m <= MOST_BEYOND_SEEN_M
        };
        let along = usize::from(is_turned);
        let (end_is_seen, side_is_seen) = (is_seen(along), is_seen(1 - along));
        let [ax, ay] = self.frame.axis(along);
        let [bx, by] = self.frame.axis(1 - along);
        // The near side looks against its axis. Seen along the other axis it is on the right if the axes are right-handed.
        let is_left = (ax * by - ay * bx < 0.0) == is_away;
        SeenSides {
            front: end_is_seen && !is_away,
            rear: end_is_seen && is_away,
            left: side_is_seen && is_left,
            right: side_is_seen && !is_left,
        }
    }

    /// The box that reaches `growth_m` beyond the seen part, and whose front is the far or the near end.
    fn grown(&self, is_turned: bool, growth_m: [f32; N_GROWTHS], is_away: bool) -> OrientedBox {
        let [near_u_m, far_u_m, near_v_m, far_v_m, top_m] = self.limited_m(growth_m);
        let [half_u_m, half_v_m] = self.frame.half_m;
        let ranges_m =
            [[-half_u_m - near_u_m, half_u_m + far_u_m], [-half_v_m - near_v_m, half_v_m + far_v_m]];
        let center_m = self.frame.in_scan_m(ranges_m.map(|[low, high]| 0.5 * (low + high)));
        let [along_u_m, along_v_m] = ranges_m.map(|[low, high]| (high - low).max(LEAST_SIDE_M));
        let [length_m, width_m] = if is_turned { [along_v_m, along_u_m] } else { [along_u_m, along_v_m] };
        let [x, y] = self.frame.axis(usize::from(is_turned));
        let yaw_rad = if is_away { single::atan2(y, x) } else { single::atan2(-y, -x) };
        let seen_top_m = self.seen.center_m[2] + 0.5 * self.seen.length_width_height_m[2];
        let height_m = (seen_top_m + top_m - self.ground_m).max(LEAST_SIDE_M);
        OrientedBox {
            center_m: [center_m[0], center_m[1], self.ground_m + 0.5 * height_m],
            length_width_height_m: [length_m, width_m, height_m],
            yaw_rad,
        }
    }
}

/// The box of a whole vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WholeBox {
    /// The box. It stands on the ground, and its yaw, in (−π, π], is that of the front.
    pub bounding_box: OrientedBox,
    /// The seen sides of the vehicle, and whether its front is sure.
    pub seen: SeenOfVehicle,
    /// The logarithm of the odds that the box is right, if this is a vehicle.
    pub right_log_odds: f32,
}

impl WholeBox {
    /// Details of the box. `score` is the logarithm of the odds that it is this `road_user`; without one it is taken for one,
    /// and the score is that of the box alone.
    pub fn details(&self, road_user: RoadUser, score: Option<f32>) -> BoxDetails {
        let score = score.map_or(self.right_log_odds, |it| both_log_odds(it, self.right_log_odds));
        let seen = (road_user == RoadUser::Vehicle).then_some(self.seen);
        BoxDetails { score: Some(score), seen, ..BoxDetails::default() }
    }
}

/// The logarithm of the odds that two independent things hold.
fn both_log_odds(one: f32, other: f32) -> f32 {
    let [one, other] = [one, other].map(|it| f64::from(it.clamp(-100.0, 100.0)));
    -ln(exp(-one) + exp(-other) + exp(-one - other)) as f32
}

/// The boxes of whole vehicles as a model predicts them, with buffers for one scan after another.
#[derive(Debug, Clone, Default)]
pub struct WholeBoxes {
    turned: Vec<f32>,
    growths_m: [Vec<f32>; N_GROWTHS],
    away: Vec<f32>,
    right: Vec<f32>,
    boxes: Vec<WholeBox>,
}

impl WholeBoxes {
    /// The boxes of `vehicles`, one of each. Sets [`IS_TURNED`] in the values of `vehicles`.
    pub fn find(&mut self, model: &BoxModel, vehicles: &mut [SeenRoadUser]) -> &[WholeBox] {
        model.turned.sums(vehicles.iter().map(|it| &it.values), &mut self.turned);
        for (vehicle, log_odds) in vehicles.iter_mut().zip(&self.turned) {
            vehicle.values[IS_TURNED] = f32::from(u8::from(*log_odds > 0.0));
        }
        for (forest, growth_m) in model.growth_m.iter().zip(&mut self.growths_m) {
            forest.sums(vehicles.iter().map(|it| &it.values), growth_m);
        }
        model.away.sums(vehicles.iter().map(|it| &it.values), &mut self.away);
        model.right.sums(vehicles.iter().map(|it| &it.values), &mut self.right);
        let Self { turned, growths_m, away, right, boxes } = self;
        boxes.clear();
        boxes.extend(vehicles.iter().enumerate().map(|(index, it)| {
            let growth_m = growths_m.each_ref().map(|growth_m| growth_m[index]);
            let (is_turned, is_away) = (turned[index] > 0.0, away[index] > 0.0);
            let sides = it.sides(is_turned, growth_m, is_away);
            WholeBox {
                bounding_box: it.grown(is_turned, growth_m, is_away),
                seen: SeenOfVehicle { sides, is_front_sure: away[index].abs() >= SURE_LOG_ODDS },
                right_log_odds: right[index],
            }
        }));
        boxes
    }
}

/// Difference between a vehicle with the box `whole` and its seen part: a model predicts it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Whether the vehicle is longer along the width of its seen part.
    pub is_turned: bool,
    /// How far the vehicle reaches beyond its seen part, in metres, in the order of [`BoxModel::growth_m`].
    pub growth_m: [f32; N_GROWTHS],
    /// Whether its front is the far end.
    pub is_away: bool,
    /// The angle between the sides of both boxes in radians, at most π/4.
    pub off_rad: f32,
}

impl Difference {
    /// The difference of a vehicle from its seen part.
    pub fn between(seen: &SeenRoadUser, whole: &OrientedBox) -> Self {
        let (sin, cos) = single::sin_cos(whole.yaw_rad);
        let [along_u, along_v] = [0, 1].map(|axis| {
            let [x, y] = seen.frame.axis(axis);
            x * cos + y * sin
        });
        let is_turned = along_v.abs() > along_u.abs();
        let [length_m, width_m, height_m] = whole.length_width_height_m;
        let half_m = if is_turned { [width_m, length_m] } else { [length_m, width_m] }.map(|it| 0.5 * it);
        let [u_m, v_m] = seen.frame.position_m([whole.center_m[0], whole.center_m[1]]);
        let [half_u_m, half_v_m] = seen.frame.half_m;
        let top_m = whole.center_m[2] + 0.5 * height_m;
        let seen_top_m = seen.seen.center_m[2] + 0.5 * seen.seen.length_width_height_m[2];
        let (less, more) = (along_u.abs().min(along_v.abs()), along_u.abs().max(along_v.abs()));
        Self {
            is_turned,
            growth_m: [
                half_m[0] - u_m - half_u_m,
                half_m[0] + u_m - half_u_m,
                half_m[1] - v_m - half_v_m,
                half_m[1] + v_m - half_v_m,
                top_m - seen_top_m,
            ],
            is_away: if is_turned { along_v } else { along_u } > 0.0,
            off_rad: single::atan2(less, more),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_box_that_grows_by_the_difference_is_the_whole_one(
            x in -30.0_f32..30.0, y in -30.0_f32..30.0, yaw_rad in -3.1_f32..3.1, quarters in 0_u8..4,
            sizes in prop::array::uniform3(1.0_f32..5.0), shift in prop::array::uniform2(-0.5_f32..0.5),
        ) {
            let seen = OrientedBox { center_m: [x, y, -1.0], length_width_height_m: [2.0, 0.8, 0.9], yaw_rad };
            let seen = SeenRoadUser::new(seen, -1.7, &[[x, y, -1.0]]);
            let whole = OrientedBox {
                center_m: [x + shift[0], y + shift[1], -1.7 + 0.5 * sizes[2]],
                length_width_height_m: [sizes[0] + 3.0, 2.5, sizes[2]],
                yaw_rad: yaw_rad + f32::from(quarters) * std::f32::consts::FRAC_PI_2,
            };
            let it = Difference::between(&seen, &whole);
            prop_assert!(it.off_rad < 1e-3);
            prop_assert_eq!(it.is_turned, quarters % 2 == 1);
            let grown = seen.grown(it.is_turned, it.growth_m, it.is_away);
            for axis in 0..3 {
                prop_assert!((grown.center_m[axis] - whole.center_m[axis]).abs() < 1e-3, "{:?}", (grown, whole));
                prop_assert!((grown.length_width_height_m[axis] - whole.length_width_height_m[axis]).abs() < 1e-3);
            }
            prop_assert!((grown.yaw_rad - whole.yaw_rad).cos() > 0.999);
        }

        #[test]
        fn both_hold_at_most_as_surely_as_either(one in -60.0_f32..60.0, other in -60.0_f32..60.0) {
            let both = both_log_odds(one, other);
            let probability = |it: f32| 1.0 / (1.0 + f64::from(-it).exp());
            prop_assert!(both <= one.min(other) + 1e-4);
            prop_assert!((probability(both) - probability(one) * probability(other)).abs() < 1e-5);
        }

        #[test]
        fn sides_that_are_seen_face_the_sensor(
            x in -30.0_f32..30.0, y in -30.0_f32..30.0, yaw_rad in -3.1_f32..3.1, is_turned: bool, is_away: bool,
            growth_m in prop::array::uniform5(-1.0_f32..0.25),
        ) {
            let seen = OrientedBox { center_m: [x, y, -1.0], length_width_height_m: [4.0, 1.8, 1.5], yaw_rad };
            let seen = SeenRoadUser::new(seen, -1.7, &[[x, y, -1.0]]);
            let SeenSides { front, rear, left, right } = seen.sides(is_turned, growth_m, is_away);
            let whole = seen.grown(is_turned, growth_m, is_away);
            let [length_m, width_m, _] = whole.length_width_height_m;
            let [along_m, across_m, _] = whole.in_box_frame([0.0; 3]);
            // Not where rounding decides.
            prop_assume!((along_m.abs() - 0.5 * length_m).abs() > 1e-3 && (across_m.abs() - 0.5 * width_m).abs() > 1e-3);
            let expected = [along_m > 0.5 * length_m, -along_m > 0.5 * length_m, across_m > 0.5 * width_m, -across_m > 0.5 * width_m];
            prop_assert_eq!([front, rear, left, right], expected);
        }

        #[test]
        fn something_is_left_of_every_box(
            growth_m in prop::array::uniform5(-9.0_f32..9.0), sizes_m in prop::array::uniform3(0.0_f32..5.0),
        ) {
            let seen = OrientedBox { center_m: [9.0, 2.0, -1.0], length_width_height_m: sizes_m, yaw_rad: 0.3 };
            let grown = SeenRoadUser::new(seen, -1.7, &[[9.0, 2.0, -1.0]]).grown(false, growth_m, true);
            prop_assert!(grown.length_width_height_m.iter().all(|it| *it >= LEAST_SIDE_M));
        }
    }

    #[test]
    fn a_side_beyond_which_the_whole_reaches_is_not_seen() {
        let seen =
            OrientedBox { center_m: [9.0, 4.0, -1.0], length_width_height_m: [3.0, 1.6, 1.5], yaw_rad: 0.0 };
        let seen = SeenRoadUser::new(seen, -1.7, &[[9.0, 4.0, -1.0]]);
        // The rear is hidden by another vehicle.
        let sides = seen.sides(false, [1.2, 0.0, 0.1, 0.2, 0.0], true);
        assert_eq!(sides, SeenSides { right: true, ..SeenSides::default() });
    }
}
