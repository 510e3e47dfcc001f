//! Extents of the seen part of an object.

use super::level_spread::LevelSpread;

/// Extents of the seen part of an object, in metres.
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
    /// The extents of these points; all 0 without points. Not in the papers.
    pub fn of(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> Self {
        Self::with_spread(LevelSpread::of(points_m.clone()), points_m)
    }

    /// The extents of points whose spread is known; all 0 without points.
    pub(super) fn with_spread(spread: LevelSpread, points_m: impl Iterator<Item = [f64; 3]>) -> Self {
        let widen = |[low, high]: [f64; 2], [_, _, z]: [f64; 3]| [low.min(z), high.max(z)];
        let [bottom_m, top_m] = points_m.fold([f64::INFINITY, f64::NEG_INFINITY], widen);
        if bottom_m > top_m {
            return Self::default();
        }
        let LevelSpread { length_m, width_m, .. } = spread;
        Self { bottom_m, top_m, length_m, width_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(points_m: &[[f64; 3]], expected_m: [f64; 4]) {
        let SeenExtents { bottom_m, top_m, length_m, width_m } = SeenExtents::of(points_m.iter().copied());
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
