//! How far two upright boxes overlap: on the ground plan, and in space.

use detector::OrientedBox;

/// Intersection over union of the ground plans, 0 to 1; 0 if both have no area. Exactly 1 of a box and itself.
pub fn bev_iou(first: &OrientedBox, second: &OrientedBox) -> f64 {
    over_union(common_area_m2(first, second), area_m2(first), area_m2(second))
}

/// Intersection over union of the volumes, 0 to 1; 0 if both have no volume. Exactly 1 of a box and itself.
pub fn iou_3d(first: &OrientedBox, second: &OrientedBox) -> f64 {
    let height_m = |it: &OrientedBox| f64::from(it.length_width_height_m[2]);
    let apart_m = (f64::from(first.center_m[2]) - f64::from(second.center_m[2])).abs();
    let reach_m = f64::midpoint(height_m(first), height_m(second)) - apart_m;
    let common_m = reach_m.min(height_m(first)).min(height_m(second)).max(0.0);
    let volume_m3 = |it: &OrientedBox| area_m2(it) * height_m(it);
    over_union(common_area_m2(first, second) * common_m, volume_m3(first), volume_m3(second))
}

fn over_union(common: f64, first: f64, second: f64) -> f64 {
    let union = first + second - common;
    if union > 0.0 { (common / union).clamp(0.0, 1.0) } else { 0.0 }
}

fn area_m2(it: &OrientedBox) -> f64 {
    let [length_m, width_m, _] = it.length_width_height_m.map(f64::from);
    length_m * width_m
}

/// Area that both ground plans cover: the corners of the second, clipped by the sides of the first in its own frame.
///
/// Sutherland, Hodgman: Reentrant Polygon Clipping, 1974.
fn common_area_m2(first: &OrientedBox, second: &OrientedBox) -> f64 {
    let mut corners_m = corners_in_frame_of(first, second).to_vec();
    let [length_m, width_m, _] = first.length_width_height_m.map(f64::from);
    for (axis, half_m) in [(0, length_m / 2.0), (1, width_m / 2.0)] {
        for side in [1.0, -1.0] {
            corners_m = clipped(&corners_m, |corner_m| half_m - side * corner_m[axis]);
        }
    }
    polygon_area_m2(&corners_m)
}

/// The ground-plan corners of `it` where `frame` is at the origin and heads along x, counter-clockwise.
fn corners_in_frame_of(frame: &OrientedBox, it: &OrientedBox) -> [[f64; 2]; 4] {
    let [dx_m, dy_m] = [0, 1].map(|axis| f64::from(it.center_m[axis]) - f64::from(frame.center_m[axis]));
    let (frame_sin, frame_cos) = f64::from(frame.yaw_rad).sin_cos();
    let center_m = [frame_cos * dx_m + frame_sin * dy_m, frame_cos * dy_m - frame_sin * dx_m];
    let (sin, cos) = (f64::from(it.yaw_rad) - f64::from(frame.yaw_rad)).sin_cos();
    let [length_m, width_m, _] = it.length_width_height_m.map(f64::from);
    [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].map(|(along, across)| {
        let (along_m, across_m) = (along * length_m, across * width_m);
        [center_m[0] + cos * along_m - sin * across_m, center_m[1] + sin * along_m + cos * across_m]
    })
}

/// The part of a convex polygon where `inside_m`, the distance from a line, is not negative.
fn clipped(corners_m: &[[f64; 2]], inside_m: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (corner_idx, &to_m) in corners_m.iter().enumerate() {
        let from_m = corners_m[(corner_idx + corners_m.len() - 1) % corners_m.len()];
        let (from_inside_m, to_inside_m) = (inside_m(from_m), inside_m(to_m));
        if (from_inside_m < 0.0) != (to_inside_m < 0.0) {
            let share = from_inside_m / (from_inside_m - to_inside_m);
            kept.push([0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis])));
        }
        if to_inside_m >= 0.0 {
            kept.push(to_m);
        }
    }
    kept
}

/// Area of a polygon whose corners go counter-clockwise.
fn polygon_area_m2(corners_m: &[[f64; 2]]) -> f64 {
    let mut doubled = 0.0;
    for (corner_idx, [x_m, y_m]) in corners_m.iter().enumerate() {
        let [next_x_m, next_y_m] = corners_m[(corner_idx + 1) % corners_m.len()];
        doubled += x_m * next_y_m - next_x_m * y_m;
    }
    doubled / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxed(center_m: [f32; 3], length_width_height_m: [f32; 3], yaw_deg: f32) -> OrientedBox {
        OrientedBox { center_m, length_width_height_m, yaw_rad: yaw_deg.to_radians() }
    }

    #[track_caller]
    fn check(second: &OrientedBox, expected_bev: f64, expected_3d: f64) {
        let first = boxed([0.0; 3], [4.0, 2.0, 2.0], 0.0);
        let found = [bev_iou(&first, second), iou_3d(&first, second)];
        let expected = [expected_bev, expected_3d];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
    }

    #[test]
    fn overlaps_that_can_be_done_in_the_head() {
        let size = [4.0, 2.0, 2.0];
        check(&boxed([0.0; 3], size, 0.0), 1.0, 1.0);
        check(&boxed([0.0; 3], size, 180.0), 1.0, 1.0);
        // Half of each: 4 of 12 square metres.
        check(&boxed([2.0, 0.0, 0.0], size, 0.0), 1.0 / 3.0, 1.0 / 3.0);
        // The same ground plan, half the height: 8 of 24 cubic metres.
        check(&boxed([0.0, 0.0, 1.0], size, 0.0), 1.0, 1.0 / 3.0);
        // A cross: 4 of 12.
        check(&boxed([0.0; 3], size, 90.0), 1.0 / 3.0, 1.0 / 3.0);
        // A square on its corner, whose diagonal is the width: 2 of 8, and a quarter of the height on top.
        check(&boxed([0.0; 3], [2.0_f32.sqrt(), 2.0_f32.sqrt(), 0.5], 45.0), 0.25, 1.0 / 16.0);
        check(&boxed([4.0, 0.0, 0.0], size, 0.0), 0.0, 0.0);
        check(&boxed([0.0, 0.0, 2.5], size, 0.0), 1.0, 0.0);
        check(&boxed([0.0; 3], [0.0; 3], 0.0), 0.0, 0.0);
    }

    #[test]
    fn boxes_without_extent_do_not_overlap() {
        let point = boxed([1.0; 3], [0.0; 3], 0.0);
        assert_eq!([bev_iou(&point, &point), iou_3d(&point, &point)], [0.0, 0.0]);
    }

    prop_compose! {
        fn any_box()(
            center_m in prop::array::uniform3(-3.0_f32..3.0),
            length_width_height_m in prop::array::uniform3(0.1_f32..6.0),
            yaw_rad in -7.0_f32..7.0,
        ) -> OrientedBox {
            OrientedBox { center_m, length_width_height_m, yaw_rad }
        }
    }

    /// Share of a fine grid over both boxes that is in both, of what is in either.
    fn by_counting(first: &OrientedBox, second: &OrientedBox) -> f64 {
        let (mut common, mut either) = (0_u32, 0_u32);
        for step in 0..160_000 {
            let at_m = [(step % 400) as f32 * 0.04 - 8.0, (step / 400) as f32 * 0.04 - 8.0];
            let holds = |it: &OrientedBox| it.contains([at_m[0], at_m[1], it.center_m[2]]);
            common += u32::from(holds(first) && holds(second));
            either += u32::from(holds(first) || holds(second));
        }
        f64::from(common) / f64::from(either.max(1))
    }

    proptest! {
        #[test]
        fn a_box_overlaps_itself_entirely(it in any_box()) {
            prop_assert_eq!([bev_iou(&it, &it), iou_3d(&it, &it)], [1.0, 1.0]);
        }

        #[test]
        fn the_order_does_not_matter(first in any_box(), second in any_box()) {
            prop_assert!((bev_iou(&first, &second) - bev_iou(&second, &first)).abs() < 1e-9);
            prop_assert!((iou_3d(&first, &second) - iou_3d(&second, &first)).abs() < 1e-9);
            prop_assert!((0.0..=1.0).contains(&bev_iou(&first, &second)));
            prop_assert!(iou_3d(&first, &second) <= bev_iou(&first, &second) + 1e-9);
        }

        #[test]
        fn turning_and_moving_both_changes_nothing(
            first in any_box(), second in any_box(), turn_rad in -4.0_f32..4.0, shift_m in prop::array::uniform3(-9.0_f32..9.0)
        ) {
            let moved = |it: &OrientedBox| {
                let (sin, cos) = turn_rad.sin_cos();
                let [x_m, y_m, z_m] = it.center_m;
                let turned_m = [cos * x_m - sin * y_m, sin * x_m + cos * y_m, z_m];
                let center_m = [0, 1, 2].map(|axis| turned_m[axis] + shift_m[axis]);
                OrientedBox { center_m, yaw_rad: it.yaw_rad + turn_rad, ..*it }
            };
            // Coordinates are rounded to some millionths of a metre.
            prop_assert!((bev_iou(&first, &second) - bev_iou(&moved(&first), &moved(&second))).abs() < 1e-4);
            prop_assert!((iou_3d(&first, &second) - iou_3d(&moved(&first), &moved(&second))).abs() < 1e-4);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20))]
        #[test]
        fn the_area_is_what_counting_finds(first in any_box(), second in any_box()) {
            prop_assume!(first.length_width_height_m[0].min(second.length_width_height_m[0]) > 1.0);
            prop_assume!(first.length_width_height_m[1].min(second.length_width_height_m[1]) > 1.0);
            let (found, counted) = (bev_iou(&first, &second), by_counting(&first, &second));
            prop_assert!((found - counted).abs() < 0.03, "{found} {counted}");
        }
    }
}
