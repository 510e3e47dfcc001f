//! How smooth an object's sides are.

use super::box_frame_points::{BoxFramePoints, extent_m};

/// Side of the squares within which a surface is taken for flat, in metres.
const SQUARE_M: f32 = 0.3;
/// Points farther than this from the mean of their square are rough, in metres; metal with ranging noise is nearer.
const ROUGH_M: f32 = 0.04;

/// Points in a square: how many, and the sum of their depths.
type Square = (f32, f32);

/// Measures how far points are from flat sides, one object after another.
///
/// Metal and glass are smooth over a hand's breadth; the leaves of a hedge are not. Beyond the eight values of the paper.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RoughnessSquares {
    /// On the long sides, whose depth is across.
    on_sides: Vec<Square>,
    /// On the ends, whose depth is along.
    on_ends: Vec<Square>,
    // For every point, the indices of its squares in both.
    indices: Vec<[u32; 2]>,
}

impl RoughnessSquares {
    /// The share of `points`, of a box of this length and width, that are far from the mean of their square on the side and
    /// of that on the end. Points alone in their squares do not count. `None` without points.
    #[inline(always)]
    pub fn rough_share(&mut self, points: &BoxFramePoints, length_m: f32, width_m: f32) -> Option<f32> {
        let [low_m, high_m] = extent_m(points.up_m())?;
        let n_squares = |extent_m: f32| (extent_m / SQUARE_M) as usize + 1;
        let [n_along, n_across, n_up] = [length_m, width_m, high_m - low_m].map(n_squares);
        for (squares, n) in [(&mut self.on_sides, n_along), (&mut self.on_ends, n_across)] {
            squares.clear();
            squares.resize(n * n_up, (0.0, 0.0));
        }
        // Rounding may leave points outside.
        let index = |offset_m: f32, n: usize| ((offset_m / SQUARE_M) as usize).min(n - 1);
        let indices = |along_m: f32, across_m: f32, up_m: f32| {
            let row = index(up_m - low_m, n_up);
            let [column, end_column] =
                [index(along_m + 0.5 * length_m, n_along), index(across_m + 0.5 * width_m, n_across)];
            [row * n_along + column, row * n_across + end_column].map(|it| it as u32)
        };
        let depths = || points.along_m().iter().zip(points.across_m());
        self.indices.clear();
        self.indices.extend(
            depths()
                .zip(points.up_m())
                .map(|((&along_m, &across_m), &up_m)| indices(along_m, across_m, up_m)),
        );
        for ((&along_m, &across_m), indices) in depths().zip(&self.indices) {
            let [on_side, on_end] = indices.map(|it| it as usize);
            let (side, end) = (&mut self.on_sides[on_side], &mut self.on_ends[on_end]);
            *side = (side.0 + 1.0, side.1 + across_m);
            *end = (end.0 + 1.0, end.1 + along_m);
        }
        for square in self.on_sides.iter_mut().chain(&mut self.on_ends) {
            square.1 /= square.0;
        }
        let (mut n_points, mut n_rough) = (0_u32, 0_u32);
        for ((&along_m, &across_m), indices) in depths().zip(&self.indices) {
            let [on_side, on_end] = indices.map(|it| it as usize);
            let distance_m = |(n, mean_m): Square, depth_m: f32| {
                if n > 1.0 { (depth_m - mean_m).abs() } else { f32::INFINITY }
            };
            let (side_m, end_m) =
                (distance_m(self.on_sides[on_side], across_m), distance_m(self.on_ends[on_end], along_m));
            let nearer_m = if side_m < end_m { side_m } else { end_m };
            if nearer_m < f32::INFINITY {
                n_points += 1;
                n_rough += u32::from(nearer_m > ROUGH_M);
            }
        }
        Some(n_rough as f32 / n_points.max(1) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    fn rough_share(positions_m: &[[f32; 3]]) -> Option<f32> {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, positions_m.iter().copied());
        RoughnessSquares::default().rough_share(&points, 4.0, 2.0)
    }

    /// Points on a side and an end of the box, every 0.1 m, the former moved by turns by `depth_m` inward and outward.
    fn two_sides(depth_m: f32) -> Vec<[f32; 3]> {
        let steps = |n: u8| (0..n).map(|it| 0.1 * f32::from(it));
        let side = steps(39).flat_map(|x| steps(10).map(move |z| [x - 1.95, z]));
        let side =
            side.zip([1.0, -1.0].into_iter().cycle()).map(|([x, z], sign)| [x, 1.0 + sign * depth_m, z]);
        let end = steps(19).flat_map(|y| steps(10).map(move |z| [-2.0, y - 0.95, z]));
        side.chain(end).collect()
    }

    #[test]
    fn flat_sides_are_smooth_and_a_hedge_is_not() {
        // The squares at the corner hold points of both sides.
        let flat = rough_share(&two_sides(0.0)).unwrap();
        assert!(flat < 0.1, "{flat}");
        let hedge = rough_share(&two_sides(0.1)).unwrap();
        assert!(hedge > 0.6, "{hedge}");
    }

    #[test]
    fn points_that_are_alone_say_nothing() {
        assert_eq!(rough_share(&[[-2.0, -1.0, 0.0], [2.0, 1.0, 0.7]]), Some(0.0));
        assert_eq!(rough_share(&[]), None);
    }
}
