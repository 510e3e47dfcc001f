//! How far points reach on the ground plan, along their main axis and across it.

/// Lengths on the ground plan, in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelSpread {
    /// Extent along the main axis.
    pub length_m: f64,
    /// Extent across that axis.
    pub width_m: f64,
    /// Standard deviation along the main axis.
    pub deviation_along_m: f64,
    /// Standard deviation across that axis.
    pub deviation_across_m: f64,
}

impl LevelSpread {
    /// The spread of these points, in metres; all 0 without points. Not in the papers.
    pub fn of(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> Self {
        let (mut n, mut sum_x_m, mut sum_y_m) = (0.0_f64, 0.0, 0.0);
        for [x, y, _] in points_m.clone() {
            n += 1.0;
            sum_x_m += x;
            sum_y_m += y;
        }
        if n == 0.0 {
            return Self::default();
        }
        let (mean_x, mean_y) = (sum_x_m / n, sum_y_m / n);
        let (mut along_x, mut across, mut along_y) = (0.0, 0.0, 0.0);
        for [x, y, _] in points_m.clone() {
            let (x, y) = (x - mean_x, y - mean_y);
            along_x += x * x;
            across += x * y;
            along_y += y * y;
        }
        let [cosine, sine] = main_axis(along_x, across, along_y);
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let ([mut back_m, mut front_m], [mut right_m, mut left_m]) = (nothing, nothing);
        let (mut squares_along, mut squares_across) = (0.0, 0.0);
        for [x, y, _] in points_m {
            let (along_m, across_m) = (cosine * x + sine * y, cosine * y - sine * x);
            (back_m, front_m) = (back_m.min(along_m), front_m.max(along_m));
            (right_m, left_m) = (right_m.min(across_m), left_m.max(across_m));
            let (x, y) = (x - mean_x, y - mean_y);
            squares_along += (cosine * x + sine * y) * (cosine * x + sine * y);
            squares_across += (cosine * y - sine * x) * (cosine * y - sine * x);
        }
        Self {
            length_m: front_m - back_m,
            width_m: left_m - right_m,
            deviation_along_m: (squares_along / n).sqrt(),
            deviation_across_m: (squares_across / n).sqrt(),
        }
    }
}

/// Cosine and sine of the direction in which points with these sums of squares and products spread most.
fn main_axis(along_x: f64, across: f64, along_y: f64) -> [f64; 2] {
    let half = 0.5 * (along_x - along_y);
    let off = (half * half + across * across).sqrt();
    // Of the two forms of the eigenvector the one that does not cancel.
    let [x, y] = if half >= 0.0 { [half + off, across] } else { [across, off - half] };
    let length = (x * x + y * y).sqrt();
    if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(points_m: &[[f64; 3]], expected_m: [f64; 4]) {
        let LevelSpread { length_m, width_m, deviation_along_m, deviation_across_m } =
            LevelSpread::of(points_m.iter().copied());
        let found_m = [length_m, width_m, deviation_along_m, deviation_across_m];
        for (found, expected) in found_m.into_iter().zip(expected_m) {
            assert!((found - expected).abs() < 1e-12, "{found_m:?} {expected_m:?}");
        }
    }

    #[test]
    fn a_bar_is_the_same_whichever_way_it_lies() {
        for [c, s] in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]] {
            let bar = [[2.0, 0.5, 1.0], [2.0, -0.5, 1.0], [-2.0, 0.5, 3.0], [-2.0, -0.5, 1.5]];
            let turned = bar.map(|[x, y, z]| [7.0 + c * x - s * y, s * x + c * y, z]);
            check(&turned, [4.0, 1.0, 2.0, 0.5]);
        }
    }

    #[test]
    fn one_position_and_none_have_no_spread() {
        check(&[[1.0, 2.0, 3.0]; 2], [0.0; 4]);
        check(&[], [0.0; 4]);
    }
}
