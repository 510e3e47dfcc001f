//! How high an object stands.

use super::box_frame_points::{BoxFramePoints, extent_m, sum};

/// Where the points of an object are above the ground, in metres.
///
/// Roofs of vehicles end at much the same height and their underside is near the road; a crown begins higher, a hedge
/// has as many points below as above. Beyond the eight values of the paper, which have no height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElevationSpread {
    /// The lowest point.
    pub bottom_m: f32,
    /// The highest point.
    pub top_m: f32,
    /// The mean of all points.
    pub mean_m: f32,
    /// Their standard deviation.
    pub deviation_m: f32,
    /// The share of the points above each of [`LEVELS_M`].
    pub shares_above: [f32; 3],
}

/// Elevations above the ground that the points are counted above, in metres: a car's bumper, bonnet
/// and windows end there, more or less.
pub const LEVELS_M: [f32; 3] = [0.5, 1.1, 1.4];

impl ElevationSpread {
    /// The spread of `points` of a box whose centre is `center_m` above the ground. `None` without points.
    #[inline(always)]
    pub fn of(points: &BoxFramePoints, center_m: f32) -> Option<Self> {
        let up_m = points.up_m();
        let [bottom_m, top_m] = extent_m(up_m)?;
        let n_points = up_m.len() as f32;
        let mean_m = sum(up_m, |it| it) / n_points;
        let variance = sum(up_m, |it| (it - mean_m) * (it - mean_m)) / n_points;
        let share_above = |level_m: f32| {
            let least_m = level_m - center_m;
            sum(up_m, |it| f32::from(u8::from(it > least_m))) / n_points
        };
        Some(Self {
            bottom_m: center_m + bottom_m,
            top_m: center_m + top_m,
            mean_m: center_m + mean_m,
            deviation_m: variance.sqrt(),
            shares_above: LEVELS_M.map(share_above),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    fn spread(up_m: &[f32], center_m: f32) -> Option<ElevationSpread> {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, up_m.iter().map(|&up| [0.0, 0.0, up]));
        ElevationSpread::of(&points, center_m)
    }

    #[test]
    fn of_four_points_it_can_be_done_in_the_head() {
        let found = spread(&[-0.5, -0.5, 0.5, 0.5], 1.0).unwrap();
        let shares_above = [0.5, 0.5, 0.5];
        let expected =
            ElevationSpread { bottom_m: 0.5, top_m: 1.5, mean_m: 1.0, deviation_m: 0.5, shares_above };
        assert_eq!(found, expected);
    }

    #[test]
    fn a_single_point_has_no_deviation_and_no_points_no_spread() {
        let found = spread(&[0.25], 0.5).unwrap();
        assert_eq!((found.bottom_m, found.top_m, found.mean_m, found.deviation_m), (0.75, 0.75, 0.75, 0.0));
        assert_eq!(spread(&[], 0.5), None);
    }

    #[test]
    fn many_points_have_the_spread_of_few() {
        let many: Vec<f32> = (0..1003).map(|it| if it % 2 == 0 { -0.5 } else { 0.5 }).collect();
        let found = spread(&many, 1.0).unwrap();
        assert!((found.mean_m - 1.0).abs() < 1e-3 && (found.deviation_m - 0.5).abs() < 1e-3, "{found:?}");
    }
}
