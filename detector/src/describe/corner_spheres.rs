//! Distances of the surface of an object from the upper corners of its box.

use super::box_frame_points::{BoxFramePoints, LANES, extent_m, reduced};
use crate::vector_instructions::lesser;

/// Distances in metres from the four corners of a box, lifted to the highest point of the object, to its nearest point.
///
/// A bonnet or a windscreen falls away from its corners, a box-shaped thing does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerSpheres {
    /// Front left, back left, back right, front right, in the box's frame: as
    /// [`OrientedBox::footprint_m`](crate::OrientedBox::footprint_m) has them.
    pub radii_m: [f32; 4],
}

/// The radii in an order that does not depend on which way the box happens to face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderedRadii {
    /// At the end with the larger mean, which is called the front: on the near side, then on the far side.
    pub front_m: [f32; 2],
    /// At the other end, in the same order of sides.
    pub back_m: [f32; 2],
}

impl CornerSpheres {
    /// The spheres of an object in a box of `length_m` and `width_m`. `None` without points.
    ///
    /// Paper: VM section 4, principal curvature estimation.
    #[inline(always)]
    pub fn around(points: &BoxFramePoints, length_m: f32, width_m: f32) -> Option<Self> {
        let [_, top_m] = extent_m(points.up_m())?;
        let [front, left] = [length_m / 2.0, width_m / 2.0];
        let corners_m = [[front, left], [-front, left], [-front, -left], [front, -left]];
        Some(Self { radii_m: corners_m.map(|corner_m| nearest_m(points, corner_m, top_m)) })
    }

    /// The radii by the object's own front and near side.
    ///
    /// The front is the pair of larger mean, as the paper's figure has it. The near side is the one whose two radii are
    /// smaller together: mostly the one that the sensor sees. Both radii of a side stay on it, so that the box may be turned
    /// by half a turn, or the whole object mirrored, without changing anything. Ties are ordered by value.
    pub fn ordered(&self) -> OrderedRadii {
        let [front_left, back_left, back_right, front_right] = self.radii_m;
        let ways = [
            [front_left, front_right, back_left, back_right],
            [front_right, front_left, back_right, back_left],
            [back_left, back_right, front_left, front_right],
            [back_right, back_left, front_right, front_left],
        ];
        let by_front_then_side_then_value = |a: &[f32; 4], b: &[f32; 4]| {
            let front = (a[0] + a[1]).total_cmp(&(b[0] + b[1]));
            let near = (b[0] + b[2]).total_cmp(&(a[0] + a[2]));
            let value = || a.iter().zip(b).map(|(a, b)| b.total_cmp(a)).find(|it| it.is_ne());
            front.then(near).then_with(|| value().unwrap_or(std::cmp::Ordering::Equal))
        };
        let best = ways.into_iter().max_by(by_front_then_side_then_value);
        let [a, b, c, d] = best.expect("there are four ways");
        OrderedRadii { front_m: [a, b], back_m: [c, d] }
    }
}

impl OrderedRadii {
    /// Mean at the front less mean at the back, in metres; never negative.
    pub fn difference_m(&self) -> f32 {
        0.5 * (self.front_m[0] + self.front_m[1]) - 0.5 * (self.back_m[0] + self.back_m[1])
    }
}

/// Distance from a position in the frame of the box to the nearest of the points.
#[inline(always)]
fn nearest_m(points: &BoxFramePoints, [front, left]: [f32; 2], top_m: f32) -> f32 {
    let squared = |along: f32, across: f32, up: f32| {
        let square = |it: f32| it * it;
        square(along - front) + square(up - top_m) + square(across - left)
    };
    let (along, rest_along) = points.along_m().as_chunks::<LANES>();
    let (across, rest_across) = points.across_m().as_chunks::<LANES>();
    let (up, rest_up) = points.up_m().as_chunks::<LANES>();
    // A least distance for each lane, so that lanes do not wait for each other. The least of all is the same in any order.
    let mut least = [f32::INFINITY; LANES];
    for ((along, across), up) in along.iter().zip(across).zip(up) {
        for lane in 0..LANES {
            least[lane] = lesser(squared(along[lane], across[lane], up[lane]), least[lane]);
        }
    }
    let rest = rest_along.iter().zip(rest_across).zip(rest_up);
    let rest = rest.map(|((&along, &across), &up)| squared(along, across, up));
    rest.fold(reduced(least, lesser), lesser).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;
    use proptest::prelude::*;

    const SIZE_M: [f32; 3] = [4.0, 2.0, 1.5];

    fn spheres_of(positions_m: &[[f32; 3]], bounding_box: &OrientedBox) -> Option<CornerSpheres> {
        let mut points = BoxFramePoints::default();
        points.fill(bounding_box, positions_m.iter().copied());
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        CornerSpheres::around(&points, length_m, width_m)
    }

    fn level_box(yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [0.0; 3], length_width_height_m: SIZE_M, yaw_rad }
    }

    #[test]
    fn no_points_have_no_spheres() {
        assert_eq!(spheres_of(&[], &level_box(0.0)), None);
    }

    #[test]
    fn a_point_in_a_corner_is_touched_by_the_others_from_afar() {
        let at_front_left = spheres_of(&[[2.0, 1.0, 0.75]], &level_box(0.0)).unwrap();
        assert_eq!(at_front_left.radii_m, [0.0, 4.0, 20.0_f32.sqrt(), 2.0]);
        let ordered = at_front_left.ordered();
        // All of it is at one end, so the other one, far from everything, is the front.
        assert_eq!((ordered.front_m, ordered.back_m), ([4.0, 20.0_f32.sqrt()], [0.0, 2.0]));
        assert_eq!(ordered.difference_m(), 0.5 * (4.0 + 20.0_f32.sqrt()) - 1.0);
    }

    #[test]
    fn the_highest_point_lifts_the_spheres() {
        let mast = spheres_of(&[[2.0, 1.0, 0.0], [0.0, 0.0, 3.0]], &level_box(0.0)).unwrap();
        assert_eq!(mast.radii_m[0], 5.0_f32.sqrt());
    }

    fn points() -> impl Strategy<Value = Vec<[f32; 3]>> {
        let point = (-2.0_f32..2.0, -1.0_f32..1.0, -0.7_f32..0.7).prop_map(|(x, y, z)| [x, y, z]);
        prop::collection::vec(point, 1..40)
    }

    proptest! {
        #[test]
        fn every_radius_is_the_least_distance(positions_m in points()) {
            let spheres = spheres_of(&positions_m, &level_box(0.0)).unwrap();
            let top_m = positions_m.iter().map(|it| it[2]).fold(f32::NEG_INFINITY, f32::max);
            for ([x, y], radius_m) in level_box(0.0).footprint_m().into_iter().zip(spheres.radii_m) {
                let distance_m = |it: &[f32; 3]| ((it[0] - x).powi(2) + (it[1] - y).powi(2) + (it[2] - top_m).powi(2)).sqrt();
                let least_m = positions_m.iter().map(distance_m).fold(f32::INFINITY, f32::min);
                prop_assert!((radius_m - least_m).abs() < 1e-5, "{radius_m} against {least_m}");
            }
        }

        #[test]
        fn order_does_not_depend_on_facing_nor_on_mirroring(radii in prop::array::uniform4(0_u8..4)) {
            // Few different values, so that they tie.
            let [a, b, c, d] = radii.map(f32::from);
            let ordered = CornerSpheres { radii_m: [a, b, c, d] }.ordered();
            for turned in [[c, d, a, b], [d, c, b, a], [b, a, d, c]] {
                prop_assert_eq!(CornerSpheres { radii_m: turned }.ordered(), ordered);
            }
            prop_assert!(ordered.difference_m() >= 0.0);
            let mut values = [ordered.front_m, ordered.back_m].concat();
            values.sort_by(f32::total_cmp);
            let mut given = [a, b, c, d];
            given.sort_by(f32::total_cmp);
            prop_assert_eq!(values, given);
        }
    }
}
