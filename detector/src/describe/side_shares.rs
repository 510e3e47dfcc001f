//! How much of an object lies on the sides of its box.

use super::box_frame_points::{BoxFramePoints, sum};

/// Points this near to a side of the box lie on it, in metres.
const ON_SIDE_M: f32 = 0.15;

/// The shares of an object's points that lie on the sides of its box.
///
/// The seen part of a vehicle is a shell; beams enter a hedge or a crown, and regions cut at random are filled. Beyond the
/// eight values of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideShares {
    /// On the ends.
    pub on_ends: f32,
    /// On the long sides.
    pub on_sides: f32,
}

impl SideShares {
    /// The shares of `points` of a box of `length_m` and `width_m`. `None` without points.
    #[inline(always)]
    pub fn of(points: &BoxFramePoints, length_m: f32, width_m: f32) -> Option<Self> {
        let n_points = points.along_m().len() as f32;
        let share = |offsets_m: &[f32], extent_m: f32| {
            let least_m = 0.5 * extent_m - ON_SIDE_M;
            sum(offsets_m, |it| f32::from(u8::from(it.abs() > least_m))) / n_points
        };
        (n_points > 0.0).then(|| Self {
            on_ends: share(points.along_m(), length_m),
            on_sides: share(points.across_m(), width_m),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    fn shares(ground_plan_m: &[[f32; 2]]) -> Option<[f32; 2]> {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, ground_plan_m.iter().map(|&[x, y]| [x, y, 0.0]));
        SideShares::of(&points, 4.0, 2.0).map(|it| [it.on_ends, it.on_sides])
    }

    #[test]
    fn corners_lie_on_an_end_and_on_a_side() {
        assert_eq!(shares(&[[2.0, -1.0], [-1.9, 0.0], [0.0, 0.9], [0.0, 0.8]]), Some([0.5, 0.5]));
        assert_eq!(shares(&[[0.5, 0.5], [1.0, 0.0]]), Some([0.0, 0.0]));
        assert_eq!(shares(&[]), None);
    }

    #[test]
    fn many_points_have_the_shares_of_few() {
        assert_eq!(shares(&[[1.9, 0.0], [0.0, -0.95]].repeat(21)), Some([0.5, 0.5]));
    }
}
