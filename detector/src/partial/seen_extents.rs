//! How far what is seen of an object reaches.

/// Lengths of what is seen of an object, in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SeenExtents {
    /// Height of its lowest point above the ground.
    pub bottom_m: f64,
    /// Height of its highest point above the ground.
    pub top_m: f64,
    /// Extent on the ground plan along the main axis of its points.
    pub length_m: f64,
    /// Extent on the ground plan across that axis.
    pub width_m: f64,
}

impl SeenExtents {
    /// Those of some points; nothing without any. Not in the papers.
    pub fn of(points_m: &[[f64; 3]]) -> Self {
        if points_m.is_empty() {
            return Self::default();
        }
        let n = points_m.len() as f64;
        let [mean_x, mean_y] = [0, 1].map(|axis| points_m.iter().map(|it| it[axis]).sum::<f64>() / n);
        let (mut along_x, mut across, mut along_y) = (0.0, 0.0, 0.0);
        for [x, y, _] in points_m {
            let (x, y) = (x - mean_x, y - mean_y);
            along_x += x * x;
            across += x * y;
            along_y += y * y;
        }
        let [cosine, sine] = main_axis(along_x, across, along_y);
        let span = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let widen = |[low, high]: [f64; 2], it: &[f64; 3]| [low.min(of(it)), high.max(of(it))];
            points_m.iter().fold([f64::INFINITY, f64::NEG_INFINITY], widen)
        };
        let [bottom_m, top_m] = span(&|it| it[2]);
        let [back_m, front_m] = span(&|it| cosine * it[0] + sine * it[1]);
        let [right_m, left_m] = span(&|it| cosine * it[1] - sine * it[0]);
        Self { bottom_m, top_m, length_m: front_m - back_m, width_m: left_m - right_m }
    }
}

/// Cosine and sine of the direction in which points with these sums of squares and products spread most.
fn main_axis(along_x: f64, across: f64, along_y: f64) -> [f64; 2] {
    let half = 0.5 * (along_x - along_y);
    let off = (half * half + across * across).sqrt();
    // Of the two forms of the eigenvector that which does not cancel.
    let [x, y] = if half >= 0.0 { [half + off, across] } else { [across, off - half] };
    let length = (x * x + y * y).sqrt();
    if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(points_m: &[[f64; 3]], expected_m: [f64; 4]) {
        let SeenExtents { bottom_m, top_m, length_m, width_m } = SeenExtents::of(points_m);
        for (found, expected) in [bottom_m, top_m, length_m, width_m].into_iter().zip(expected_m) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn a_bar_is_as_long_and_wide_whichever_way_it_lies() {
        for [c, s] in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]] {
            let bar = [[2.0, 0.5, 1.0], [2.0, -0.5, 1.0], [-2.0, 0.5, 3.0], [-2.0, -0.5, 1.5]];
            check(&bar.map(|[x, y, z]| [7.0 + c * x - s * y, s * x + c * y, z]), [1.0, 3.0, 4.0, 1.0]);
        }
    }

    #[test]
    fn one_point_and_none_have_no_extent() {
        check(&[[1.0, 2.0, 3.0]; 2], [3.0, 3.0, 0.0, 0.0]);
        check(&[], [0.0; 4]);
    }
}
