//! Which objects may be parts of one.

use super::regrouping_params::RegroupingParams;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;

/// Whether two objects, boxes with their hulls on the ground plan, lie side by side and neither is too long.
pub fn may_be_one(
    [(a, a_hull_m), (b, b_hull_m)]: [(&OrientedBox, &[[f32; 2]]); 2],
    params: &RegroupingParams,
) -> bool {
    let is_long = |it: &OrientedBox| it.length_width_height_m[0] > params.max_joined_length_m;
    if is_long(a) || is_long(b) {
        return false;
    }
    let [dx, dy] = [0, 1].map(|axis| a.center_m[axis] - b.center_m[axis]);
    let reach_m = half_diagonal_m(a) + half_diagonal_m(b) + params.max_gap_m;
    dx * dx + dy * dy <= reach_m * reach_m
        && (gap_m(a, b_hull_m) <= params.max_gap_m || gap_m(b, a_hull_m) <= params.max_gap_m)
}

fn half_diagonal_m(bounding_box: &OrientedBox) -> f32 {
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    0.5 * (length_m * length_m + width_m * width_m).sqrt()
}

/// From a box to the nearest corner of a hull on the ground plan, in metres.
fn gap_m(bounding_box: &OrientedBox, hull_m: &[[f32; 2]]) -> f32 {
    let [x_m, y_m, _] = bounding_box.center_m;
    let [half_length_m, half_width_m, _] = bounding_box.length_width_height_m.map(|it| 0.5 * it);
    let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
    let distance_m = |&[corner_x_m, corner_y_m]: &[f32; 2]| {
        let (dx, dy) = (corner_x_m - x_m, corner_y_m - y_m);
        let beyond_end_m = ((cos * dx + sin * dy).abs() - half_length_m).max(0.0);
        let beside_m = ((cos * dy - sin * dx).abs() - half_width_m).max(0.0);
        (beyond_end_m * beyond_end_m + beside_m * beside_m).sqrt()
    };
    hull_m.iter().map(distance_m).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    #[test]
    fn only_neighbours_of_which_none_is_long_may_be_one() {
        let params = HierarchicalParams::shipped().regrouping;
        let may_be_one = |[x_m, length_m]: [f32; 2]| {
            let it = |x_m: f32, length_m: f32| OrientedBox {
                center_m: [x_m + 0.5 * length_m, 0.0, 0.0],
                length_width_height_m: [length_m, 1.8, 1.5],
                yaw_rad: 0.0,
            };
            let boxes = [it(-2.0, 2.0), it(x_m, length_m)];
            let hulls_m = boxes.map(|it| it.footprint_m());
            may_be_one([(&boxes[0], &hulls_m[0]), (&boxes[1], &hulls_m[1])], &params)
        };
        let (gap_m, long_m) = (params.max_gap_m, params.max_joined_length_m);
        assert!(may_be_one([0.9 * gap_m, 2.0]));
        assert!(!may_be_one([1.1 * gap_m, 2.0]));
        assert!(!may_be_one([0.9 * gap_m, 1.1 * long_m]));
    }
}
