//! Overlaps of KITTI's boxes: in the image, on the ground plan of the camera, and in space.

use reports::rows::kitti_object_row::{KittiBox, KittiOverlap};

use crate::matching::rectangle_overlap::{Rectangle, common_area_m2, over_union};

/// A rectangle of the image: left, top, right and bottom in pixels.
pub type ImageRectangle = [f64; 4];

/// A box, prepared for computing overlaps.
#[derive(Debug, Clone, Copy)]
pub struct PlannedBox<'a> {
    object: &'a KittiBox,
    plan: Rectangle,
    // Radius of the circle around the plan.
    radius_m: f64,
}

impl<'a> PlannedBox<'a> {
    /// Prepares the box of an object.
    pub fn of(object: &'a KittiBox) -> Self {
        let plan = ground_plan(object);
        Self { object, plan, radius_m: plan.radius_m() }
    }
}

/// How far two boxes overlap.
pub fn overlap(first: &PlannedBox<'_>, second: &PlannedBox<'_>) -> KittiOverlap {
    let plans = [first.plan, second.plan];
    let reach_m = first.radius_m + second.radius_m;
    let [first, second] = [first.object, second.object];
    let image = image_iou(&first.left_top_right_bottom_px, &second.left_top_right_bottom_px);
    if plans[0].are_centers_apart(&plans[1], reach_m) {
        return KittiOverlap { image, birds_eye: 0.0, volume: 0.0 };
    }
    let common_m2 = common_area_m2(&plans[0], &plans[1]);
    // The axis points down: the top of a box is its bottom minus its height.
    let bottom_m = first.bottom_center_m[1].min(second.bottom_center_m[1]);
    let top_m = |it: &KittiBox| it.bottom_center_m[1] - it.height_width_length_m[0];
    let common_m = (bottom_m - top_m(first).max(top_m(second))).max(0.0);
    let [volume_m3, other_volume_m3] =
        [first, second].map(|it| it.height_width_length_m.iter().product::<f64>());
    KittiOverlap {
        image,
        birds_eye: over_union(common_m2, plans[0].area_m2(), plans[1].area_m2()),
        volume: over_union(common_m2 * common_m, volume_m3, other_volume_m3),
    }
}

/// The share of `rectangle` that is in `region`, 0 to 1; 0 if it has no area.
pub fn share_in(rectangle: &ImageRectangle, region: &ImageRectangle) -> f64 {
    let common_px2 = common_px2(rectangle, region);
    if common_px2 > 0.0 { common_px2 / area_px2(rectangle) } else { 0.0 }
}

fn image_iou(first: &ImageRectangle, second: &ImageRectangle) -> f64 {
    let common_px2 = common_px2(first, second);
    if common_px2 > 0.0 { over_union(common_px2, area_px2(first), area_px2(second)) } else { 0.0 }
}

/// Common area in square pixels. Edges have no width: unlike in some programs, rectangles are not a pixel larger.
fn common_px2(first: &ImageRectangle, second: &ImageRectangle) -> f64 {
    let width_px = first[2].min(second[2]) - first[0].max(second[0]);
    let height_px = first[3].min(second[3]) - first[1].max(second[1]);
    width_px.max(0.0) * height_px.max(0.0)
}

fn area_px2([left, top, right, bottom]: &ImageRectangle) -> f64 {
    (right - left) * (bottom - top)
}

/// Ground plan in the plane of x, to the right, and z, ahead. A positive turn about the axis that points down goes from z to
/// x.
fn ground_plan(it: &KittiBox) -> Rectangle {
    let [x_m, _, z_m] = it.bottom_center_m;
    let [_, width_m, length_m] = it.height_width_length_m;
    Rectangle { center_m: [x_m, z_m], length_width_m: [length_m, width_m], yaw_rad: -it.rotation_y_rad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use reports::vocabulary::class::AnnotationClass;
    use std::f64::consts::FRAC_PI_2;

    const CAR: KittiBox = KittiBox {
        class: AnnotationClass::Car,
        left_top_right_bottom_px: [100.0, 100.0, 200.0, 150.0],
        alpha_rad: 0.0,
        bottom_center_m: [2.0, 1.7, 20.0],
        height_width_length_m: [2.0, 2.0, 4.0],
        rotation_y_rad: 0.0,
    };

    fn overlap_of(first: &KittiBox, second: &KittiBox) -> KittiOverlap {
        overlap(&PlannedBox::of(first), &PlannedBox::of(second))
    }

    #[track_caller]
    fn check(second: KittiBox, expected: [f64; 3]) {
        let KittiOverlap { image, birds_eye, volume } = overlap_of(&CAR, &second);
        for (found, expected) in [image, birds_eye, volume].into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
        }
    }

    #[test]
    fn overlaps_that_can_be_done_in_the_head() {
        check(CAR, [1.0, 1.0, 1.0]);
        // Half of the length, which lies along x: 4 of 12 square metres.
        check(KittiBox { bottom_center_m: [4.0, 1.7, 20.0], ..CAR }, [1.0, 1.0 / 3.0, 1.0 / 3.0]);
        // A metre higher: equal ground plans, half of the height.
        check(KittiBox { bottom_center_m: [2.0, 0.7, 20.0], ..CAR }, [1.0, 1.0, 1.0 / 3.0]);
        // A quarter turn: a cross.
        check(KittiBox { rotation_y_rad: FRAC_PI_2, ..CAR }, [1.0, 1.0 / 3.0, 1.0 / 3.0]);
        // Half of the rectangle in the image.
        check(
            KittiBox { left_top_right_bottom_px: [100.0, 125.0, 200.0, 175.0], ..CAR },
            [1.0 / 3.0, 1.0, 1.0],
        );
        check(KittiBox { left_top_right_bottom_px: [200.0, 100.0, 300.0, 150.0], ..CAR }, [0.0, 1.0, 1.0]);
        check(KittiBox { left_top_right_bottom_px: [-1.0; 4], ..CAR }, [0.0, 1.0, 1.0]);
        check(KittiBox { bottom_center_m: [-1000.0; 3], ..CAR }, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_turn_goes_from_ahead_to_the_right() {
        // Turned by plus an eighth, a car heads to the right and back, and covers positions at (1, -1) from it.
        let turned = KittiBox { rotation_y_rad: FRAC_PI_2 / 2.0, ..CAR };
        let at = |x_m: f64, z_m: f64| KittiBox {
            bottom_center_m: [2.0 + x_m, 1.7, 20.0 + z_m],
            height_width_length_m: [2.0, 0.1, 0.1],
            ..CAR
        };
        assert!(overlap_of(&turned, &at(1.2, -1.2)).birds_eye > 0.0);
        assert!(overlap_of(&turned, &at(1.2, 1.2)).birds_eye == 0.0);
    }

    #[test]
    fn a_share_is_of_the_first() {
        let region = [150.0, 0.0, 1000.0, 300.0];
        assert_eq!(share_in(&CAR.left_top_right_bottom_px, &region), 0.5);
        assert_eq!(share_in(&[-1.0; 4], &region), 0.0);
    }

    prop_compose! {
        fn any_box()(
            bottom_center_m in prop::array::uniform3(-3.0_f64..3.0),
            height_width_length_m in prop::array::uniform3(0.1_f64..6.0),
            rotation_y_rad in -7.0_f64..7.0,
            left_top_px in prop::array::uniform2(0.0_f64..50.0),
            size_px in prop::array::uniform2(0.1_f64..50.0),
        ) -> KittiBox {
            let [left, top] = left_top_px;
            let left_top_right_bottom_px = [left, top, left + size_px[0], top + size_px[1]];
            KittiBox { bottom_center_m, height_width_length_m, rotation_y_rad, left_top_right_bottom_px, ..CAR }
        }
    }

    proptest! {
        #[test]
        fn a_box_overlaps_itself_entirely_and_the_order_does_not_matter(first in any_box(), second in any_box()) {
            let of_itself = overlap_of(&first, &first);
            prop_assert_eq!((of_itself.image, of_itself.birds_eye), (1.0, 1.0));
            prop_assert!((of_itself.volume - 1.0).abs() < 1e-9);
            let (there, back) = (overlap_of(&first, &second), overlap_of(&second, &first));
            prop_assert!((there.birds_eye - back.birds_eye).abs() < 1e-9);
            prop_assert!((there.volume - back.volume).abs() < 1e-9 && there.volume <= there.birds_eye + 1e-9);
            prop_assert_eq!(there.image, back.image);
        }
    }
}
