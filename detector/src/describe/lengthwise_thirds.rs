//! How an object is built from end to end.

use super::box_frame_points::BoxFramePoints;

/// The thirds of an object along its box: the lower end, the middle, and the higher end.
///
/// A car's bonnet is lower than its roof, and its roof is in the middle or at the higher end; a hedge is as high all along.
/// Beyond the eight values of the paper, which compare ends by the spheres at their corners alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthwiseThirds {
    /// The highest point of each above the ground, in metres; [`NOTHING_M`] without points.
    pub tops_m: [f32; 3],
    /// The share of the points in each.
    pub shares: [f32; 3],
}

/// The top of a third without points, in metres above the ground.
pub const NOTHING_M: f32 = -1.0;

impl LengthwiseThirds {
    /// The thirds of `points` of a box of `length_m` whose centre is `center_m` above the ground. `None` without points.
    #[inline(always)]
    pub fn of(points: &BoxFramePoints, length_m: f32, center_m: f32) -> Option<Self> {
        let n_points = points.up_m().len();
        if n_points == 0 {
            return None;
        }
        let border_m = length_m / 6.0;
        let mut tops_m = [NOTHING_M - center_m; 3];
        let mut n_in = [0_u32; 3];
        for (&along_m, &up_m) in points.along_m().iter().zip(points.up_m()) {
            let third = usize::from(along_m >= -border_m) + usize::from(along_m > border_m);
            tops_m[third] = if up_m > tops_m[third] { up_m } else { tops_m[third] };
            n_in[third] += 1;
        }
        if tops_m[0] > tops_m[2] {
            tops_m.swap(0, 2);
            n_in.swap(0, 2);
        }
        Some(Self {
            tops_m: tops_m.map(|it| center_m + it),
            shares: n_in.map(|it| it as f32 / n_points as f32),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    fn thirds(side_m: &[[f32; 2]]) -> Option<LengthwiseThirds> {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [6.0, 2.0, 1.0], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, side_m.iter().map(|&[along, up]| [along, 0.0, up]));
        LengthwiseThirds::of(&points, 6.0, 1.0)
    }

    #[test]
    fn the_lower_end_comes_first_whichever_way_the_box_faces() {
        let side_m = [[-3.0, 0.5], [-2.0, 0.25], [0.0, 0.5], [2.0, -0.25]];
        let expected = LengthwiseThirds { tops_m: [0.75, 1.5, 1.5], shares: [0.25, 0.25, 0.5] };
        assert_eq!(thirds(&side_m), Some(expected));
        assert_eq!(thirds(&side_m.map(|[along, up]| [-along, up])), Some(expected));
    }

    #[test]
    fn a_third_without_points_has_no_top() {
        let expected = LengthwiseThirds { tops_m: [NOTHING_M, 1.0, 1.5], shares: [0.0, 0.5, 0.5] };
        assert_eq!(thirds(&[[0.0, 0.0], [-2.5, 0.5]]), Some(expected));
        assert_eq!(thirds(&[]), None);
    }
}
