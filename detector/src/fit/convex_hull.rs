//! The convex outline of points on the ground plan.

use crate::vector_instructions::{HotLoop, vectorised};

/// Reduces `points_m` to the corners of their convex hull, counter-clockwise from the corner with the smallest x, and
/// of those the smallest y. Points along an edge and repeated points are no corners.
///
/// Points that are all the same leave one corner, points on a line two, no points none. The points must be finite.
///
/// Monotone chain. Paper: VM section 4, reference 12.
pub fn convex_hull(points_m: &mut Vec<[f32; 2]>, hull_m: &mut Vec<[f32; 2]>) {
    hull_m.clear();
    drop_inner_points(points_m);
    let first_m = points_m.iter().copied().min_by_key(|&it| x_then_y(it));
    let last_m = points_m.iter().copied().max_by_key(|&it| x_then_y(it));
    let (Some(first_m), Some(last_m)) = (first_m, last_m) else { return };
    if first_m == last_m {
        hull_m.push(first_m);
        return;
    }
    let (below_m, above_m) = split(points_m, first_m, last_m);
    below_m.sort_unstable_by_key(|&it| x_then_y(it));
    above_m.sort_unstable_by_key(|&it| x_then_y(it));
    extend_chain([first_m].iter().chain(&*below_m).chain([&last_m]), hull_m);
    extend_chain([last_m].iter().chain(above_m.iter().rev()).chain([&first_m]), hull_m);
}

/// A number for each point that orders them by x, and by y where x is the same, as `total_cmp` does: one comparison of
/// numbers for two of coordinates.
fn x_then_y([x, y]: [f32; 2]) -> u64 {
    let ascending = |value: f32| {
        let bits = value.to_bits();
        // Of negative numbers, the greater is the one with the smaller bits.
        if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
    };
    u64::from(ascending(x)) << 32 | u64::from(ascending(y))
}

/// Separates the points below the line from `first_m` to `last_m` from the others.
fn split(
    points_m: &mut [[f32; 2]],
    first_m: [f32; 2],
    last_m: [f32; 2],
) -> (&mut [[f32; 2]], &mut [[f32; 2]]) {
    let mut n_below = 0;
    for idx in 0..points_m.len() {
        let is_below = turn(first_m, last_m, points_m[idx]) < 0.0;
        points_m.swap(n_below, idx);
        n_below += usize::from(is_below);
    }
    points_m.split_at_mut(n_below)
}

/// Fewer points are sorted sooner than filtered.
const MIN_POINTS_TO_FILTER: usize = 32;

/// Drops most of the points that cannot be corners: those inside the octagon of the points farthest out in eight directions
/// (Akl and Toussaint 1978), and then those inside of another one, turned by half a step. The remaining points have the same
/// hull.
fn drop_inner_points(points_m: &mut Vec<[f32; 2]>) {
    // The tangents of no turn and of 22.5 degrees.
    for turned in [0.0, 0.414] {
        if points_m.len() < MIN_POINTS_TO_FILTER {
            return;
        }
        let sides = Octagon::around(points_m, turned).sides();
        let n_kept = vectorised(Filter { points_m, sides });
        points_m.truncate(n_kept);
    }
}

/// Points, and an octagon inside of which they are dropped.
struct Filter<'a> {
    points_m: &'a mut [[f32; 2]],
    sides: Sides,
}

impl HotLoop for Filter<'_> {
    type Output = usize;

    /// Puts the kept points first, and returns their number.
    #[inline(always)]
    fn run(self) -> usize {
        let Self { points_m, sides } = self;
        let mut n_kept = 0;
        for idx in 0..points_m.len() {
            let point_m = points_m[idx];
            points_m[n_kept] = point_m;
            // Added, not branched on: which points are kept cannot be foreseen.
            n_kept += usize::from(!sides.enclose(point_m));
        }
        n_kept
    }
}

/// From here on every fourth point suffices to build the octagon of: any points may be its corners.
const MIN_POINTS_TO_SAMPLE: usize = 256;

const N_DIRECTIONS: usize = 8;

/// The points farthest in eight directions, counter-clockwise.
struct Octagon {
    x_m: [f32; N_DIRECTIONS],
    y_m: [f32; N_DIRECTIONS],
}

impl Octagon {
    /// `turned` is the tangent by which the directions are turned away from x.
    fn around(points_m: &[[f32; 2]], turned: f32) -> Self {
        // Forward, left, forward left and forward right; and the other way.
        let mut highest = [f32::NEG_INFINITY; 4];
        let mut lowest = [f32::INFINITY; 4];
        let mut highest_idx = [0; 4];
        let mut lowest_idx = [0; 4];
        let step = if points_m.len() < MIN_POINTS_TO_SAMPLE { 1 } else { 4 };
        for (point_idx, &[x, y]) in (0_u32..).zip(points_m).step_by(step) {
            let (u, v) = (x + turned * y, y - turned * x);
            let reached = [u, v, u + v, u - v];
            for axis in 0..4 {
                let (is_higher, is_lower) = (reached[axis] > highest[axis], reached[axis] < lowest[axis]);
                highest[axis] = if is_higher { reached[axis] } else { highest[axis] };
                highest_idx[axis] = if is_higher { point_idx } else { highest_idx[axis] };
                lowest[axis] = if is_lower { reached[axis] } else { lowest[axis] };
                lowest_idx[axis] = if is_lower { point_idx } else { lowest_idx[axis] };
            }
        }
        let [forward, left, forward_left, forward_right] = highest_idx;
        let [backward, right, backward_right, backward_left] = lowest_idx;
        let counter_clockwise =
            [right, forward_right, forward, forward_left, left, backward_left, backward, backward_right];
        let corners_m = counter_clockwise.map(|point_idx| points_m[point_idx as usize]);
        Self { x_m: corners_m.map(|it| it[0]), y_m: corners_m.map(|it| it[1]) }
    }

    fn sides(&self) -> Sides {
        let [x_m, y_m] = [self.x_m, self.y_m];
        let next = |idx: usize| (idx + 1) % N_DIRECTIONS;
        let along_x_m = std::array::from_fn(|idx| x_m[next(idx)] - x_m[idx]);
        let along_y_m = std::array::from_fn(|idx| y_m[next(idx)] - y_m[idx]);
        let length_m = |ends: &[f32; N_DIRECTIONS]| {
            let low_m = ends.iter().copied().fold(f32::INFINITY, f32::min);
            ends.iter().copied().fold(f32::NEG_INFINITY, f32::max) - low_m
        };
        let size_m = length_m(&x_m).max(length_m(&y_m));
        let least_turn = std::array::from_fn(|idx: usize| {
            let length_m: f32 = f32::abs(along_x_m[idx]) + f32::abs(along_y_m[idx]);
            if size_m == 0.0 {
                // All points are the same; none is inner.
                f32::INFINITY
            } else if length_m == 0.0 {
                // A repeated corner makes a side of no length, which every point passes.
                -1.0
            } else {
                ROUNDING * size_m * length_m
            }
        });
        Sides { x_m, y_m, along_x_m, along_y_m, least_turn }
    }
}

/// Far above the rounding of a turn, relative to the lengths it is made of, and far below a millimetre in ten metres.
const ROUNDING: f32 = 1e-5;

/// The sides of an octagon as starts and directions.
struct Sides {
    x_m: [f32; N_DIRECTIONS],
    y_m: [f32; N_DIRECTIONS],
    along_x_m: [f32; N_DIRECTIONS],
    along_y_m: [f32; N_DIRECTIONS],
    least_turn: [f32; N_DIRECTIONS],
}

impl Sides {
    /// Whether a point lies clearly to the left of every side.
    #[inline(always)]
    fn enclose(&self, [x, y]: [f32; 2]) -> bool {
        let mut is_inner = true;
        for idx in 0..N_DIRECTIONS {
            let turn = self.along_x_m[idx] * (y - self.y_m[idx]) - self.along_y_m[idx] * (x - self.x_m[idx]);
            is_inner &= turn > self.least_turn[idx];
        }
        is_inner
    }
}

/// Appends the chain of left turns through `sorted_m`, without its last corner.
fn extend_chain<'a>(sorted_m: impl Iterator<Item = &'a [f32; 2]>, hull_m: &mut Vec<[f32; 2]>) {
    let first = hull_m.len();
    for &point_m in sorted_m {
        while let [.., before_m, last_m] = hull_m[first..] {
            if turn(before_m, last_m, point_m) > 0.0 {
                break;
            }
            hull_m.pop();
        }
        hull_m.push(point_m);
    }
    hull_m.pop();
}

/// Twice the signed area of the triangle; positive for a left turn.
fn turn(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f64 {
    // Differences of f32 values of similar size are exact enough in f64 for the sign to be right.
    let difference = |to: [f32; 2], axis: usize| f64::from(to[axis]) - f64::from(a[axis]);
    difference(b, 0) * difference(c, 1) - difference(b, 1) * difference(c, 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hull_of(points_m: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let mut hull_m = Vec::new();
        convex_hull(&mut points_m.to_vec(), &mut hull_m);
        hull_m
    }

    #[test]
    fn few_points_and_points_on_a_line_have_defined_hulls() {
        let none: [[f32; 2]; 0] = [];
        assert_eq!(hull_of(&[]), none);
        assert_eq!(hull_of(&[[1.0, 2.0]; 5]), [[1.0, 2.0]]);
        assert_eq!(hull_of(&[[0.0, 0.0], [2.0, 2.0], [1.0, 1.0], [3.0, 3.0]]), [[0.0, 0.0], [3.0, 3.0]]);
    }

    #[test]
    fn points_inside_and_on_edges_are_no_corners() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let with_more = [square.to_vec(), vec![[0.5, 0.5], [0.5, 0.0], [1.0, 0.5]]].concat();
        assert_eq!(hull_of(&with_more), square);
    }

    #[expect(clippy::float_cmp, reason = "whether it is the same point")]
    fn brute_force_corners(points_m: &[[f32; 2]]) -> Vec<[f32; 2]> {
        // A point is a corner if it is in no triangle and on no segment of other points.
        let mut unique = points_m.to_vec();
        unique.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        unique.dedup();
        let inside = |p: [f32; 2], t: [[f32; 2]; 3]| {
            let turns = [turn(t[0], t[1], p), turn(t[1], t[2], p), turn(t[2], t[0], p)];
            turns.iter().all(|&it| it >= 0.0) || turns.iter().all(|&it| it <= 0.0)
        };
        let covers = |p: [f32; 2], t: [[f32; 2]; 3]| {
            let within = |axis: usize| {
                let low = t.iter().map(|it| it[axis]).fold(f32::INFINITY, f32::min);
                let high = t.iter().map(|it| it[axis]).fold(f32::NEG_INFINITY, f32::max);
                (low..=high).contains(&p[axis])
            };
            within(0) && within(1) && inside(p, t)
        };
        let is_covered = |p: [f32; 2]| {
            let others: Vec<_> = unique.iter().copied().filter(|&it| it != p).collect();
            others.iter().any(|&a| others.iter().any(|&b| others.iter().any(|&c| covers(p, [a, b, c]))))
        };
        unique.iter().copied().filter(|&p| !is_covered(p)).collect()
    }

    proptest! {
        #[test]
        fn the_hull_has_the_corners_that_no_triangle_of_other_points_covers(
            // On a lattice, so that points repeat and line up; often enough for the filter to take part, and to be sampled.
            steps in prop::collection::vec((0_i8..6, 0_i8..6), 1..60), n_times in 1_usize..9,
        ) {
            let points_m: Vec<[f32; 2]> = steps.iter().map(|&(x, y)| [f32::from(x), f32::from(y)]).collect();
            let points_m = points_m.repeat(n_times);
            let mut corners = hull_of(&points_m);
            corners.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            prop_assert_eq!(corners, brute_force_corners(&points_m));
        }
    }
}
