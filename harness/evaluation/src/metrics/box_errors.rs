//! How far a fitted box is from the annotated one.

use detector::OrientedBox;

use crate::matching::box_overlap::{bev_iou, iou_3d};

/// The errors of one box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxErrors {
    /// Distance of the centres on the ground plan, in metres.
    pub centre_m: f64,
    /// Fitted less annotated length, in metres.
    pub length_m: f64,
    /// Fitted less annotated width, in metres.
    pub width_m: f64,
    /// Angle between the long sides in radians, 0 to π/2; it ignores which end is the front.
    pub yaw_rad: f64,
    /// Whether the front is on the right side.
    pub is_front_right: bool,
    /// Intersection over union seen from above, 0 to 1.
    pub bev_iou: f64,
    /// Intersection over union in space, 0 to 1.
    pub iou_3d: f64,
}

impl BoxErrors {
    /// The errors of `fitted`.
    ///
    /// Paper: VM section 1, Fig. 1.
    pub fn of(fitted: &OrientedBox, annotated: &OrientedBox) -> Self {
        let [center, other] = [fitted.center_m, annotated.center_m].map(|it| it.map(f64::from));
        let [size, whole] =
            [fitted.length_width_height_m, annotated.length_width_height_m].map(|it| it.map(f64::from));
        let turn_rad = f64::from(fitted.yaw_rad) - f64::from(annotated.yaw_rad);
        Self {
            centre_m: (center[0] - other[0]).hypot(center[1] - other[1]),
            length_m: size[0] - whole[0],
            width_m: size[1] - whole[1],
            yaw_rad: turn_rad.sin().abs().atan2(turn_rad.cos().abs()),
            is_front_right: turn_rad.cos() > 0.0,
            bev_iou: bev_iou(fitted, annotated),
            iou_3d: iou_3d(fitted, annotated),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn car(yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [10.0, -3.0, -0.9], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad }
    }

    #[track_caller]
    fn check_turn(fitted_rad: f32, annotated_rad: f32, expected_deg: f64) {
        let it = BoxErrors::of(&car(fitted_rad), &car(annotated_rad));
        assert!((it.yaw_rad.to_degrees() - expected_deg).abs() < 1e-4, "{it:?}");
    }

    #[test]
    fn an_annotation_fed_back_has_no_error_whichever_way_it_faces() {
        let it = BoxErrors::of(&car(0.3), &car(0.3));
        assert_eq!([it.centre_m, it.length_m, it.width_m, it.yaw_rad], [0.0; 4]);
        assert!(it.is_front_right && it.bev_iou > 0.999 && it.iou_3d > 0.999, "{it:?}");
        assert!(!BoxErrors::of(&car(0.3), &car(0.3 + PI)).is_front_right);
        check_turn(0.3, 0.3 + PI, 0.0);
        check_turn(0.3 - 2.0 * PI, 0.3, 0.0);
    }

    #[test]
    fn turns_are_at_most_a_right_angle() {
        check_turn(0.0, PI / 2.0, 90.0);
        check_turn(-PI / 3.0, PI / 3.0, 60.0);
        check_turn(3.0 * PI / 4.0, 0.0, 45.0);
    }

    #[test]
    fn sizes_and_positions_are_compared_as_they_are() {
        let half =
            OrientedBox { center_m: [13.0, 1.0, 5.0], length_width_height_m: [2.5, 2.25, 9.0], yaw_rad: 0.0 };
        let it = BoxErrors::of(&half, &car(0.0));
        assert_eq!([it.centre_m, it.length_m, it.width_m, it.yaw_rad], [5.0, -1.5, 0.25, 0.0]);
        assert_eq!([it.bev_iou, it.iou_3d], [0.0; 2]);
    }
}
