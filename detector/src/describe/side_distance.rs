//! How far inside its box an object's points lie.

use super::box_frame_points::{BoxFramePoints, LANES};
use crate::vector_instructions::lesser;

/// Mean distance of `points` to the nearest side of their box of `length_m` and `width_m`, in metres. `None` without
/// points.
///
/// What is seen of a vehicle is a shell; beams enter a hedge or a crown, and regions cut at random are filled. Beyond the
/// eight values of the paper.
#[inline(always)]
pub fn mean_side_distance_m(points: &BoxFramePoints, length_m: f32, width_m: f32) -> Option<f32> {
    if points.along_m().is_empty() {
        return None;
    }
    let half_m = [length_m / 2.0, width_m / 2.0];
    let distance_m = |along: f32, across: f32| {
        // Rounding may leave points outside.
        -lesser(-lesser(half_m[0] - along.abs(), half_m[1] - across.abs()), 0.0)
    };
    let (along, rest_along) = points.along_m().as_chunks::<LANES>();
    let (across, rest_across) = points.across_m().as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (along, across) in along.iter().zip(across) {
        for lane in 0..LANES {
            sums[lane] += distance_m(along[lane], across[lane]);
        }
    }
    let rest = rest_along.iter().zip(rest_across).map(|(&along, &across)| distance_m(along, across));
    let sum_m = sums.iter().sum::<f32>() + rest.sum::<f32>();
    Some(sum_m / points.along_m().len() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;

    fn distance(ground_plan_m: &[[f32; 2]]) -> Option<f32> {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, ground_plan_m.iter().map(|&[x, y]| [x, y, 0.0]));
        mean_side_distance_m(&points, 4.0, 2.0)
    }

    #[test]
    fn the_middle_is_half_a_width_from_the_sides_and_a_corner_on_them() {
        assert_eq!(distance(&[[0.0, 0.0]]), Some(1.0));
        assert_eq!(distance(&[[2.0, 1.0]]), Some(0.0));
        assert_eq!(distance(&[[1.5, 0.0], [0.0, -0.5]]), Some(0.5));
        assert_eq!(distance(&[[2.1, 0.0]]), Some(0.0));
        assert_eq!(distance(&[]), None);
    }

    #[test]
    fn many_points_have_the_mean_of_few() {
        let found = distance(&[[1.5, 0.0], [0.0, -0.75]].repeat(21)).unwrap();
        assert!((found - 0.375).abs() < 1e-6, "{found}");
    }
}
