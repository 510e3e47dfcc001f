//! The values from which the box of a whole road user is predicted.

use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::greater;
use crate::whole::seen_frame::SeenFrame;

/// Slices along the length and along the width.
const N_ALONG: usize = 8;
const N_ACROSS: usize = 4;
/// A point this near to a side lies on it, in metres.
const AT_SIDE_M: f32 = 0.25;
/// Points this far above the ground are above the bonnet of a car, in metres.
const HIGH_M: f32 = 1.1;

/// Positions are rounded by less, in metres.
const ROUNDING_M: f32 = 1e-3;

/// Number of values.
pub const N_BOX_VALUES: usize = 28;

/// Names of the values. Heights are above the ground, 0 where there is no point; slices are from near to far.
pub const BOX_VALUES: [&str; N_BOX_VALUES] = [
    "length_m",
    "width_m",
    "top_m",
    "bottom_m",
    "range_m",
    "n_points",
    "from_near_end_m",
    "from_near_side_m",
    "seen_along",
    "share_at_near_end",
    "share_at_far_end",
    "share_at_near_side",
    "share_at_far_side",
    "top_along_0_m",
    "top_along_1_m",
    "top_along_2_m",
    "top_along_3_m",
    "top_along_4_m",
    "top_along_5_m",
    "top_along_6_m",
    "top_along_7_m",
    "top_across_0_m",
    "top_across_1_m",
    "top_across_2_m",
    "top_across_3_m",
    "top_far_corner_m",
    "share_high",
    "is_turned",
];

/// The index of `is_turned`: whether the road user is longer along the width of its seen part. Unknown at first, and 0 then.
pub const IS_TURNED: usize = N_BOX_VALUES - 1;

/// The values of an object with these points and this box around them, whose frame is `frame`, above ground of elevation
/// `ground_m`.
pub fn box_values(
    seen: &OrientedBox,
    frame: &SeenFrame,
    ground_m: f32,
    positions_m: &[[f32; 3]],
) -> [f32; N_BOX_VALUES] {
    let [half_u_m, half_v_m] = frame.half_m;
    let mut n_at = [0_u32; 4];
    let mut tops_m = [0.0_f32; N_ALONG + N_ACROSS + 1];
    let mut n_high = 0_u32;
    let scale = |n: usize, half_m: f32| if half_m > 0.0 { n as f32 / (2.0 * half_m) } else { 0.0 };
    let [u_scale, v_scale] = [scale(N_ALONG, half_u_m), scale(N_ACROSS, half_v_m)];
    let mut n_within = 0_u32;
    for &[x_m, y_m, z_m] in positions_m {
        let [u_m, v_m] = frame.position_m([x_m, y_m]);
        // Strays are not in the box.
        if u_m.abs() > half_u_m + ROUNDING_M || v_m.abs() > half_v_m + ROUNDING_M {
            continue;
        }
        n_within += 1;
        let above_m = z_m - ground_m;
        let from_sides_m = [u_m + half_u_m, half_u_m - u_m, v_m + half_v_m, half_v_m - v_m];
        for (n_at, from_side_m) in n_at.iter_mut().zip(from_sides_m) {
            *n_at += u32::from(from_side_m <= AT_SIDE_M);
        }
        let corner = (u_m > 0.0 && v_m > 0.0).then_some(N_ALONG + N_ACROSS);
        let slices = [slice(u_m, u_scale, N_ALONG), N_ALONG + slice(v_m, v_scale, N_ACROSS)];
        for index in slices.into_iter().chain(corner) {
            tops_m[index] = greater(above_m, tops_m[index]);
        }
        n_high += u32::from(above_m > HIGH_M);
    }
    let share = |n: u32| n as f32 / n_within.max(1) as f32;
    let [from_u_m, from_v_m] = frame.from_sensor_m;
    let range_m = single::hypot(from_u_m, from_v_m);
    let [length_m, width_m, height_m] = seen.length_width_height_m;
    let bottom_m = seen.center_m[2] - 0.5 * height_m - ground_m;
    let of_box = [
        length_m,
        width_m,
        bottom_m + height_m,
        bottom_m,
        range_m,
        n_within as f32,
        from_u_m - half_u_m,
        from_v_m - half_v_m,
        if range_m > 0.0 { from_u_m / range_m } else { 0.0 },
    ];
    let all = of_box.into_iter().chain(n_at.map(share)).chain(tops_m).chain([share(n_high)]);
    let mut values = [0.0; N_BOX_VALUES];
    for (value, it) in values.iter_mut().zip(all) {
        *value = it;
    }
    values
}

/// The slice, of `n`, that holds a position. Slices are 1/`scale` m wide and lie around the centre; positions outside are in
/// the outermost.
fn slice(position_m: f32, scale: f32, n: usize) -> usize {
    ((position_m * scale + 0.5 * n as f32) as usize).min(n - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_bonnet_at_the_near_end_is_seen_as_such() {
        let seen =
            OrientedBox { center_m: [12.0, 5.0, -0.9], length_width_height_m: [4.0, 2.0, 1.6], yaw_rad: 0.0 };
        // From the bonnet over the near side to the roof, and one point at the far side.
        let positions_m = [[10.1, 4.1, -1.0], [10.1, 4.9, -1.7], [11.9, 4.05, -0.1], [13.9, 5.9, -0.2]];
        let values = box_values(&seen, &SeenFrame::of(&seen), -1.7, &positions_m);
        let of = |name: &str| values[BOX_VALUES.iter().position(|it| *it == name).unwrap()];
        let about =
            |name: &str, expected: f32| assert!((of(name) - expected).abs() < 1e-5, "{name}: {}", of(name));
        about("length_m", 4.0);
        about("range_m", 13.0);
        about("from_near_end_m", 10.0);
        about("from_near_side_m", 4.0);
        about("seen_along", 12.0 / 13.0);
        about("n_points", 4.0);
        about("share_at_near_end", 0.5);
        about("share_at_far_end", 0.25);
        about("share_at_near_side", 0.5);
        about("share_at_far_side", 0.25);
        about("top_along_0_m", 0.7);
        about("top_along_1_m", 0.0);
        about("top_along_3_m", 1.6);
        about("top_along_7_m", 1.5);
        about("top_across_0_m", 1.6);
        about("top_across_3_m", 1.5);
        about("top_far_corner_m", 1.5);
        about("share_high", 0.5);
        about("bottom_m", 0.0);
        assert_eq!(values[IS_TURNED], 0.0);
    }

    #[test]
    fn a_single_point_has_values() {
        let seen = OrientedBox { center_m: [0.0; 3], length_width_height_m: [0.0; 3], yaw_rad: 0.0 };
        let values = box_values(&seen, &SeenFrame::of(&seen), 0.0, &[[0.0; 3]]);
        assert!(values.iter().all(|it| it.is_finite()), "{values:?}");
    }
}
