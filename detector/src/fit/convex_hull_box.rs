//! The upright box that lies closest to the outline of an object.

use crate::fit::convex_hull::convex_hull;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::{HotLoop, greater, lesser, vectorised};

/// Buffers for fitting one box after another, and the hull of the latest.
#[derive(Debug, Clone, Default)]
pub struct ConvexHullBox {
    outline_m: Vec<[f32; 2]>,
    hull_m: Vec<[f32; 2]>,
    // Direction of the edge behind every corner.
    directions: Vec<[f32; 2]>,
}

/// A rectangle on the ground plan with one side along a hull edge.
struct Rectangle {
    /// Direction of the edge, a unit vector.
    along: [f32; 2],
    /// Extent along the edge, in metres from the origin.
    along_m: [f32; 2],
    /// Extent across it, to the left.
    across_m: [f32; 2],
}

impl ConvexHullBox {
    /// The box over the rectangle, among those that enclose the hull with a side along one of its edges, to which the
    /// hull's corners are closest on average; of equally close ones the first edge's counts, as [`convex_hull`] orders them.
    ///
    /// Length is the longer side and the yaw lies in (−π/2, π/2]: which end is the front cannot be decided from the hull.
    /// One point gives a box of no length and no width at yaw 0, points on a line one of no width. `None` without points.
    ///
    /// `outline_m` are points on the ground plan in metres that include the hull's corners; `z_range_m` becomes the
    /// height. All must be finite.
    ///
    /// Paper: VM section 4, convex hull based bounding box.
    pub fn fit(
        &mut self,
        outline_m: impl Iterator<Item = [f32; 2]>,
        z_range_m: [f32; 2],
    ) -> Option<OrientedBox> {
        self.outline_m.clear();
        self.outline_m.extend(outline_m);
        convex_hull(&mut self.outline_m, &mut self.hull_m);
        let rectangle = self.closest_rectangle()?;
        Some(box_over(&rectangle, z_range_m))
    }

    /// The hull of the latest fit: its corners in metres, counter-clockwise.
    pub fn hull_m(&self) -> &[[f32; 2]] {
        &self.hull_m
    }

    fn closest_rectangle(&mut self) -> Option<Rectangle> {
        let n_corners = self.hull_m.len();
        self.directions.clear();
        let edges = self.hull_m.iter().zip(self.hull_m.iter().cycle().skip(1));
        self.directions.extend(edges.map(|(&from_m, &to_m)| direction(from_m, to_m)));
        let mut closest: Option<(f32, Rectangle)> = None;
        for first in (0..n_corners).step_by(N_ABREAST) {
            let along = std::array::from_fn(|lane| self.directions[(first + lane).min(n_corners - 1)]);
            let rectangles = vectorised(Enclose { hull_m: &self.hull_m, along });
            for (lane, &distance_m) in
                rectangles.mean_distance_m[..N_ABREAST.min(n_corners - first)].iter().enumerate()
            {
                if closest.as_ref().is_none_or(|it| distance_m < it.0) {
                    closest = Some((distance_m, rectangles.of_lane(lane, along[lane])));
                }
            }
        }
        closest.map(|it| it.1)
    }
}

/// The direction from one corner to the next, a unit vector.
pub(crate) fn direction(from_m: [f32; 2], to_m: [f32; 2]) -> [f32; 2] {
    let (dx, dy) = (to_m[0] - from_m[0], to_m[1] - from_m[1]);
    let length_m = single::hypot(dx, dy);
    // A hull of one point has an edge from it to itself.
    if length_m > 0.0 { [dx / length_m, dy / length_m] } else { [1.0, 0.0] }
}

/// Edges whose rectangles are looked for at the same time.
const N_ABREAST: usize = 16;

/// The rectangles around a hull with a side along each of some directions.
#[derive(Debug)]
#[expect(clippy::struct_field_names, reason = "a unit is no part of a name")]
struct Rectangles {
    along_m: [[f32; N_ABREAST]; 2],
    across_m: [[f32; N_ABREAST]; 2],
    mean_distance_m: [f32; N_ABREAST],
}

impl Rectangles {
    fn of_lane(&self, lane: usize, along: [f32; 2]) -> Rectangle {
        let [along_m, across_m] = [self.along_m, self.across_m].map(|sides| sides.map(|it| it[lane]));
        Rectangle { along, along_m, across_m }
    }
}

struct Enclose<'a> {
    hull_m: &'a [[f32; 2]],
    along: [[f32; 2]; N_ABREAST],
}

impl HotLoop for Enclose<'_> {
    type Output = Rectangles;

    #[inline(always)]
    fn run(self) -> Rectangles {
        let Self { hull_m, along } = self;
        let [along_x, along_y] = [0, 1].map(|axis| along.map(|it| it[axis]));
        let mut along_m = [[f32::INFINITY; N_ABREAST], [f32::NEG_INFINITY; N_ABREAST]];
        let mut across_m = along_m;
        for &[x_m, y_m] in hull_m {
            for lane in 0..N_ABREAST {
                let u = x_m * along_x[lane] + y_m * along_y[lane];
                let v = y_m * along_x[lane] - x_m * along_y[lane];
                along_m[0][lane] = lesser(u, along_m[0][lane]);
                along_m[1][lane] = greater(u, along_m[1][lane]);
                across_m[0][lane] = lesser(v, across_m[0][lane]);
                across_m[1][lane] = greater(v, across_m[1][lane]);
            }
        }
        let mut sums_m = [0.0; N_ABREAST];
        for &[x_m, y_m] in hull_m {
            for lane in 0..N_ABREAST {
                let u = x_m * along_x[lane] + y_m * along_y[lane];
                let v = y_m * along_x[lane] - x_m * along_y[lane];
                let to_side = |value: f32, sides: &[[f32; N_ABREAST]; 2]| {
                    lesser(value - sides[0][lane], sides[1][lane] - value)
                };
                sums_m[lane] += lesser(to_side(u, &along_m), to_side(v, &across_m));
            }
        }
        Rectangles { along_m, across_m, mean_distance_m: sums_m.map(|it| it / hull_m.len() as f32) }
    }
}

fn box_over(rectangle: &Rectangle, z_range_m: [f32; 2]) -> OrientedBox {
    let [ux, uy] = rectangle.along;
    let middle = |range_m: [f32; 2]| 0.5 * (range_m[0] + range_m[1]);
    let (u, v) = (middle(rectangle.along_m), middle(rectangle.across_m));
    let along_m = rectangle.along_m[1] - rectangle.along_m[0];
    let across_m = rectangle.across_m[1] - rectangle.across_m[0];
    let edge_yaw_rad = single::atan2(uy, ux);
    let (length_m, width_m, yaw_rad) = if along_m >= across_m {
        (along_m, across_m, edge_yaw_rad)
    } else {
        (across_m, along_m, edge_yaw_rad + std::f32::consts::FRAC_PI_2)
    };
    OrientedBox {
        center_m: [u * ux - v * uy, u * uy + v * ux, middle(z_range_m)],
        length_width_height_m: [length_m, width_m, z_range_m[1] - z_range_m[0]],
        yaw_rad: half_turn_yaw(yaw_rad),
    }
}

/// The yaw in (−π/2, π/2] of the same line.
pub(crate) fn half_turn_yaw(yaw_rad: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let mut yaw_rad = yaw_rad;
    while yaw_rad > FRAC_PI_2 {
        yaw_rad -= PI;
    }
    while yaw_rad <= -FRAC_PI_2 {
        yaw_rad += PI;
    }
    yaw_rad
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fit(outline_m: &[[f32; 2]]) -> Option<OrientedBox> {
        ConvexHullBox::default().fit(outline_m.iter().copied(), [-1.5, 0.0])
    }

    /// The points of a car that a sensor at the origin sees: its two near sides.
    fn near_sides(car: &OrientedBox) -> Vec<[f32; 2]> {
        let [front_left, back_left, back_right, front_right] = car.footprint_m();
        let side = |from: [f32; 2], to: [f32; 2]| {
            (0..=40).map(move |step| {
                let share = step as f32 / 40.0;
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            })
        };
        let squared_range = |p: &[f32; 2]| p[0] * p[0] + p[1] * p[1];
        let mut sides = [
            (front_left, back_left),
            (back_left, back_right),
            (back_right, front_right),
            (front_right, front_left),
        ];
        let middle = |(a, b): &([f32; 2], [f32; 2])| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        sides.sort_by(|a, b| squared_range(&middle(a)).total_cmp(&squared_range(&middle(b))));
        sides[..2].iter().flat_map(|&(from, to)| side(from, to)).collect()
    }

    #[test]
    fn nothing_has_no_box_and_degenerate_outlines_have_flat_ones() {
        assert_eq!(fit(&[]), None);
        let point = fit(&[[3.0, 4.0]]).unwrap();
        assert_eq!((point.center_m, point.length_width_height_m), ([3.0, 4.0, -0.75], [0.0, 0.0, 1.5]));
        let line = fit(&[[0.0, 0.0], [3.0, 4.0], [1.5, 2.0]]).unwrap();
        assert!(
            (line.length_width_height_m[0] - 5.0).abs() < 1e-5 && line.length_width_height_m[1].abs() < 1e-5
        );
        assert!((line.yaw_rad - 4.0_f32.atan2(3.0)).abs() < 1e-5);
    }

    proptest! {
        #[test]
        fn two_visible_sides_give_the_whole_footprint(
            angle_rad in -3.1_f32..3.1, range_m in 6.0_f32..40.0, yaw_rad in -1.5_f32..1.5,
        ) {
            let car = OrientedBox {
                center_m: [range_m * angle_rad.cos(), range_m * angle_rad.sin(), -0.75],
                length_width_height_m: [4.2, 1.8, 1.5],
                yaw_rad,
            };
            // A sensor does not see two opposite sides; the outline must hold an L.
            let outline_m = near_sides(&car);
            let spread = fit(&outline_m).unwrap();
            prop_assume!(spread.length_width_height_m[1] > 0.5);
            for axis in 0..2 {
                prop_assert!((spread.center_m[axis] - car.center_m[axis]).abs() < 0.02);
                prop_assert!((spread.length_width_height_m[axis] - car.length_width_height_m[axis]).abs() < 0.02);
            }
            let turn = (spread.yaw_rad - car.yaw_rad).sin().abs();
            prop_assert!(turn < 0.01, "yaw {} against {}", spread.yaw_rad, car.yaw_rad);
        }

        #[test]
        fn of_all_rectangles_the_closest_is_taken(
            angles_rad in prop::collection::vec(-3.0_f32..3.0, 3..60), flatness in 0.3_f32..1.0,
        ) {
            // Points on an ellipse are all corners, of more edges than are compared at a time.
            let outline_m: Vec<[f32; 2]> =
                angles_rad.iter().map(|it| [5.0 * it.cos(), 5.0 * flatness * it.sin()]).collect();
            let mut fitter = ConvexHullBox::default();
            let found = fitter.fit(outline_m.into_iter(), [0.0, 1.0]).unwrap();
            let hull_m = fitter.hull_m();
            let mut least: Option<(f32, [f32; 2])> = None;
            for (idx, from_m) in hull_m.iter().enumerate() {
                let [ux, uy] = direction(*from_m, hull_m[(idx + 1) % hull_m.len()]);
                let positions = || hull_m.iter().map(|&[x, y]| [x * ux + y * uy, y * ux - x * uy]);
                let range = |axis: usize| {
                    positions().fold([f32::INFINITY, f32::NEG_INFINITY], |it, position| {
                        [it[0].min(position[axis]), it[1].max(position[axis])]
                    })
                };
                let [along, across] = [range(0), range(1)];
                let to_side = |value: f32, sides: [f32; 2]| (value - sides[0]).min(sides[1] - value);
                let sum: f32 = positions().map(|[u, v]| to_side(u, along).min(to_side(v, across))).sum();
                let mean_m = sum / hull_m.len() as f32;
                if least.is_none_or(|(least_m, _)| mean_m < least_m) {
                    least = Some((mean_m, [along[1] - along[0], across[1] - across[0]]));
                }
            }
            let (_, [a, b]) = least.unwrap();
            let [length_m, width_m, _] = found.length_width_height_m;
            prop_assert_eq!([length_m, width_m], [a.max(b), a.min(b)]);
        }

        #[test]
        fn the_box_encloses_its_points(points_m in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0), 1..40)) {
            let outline_m: Vec<[f32; 2]> = points_m.iter().map(|&(x, y)| [x, y]).collect();
            let mut it = fit(&outline_m).unwrap();
            it.length_width_height_m = it.length_width_height_m.map(|side_m| side_m + 1e-3);
            prop_assert!(outline_m.iter().all(|&[x, y]| it.contains([x, y, -0.7])));
        }
    }
}
