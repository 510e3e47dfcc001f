//! How far two upright boxes overlap: on the ground plan, and in space.

use detector::OrientedBox;

use super::rectangle_overlap::{Rectangle, common_area_m2, over_union};

/// Intersection over union of the ground plans, 0 to 1; 0 if both have no area. Exactly 1 of a box and itself.
pub fn bev_iou(first: &OrientedBox, second: &OrientedBox) -> f64 {
    let (first, second) = (&ground_plan(first), &ground_plan(second));
    over_union(common_area_m2(first, second), first.area_m2(), second.area_m2())
}

/// Intersection over union of the volumes, 0 to 1; 0 if both have no volume. Exactly 1 of a box and itself.
pub fn iou_3d(first: &OrientedBox, second: &OrientedBox) -> f64 {
    let height_m = |it: &OrientedBox| f64::from(it.length_width_height_m[2]);
    let apart_m = (f64::from(first.center_m[2]) - f64::from(second.center_m[2])).abs();
    let reach_m = f64::midpoint(height_m(first), height_m(second)) - apart_m;
    let common_m = reach_m.min(height_m(first)).min(height_m(second)).max(0.0);
    let plans = [first, second].map(ground_plan);
    let [volume_m3, other_volume_m3] = [0, 1].map(|it| plans[it].area_m2() * height_m([first, second][it]));
    over_union(common_area_m2(&plans[0], &plans[1]) * common_m, volume_m3, other_volume_m3)
}

fn ground_plan(it: &OrientedBox) -> Rectangle {
    let [x_m, y_m, _] = it.center_m.map(f64::from);
    let [length_m, width_m, _] = it.length_width_height_m.map(f64::from);
    Rectangle { center_m: [x_m, y_m], length_width_m: [length_m, width_m], yaw_rad: f64::from(it.yaw_rad) }
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
        // Equal ground plans, shifted by half the height: 8 of 24 cubic metres.
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

    /// Number of points of a fine grid inside both boxes, divided by the number inside either.
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
