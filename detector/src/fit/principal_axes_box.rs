//! The upright box along the direction in which points scatter most.

use nalgebra::{Matrix2, SymmetricEigen};

use crate::oriented_box::OrientedBox;
use crate::portable_math;

/// The box around `positions_m` whose length lies along the first eigenvector of their covariance on the ground plan.
///
/// The extents are those of the points projected on the axes, so that the width may exceed the length where many
/// points crowd on a short side; height is from the lowest point to the highest. Yaw lies in (−π/2, π/2]. One point, and
/// points of which no direction stands out (such as the corners of a square), give yaw 0; points on a line a box of no
/// width. `None` without points. The positions must be finite.
///
/// ```
/// use detector::fit::principal_axes_box::principal_axes_box;
///
/// // Corners and the middle of a footprint of 4 m by 2 m, and its roof.
/// let positions_m =
///     [[3.0, 1.0, -1.5], [7.0, 1.0, -1.5], [7.0, 3.0, -1.5], [3.0, 3.0, -1.5], [5.0, 2.0, -0.5]];
/// let found = principal_axes_box(positions_m.into_iter());
/// assert_eq!(found.map(|it| (it.center_m, it.length_width_height_m)), Some(([5.0, 2.0, -1.0], [4.0, 2.0, 1.0])));
/// assert_eq!(principal_axes_box(std::iter::empty()), None);
/// ```
///
/// Paper: VM section 1, \[5\]; Fig. 1 shows how the axes turn away from those of a car whose far side is hidden.
pub fn principal_axes_box(
    positions_m: impl ExactSizeIterator<Item = [f32; 3]> + Clone,
) -> Option<OrientedBox> {
    if positions_m.len() == 0 {
        return None;
    }
    let mean_m = mean(positions_m.clone());
    let yaw_rad = main_direction_rad(covariance(positions_m.clone(), mean_m));
    let (sin, cos) = portable_math::sin_cos(yaw_rad);
    // Not around the mean: points crowd on the seen sides.
    let mut low_m = [f64::INFINITY; 3];
    let mut high_m = [f64::NEG_INFINITY; 3];
    for [x_m, y_m, z_m] in positions_m {
        let [dx, dy] = [f64::from(x_m) - mean_m[0], f64::from(y_m) - mean_m[1]];
        let in_axes = [cos * dx + sin * dy, cos * dy - sin * dx, f64::from(z_m)];
        for axis in 0..3 {
            low_m[axis] = low_m[axis].min(in_axes[axis]);
            high_m[axis] = high_m[axis].max(in_axes[axis]);
        }
    }
    let [along_m, across_m, up_m] = [0, 1, 2].map(|axis| 0.5 * (low_m[axis] + high_m[axis]));
    let center_m =
        [mean_m[0] + cos * along_m - sin * across_m, mean_m[1] + sin * along_m + cos * across_m, up_m];
    Some(OrientedBox {
        center_m: center_m.map(|it| it as f32),
        length_width_height_m: [0, 1, 2].map(|axis| (high_m[axis] - low_m[axis]) as f32),
        yaw_rad: yaw_rad as f32,
    })
}

/// Mean of x and y in metres.
fn mean(positions_m: impl ExactSizeIterator<Item = [f32; 3]>) -> [f64; 2] {
    let n_points = positions_m.len() as f64;
    let sums = positions_m.fold([0.0, 0.0], |[x, y], it| [x + f64::from(it[0]), y + f64::from(it[1])]);
    sums.map(|sum| sum / n_points)
}

/// Covariance of x and y in square metres.
fn covariance(positions_m: impl ExactSizeIterator<Item = [f32; 3]>, mean_m: [f64; 2]) -> Matrix2<f64> {
    let n_points = positions_m.len() as f64;
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for [x_m, y_m, _] in positions_m {
        let [dx, dy] = [f64::from(x_m) - mean_m[0], f64::from(y_m) - mean_m[1]];
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    Matrix2::new(xx, xy, xy, yy) / n_points
}

/// Direction of the first eigenvector in (−π/2, π/2]; 0 where the eigenvalues are equal but for rounding.
fn main_direction_rad(covariance: Matrix2<f64>) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let eigen = SymmetricEigen::new(covariance);
    let main = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
    let [first, second] = [eigen.eigenvalues[main], eigen.eigenvalues[1 - main]];
    // Where no direction stands out, rounding would choose one.
    if first - second <= 1e-9 * first {
        return 0.0;
    }
    let yaw_rad = portable_math::atan2(eigen.eigenvectors[(1, main)], eigen.eigenvectors[(0, main)]);
    if yaw_rad > FRAC_PI_2 {
        yaw_rad - PI
    } else if yaw_rad <= -FRAC_PI_2 {
        yaw_rad + PI
    } else {
        yaw_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fit(positions_m: &[[f32; 3]]) -> Option<OrientedBox> {
        principal_axes_box(positions_m.iter().copied())
    }

    #[track_caller]
    fn check_close(found: &OrientedBox, expected: &OrientedBox, tolerance_m: f32) {
        for axis in 0..3 {
            let center_m = found.center_m[axis] - expected.center_m[axis];
            let side_m = found.length_width_height_m[axis] - expected.length_width_height_m[axis];
            assert!(center_m.abs() <= tolerance_m && side_m.abs() <= tolerance_m, "{found:?}\n{expected:?}");
        }
        // A half turn is the same box.
        let turn = (found.yaw_rad - expected.yaw_rad).sin();
        assert!(turn.abs() < 1e-3, "{found:?}\n{expected:?}");
    }

    /// Points all over the inside of a box, borders included.
    fn filling(it: &OrientedBox) -> Vec<[f32; 3]> {
        let (sin, cos) = it.yaw_rad.sin_cos();
        let steps = || (-5_i8..=5).map(|step| f32::from(step) / 10.0);
        let shares = steps().flat_map(|u| steps().flat_map(move |v| [-0.5, 0.5].map(|w| [u, v, w])));
        let positions_m = shares.map(|shares| {
            let [u, v, w] = [0, 1, 2].map(|axis| shares[axis] * it.length_width_height_m[axis]);
            [it.center_m[0] + cos * u - sin * v, it.center_m[1] + sin * u + cos * v, it.center_m[2] + w]
        });
        positions_m.collect()
    }

    #[test]
    fn no_points_have_no_box() {
        assert_eq!(fit(&[]), None);
    }

    #[test]
    fn points_at_one_position_have_a_box_without_size() {
        let point = OrientedBox { center_m: [3.0, -4.0, 0.5], length_width_height_m: [0.0; 3], yaw_rad: 0.0 };
        assert_eq!(fit(&[[3.0, -4.0, 0.5]]), Some(point));
        assert_eq!(fit(&[[3.0, -4.0, 0.5]; 7]), Some(point));
    }

    #[test]
    fn two_points_have_a_box_along_their_line() {
        let expected = OrientedBox {
            center_m: [1.5, 2.0, 0.5],
            length_width_height_m: [5.0, 0.0, 1.0],
            yaw_rad: 4.0_f32.atan2(3.0),
        };
        check_close(&fit(&[[0.0, 0.0, 0.0], [3.0, 4.0, 1.0]]).unwrap(), &expected, 1e-5);
    }

    #[test]
    fn points_above_each_other_have_a_box_of_height_alone() {
        let it = fit(&[[3.0, -4.0, 0.5], [3.0, -4.0, 2.0]]).unwrap();
        let pole =
            OrientedBox { center_m: [3.0, -4.0, 1.25], length_width_height_m: [0.0, 0.0, 1.5], yaw_rad: 0.0 };
        assert_eq!(it, pole);
    }

    #[test]
    fn a_square_has_no_main_axis_and_yaw_zero() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let expected =
            OrientedBox { center_m: [1.0, 1.0, 0.0], length_width_height_m: [2.0, 2.0, 0.0], yaw_rad: 0.0 };
        assert_eq!(fit(&corners), Some(expected));
    }

    #[test]
    fn an_axis_straight_to_the_side_has_yaw_of_a_positive_quarter_turn() {
        for [from_y_m, to_y_m] in [[0.0, 3.0], [3.0, 0.0]] {
            let it = fit(&[[1.0, from_y_m, 0.0], [1.0, to_y_m, 0.0]]).unwrap();
            assert!((it.yaw_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6, "{}", it.yaw_rad);
        }
    }

    proptest! {
        #[test]
        fn a_box_full_of_points_is_found_again(
            center_m in prop::array::uniform3(-60.0_f32..60.0),
            length_m in 2.5_f32..12.0, width_m in 0.5_f32..2.3, height_m in 0.5_f32..3.0,
            yaw_rad in -1.57_f32..1.57,
        ) {
            let expected = OrientedBox { center_m, length_width_height_m: [length_m, width_m, height_m], yaw_rad };
            check_close(&fit(&filling(&expected)).unwrap(), &expected, 1e-3);
        }

        #[test]
        fn the_box_encloses_its_points(
            positions_m in prop::collection::vec(prop::array::uniform3(-9.0_f32..9.0), 1..40)
        ) {
            let mut it = fit(&positions_m).unwrap();
            it.length_width_height_m = it.length_width_height_m.map(|side_m| side_m + 1e-3);
            prop_assert!(positions_m.iter().all(|&position_m| it.contains(position_m)));
        }
    }
}
