//! How long and wide an object is at each height.

use super::box_frame_points::BoxFramePoints;
use crate::vector_instructions::{greater, lesser};

/// Slices from the ground up.
pub const N_SLICES: usize = 6;
/// Their height, in metres.
const SLICE_M: f32 = 0.35;

/// The extent of an object in horizontal slices.
///
/// A person is wider at the arms than at the head, and a trunk is as wide all along; a bicycle is longer than its rider. Not
/// in the papers, which know vehicles alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightSlices {
    /// Along the box, in metres; 0 with fewer than two points.
    pub lengths_m: [f32; N_SLICES],
    /// Across it, in metres.
    pub widths_m: [f32; N_SLICES],
}

impl HeightSlices {
    /// The slices of `points` of a box whose centre is `center_m` above the ground. What is higher than all slices is left
    /// out, and what is lower than the ground is in the first.
    #[inline(always)]
    pub fn of(points: &BoxFramePoints, center_m: f32) -> Self {
        let mut low_m = [[f32::INFINITY; 2]; N_SLICES + 1];
        let mut high_m = [[f32::NEG_INFINITY; 2]; N_SLICES + 1];
        let positions = points.along_m().iter().zip(points.across_m()).zip(points.up_m());
        for ((&along_m, &across_m), &up_m) in positions {
            // Casts saturate.
            let slice = (((center_m + up_m) / SLICE_M) as usize).min(N_SLICES);
            for (axis, it_m) in [along_m, across_m].into_iter().enumerate() {
                low_m[slice][axis] = lesser(it_m, low_m[slice][axis]);
                high_m[slice][axis] = greater(it_m, high_m[slice][axis]);
            }
        }
        let extents =
            |axis: usize| std::array::from_fn(|slice| greater(high_m[slice][axis] - low_m[slice][axis], 0.0));
        Self { lengths_m: extents(0), widths_m: extents(1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    #[test]
    fn each_slice_has_the_extent_of_its_points() {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [2.0, 2.0, 1.8], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        // Heights above the ground are 0.9 m more.
        let positions_m = [
            [-0.3, 0.1, -0.95],
            [0.2, 0.1, -0.6],
            [-0.4, -0.5, 0.3],
            [0.1, 0.2, 0.45],
            [0.7, 0.7, 0.8],
            [9.0, 9.0, 1.5],
        ];
        points.fill(&frame, positions_m.into_iter());
        let found = HeightSlices::of(&points, 0.9);
        let about = |found: [f32; 6], expected: [f32; 6]| {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
            }
        };
        about(found.lengths_m, [0.5, 0.0, 0.0, 0.5, 0.0, 0.0]);
        about(found.widths_m, [0.0, 0.0, 0.0, 0.7, 0.0, 0.0]);
    }
}
