//! Components over a kd-tree, found in cells: at one tolerance, or components within components at several.

use detector::segment::disjoint_sets::DisjointSets;

/// Components that [`NestedComponents::join`] finds, in buffers that the next scan uses again.
///
/// Two points are neighbours as in [`kd_tree_components`](crate::kd_tree_components::kd_tree_components): if their squared
/// distance is strictly below the squared tolerance, both in f32. That function lists all neighbours of every point. Here
/// the points of a small cell are neighbours without being looked at, and two cells are only compared while they are of
/// different components.
#[derive(Debug, Clone, Default)]
pub struct NestedComponents {
    // The smallest index of a point stands for its component.
    components: DisjointSets,
    // For every point its cell and its number, so that those of a cell stand one behind the other.
    keyed: Vec<u128>,
    points_m: Vec<[f32; 3]>,
    cells: Vec<Cell>,
}

/// The points of a cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    // Steps from the origin, moved so that they are not negative.
    steps: [u32; 3],
    // Indices in the list of points.
    start: usize,
    end: usize,
    // One of the points.
    point_idx: u32,
    low_m: [f32; 3],
    high_m: [f32; 3],
}

/// The side of a cell in tolerances: less than 1/√3, so that the points of a cell are neighbours; and more than 1/2, so that
/// neighbours are at most [`REACH`] cells apart. Both margins are larger than rounding, from [`LEAST_TOLERANCE_M`] on.
const SIDE: f32 = 0.57;
const REACH: u32 = 2;

const LEAST_TOLERANCE_M: f32 = 0.05;

/// Points farther away have no neighbours, in metres.
const FARTHEST_M: f32 = 1_000.0;

impl NestedComponents {
    /// Whether [`Self::join`] gives exactly the components over a kd-tree: no tolerance is below 5 cm, and no finite point is
    /// a kilometre away.
    pub fn are_exact(positions_m: &[[f32; 3]], tolerance_m: f32) -> bool {
        let is_in_reach = |it: &[f32; 3]| it.iter().all(|it| !it.is_finite() || it.abs() <= FARTHEST_M);
        tolerance_m >= LEAST_TOLERANCE_M && positions_m.iter().all(is_in_reach)
    }

    /// Begins with `n_points` components of one point.
    pub fn reset(&mut self, n_points: usize) {
        self.components.reset(n_points);
    }

    /// The smallest index of a point of the component of `point_idx`.
    pub fn component(&mut self, point_idx: u32) -> u32 {
        self.components.representative(point_idx)
    }

    /// Writes to `labels`, for every point, the smallest index of a point of its component.
    pub fn write_labels(&mut self, n_points: usize, labels: &mut Vec<u32>) {
        labels.clear();
        labels.extend((0..n_points as u32).map(|it| self.component(it)));
    }

    /// Joins the components of neighbours at this tolerance, in metres, of 0.05 and more. `on_join` gets the two
    /// components of every join.
    ///
    /// ```
    /// use baselines::nested_components::NestedComponents;
    ///
    /// let positions_m = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.8, 0.0, 0.0]];
    /// let (mut components, mut joined) = (NestedComponents::default(), Vec::new());
    /// components.reset(positions_m.len());
    /// for tolerance_m in [0.3, 0.5, 0.7] {
    ///     components.join(&positions_m, tolerance_m, |a, b| joined.push((tolerance_m, [a, b])));
    /// }
    /// assert_eq!(joined, [(0.3, [0, 1]), (0.7, [0, 2])]);
    /// ```
    pub fn join(&mut self, positions_m: &[[f32; 3]], tolerance_m: f32, mut on_join: impl FnMut(u32, u32)) {
        self.fill_cells(positions_m, tolerance_m);
        let squared_m2 = tolerance_m * tolerance_m;
        let Self { components, keyed, points_m, cells, .. } = self;
        let mut join = |components: &mut DisjointSets, [a, b]: [u32; 2]| {
            let [a, b] = [a, b].map(|it| components.representative(it));
            if a != b {
                components.join(a, b);
                on_join(a.min(b), a.max(b));
            }
        };
        for cell in &*cells {
            for &key in &keyed[cell.start + 1..cell.end] {
                join(components, [cell.point_idx, key as u32]);
            }
        }
        for [dx, dy] in columns_ahead() {
            // Cells are in the order of their steps, and so are the cells at a fixed distance from them.
            let (mut from, mut to) = (0, 0);
            for cell in &*cells {
                let [x, y, z] = cell.steps;
                let column = [x + dx, (y + dy) - REACH];
                let is_own = dx == 0 && dy == REACH;
                let first = if is_own { z + 1 } else { z - REACH };
                let is_before = |it: &Cell, z: u32| it.steps < [column[0], column[1], z];
                while cells.get(from).is_some_and(|it| is_before(it, first)) {
                    from += 1;
                }
                to = to.max(from);
                while cells.get(to).is_some_and(|it| is_before(it, z + REACH + 1)) {
                    to += 1;
                }
                for other in &cells[from..to] {
                    let both = [cell, other].map(|it| components.representative(it.point_idx));
                    if both[0] != both[1] && cell.is_near(other, points_m, squared_m2) {
                        join(components, both);
                    }
                }
            }
        }
    }

    /// Sorts the points into cells so small that all points of a cell are neighbours.
    fn fill_cells(&mut self, positions_m: &[[f32; 3]], tolerance_m: f32) {
        let Self { keyed, points_m, cells, .. } = self;
        let per_m = 1.0 / (SIDE * tolerance_m);
        // All steps are REACH and more, so that none is negative behind it.
        let origin = REACH as f32 + (FARTHEST_M * per_m).ceil();
        keyed.clear();
        for (point_idx, position_m) in (0_u32..).zip(positions_m) {
            if position_m.iter().all(|it| it.abs() <= FARTHEST_M) {
                let [x, y, z] = position_m.map(|it| u128::from(((it * per_m).floor() + origin) as u32));
                keyed.push(x << 96 | y << 64 | z << 32 | u128::from(point_idx));
            }
        }
        keyed.sort_unstable();
        points_m.clear();
        points_m.extend(keyed.iter().map(|&it| positions_m[it as u32 as usize]));
        cells.clear();
        let mut start = 0;
        for of_cell in keyed.chunk_by(|a, b| a >> 32 == b >> 32) {
            let end = start + of_cell.len();
            let steps = [96, 64, 32].map(|bits| (of_cell[0] >> bits) as u32);
            let mut cell = Cell {
                steps,
                start,
                end,
                point_idx: of_cell[0] as u32,
                low_m: [f32::INFINITY; 3],
                high_m: [f32::NEG_INFINITY; 3],
            };
            for point_m in &points_m[start..end] {
                cell.low_m = std::array::from_fn(|axis| cell.low_m[axis].min(point_m[axis]));
                cell.high_m = std::array::from_fn(|axis| cell.high_m[axis].max(point_m[axis]));
            }
            cells.push(cell);
            start = end;
        }
    }
}

impl Cell {
    /// Whether a point of this one and one of the other are nearer than `squared_m2`.
    ///
    /// Rounding never makes the difference of two coordinates larger than that of two that enclose them, so that a box that
    /// is too far away holds no point that is near.
    fn is_near(&self, other: &Self, points_m: &[[f32; 3]], squared_m2: f32) -> bool {
        if squared_distance_m2(self.nearest_m(other.low_m, other.high_m), [0.0; 3]) >= squared_m2 {
            return false;
        }
        points_m[self.start..self.end].iter().any(|&a_m| {
            let is_box_near = squared_distance_m2(other.nearest_m(a_m, a_m), [0.0; 3]) < squared_m2;
            is_box_near
                && points_m[other.start..other.end]
                    .iter()
                    .any(|&b_m| squared_distance_m2(a_m, b_m) < squared_m2)
        })
    }

    /// The least difference, axis by axis, between a point of the box and one of another.
    fn nearest_m(&self, low_m: [f32; 3], high_m: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| {
            (low_m[axis] - self.high_m[axis]).max(self.low_m[axis] - high_m[axis]).max(0.0)
        })
    }
}

/// The columns of cells that each cell is compared with, from its own one on, so that each pair is compared once. The second
/// step is too large by [`REACH`].
fn columns_ahead() -> impl Iterator<Item = [u32; 2]> {
    let steps = (0..=REACH).flat_map(|dx| (0..=2 * REACH).map(move |dy| [dx, dy]));
    steps.filter(|&[dx, dy]| dx > 0 || dy >= REACH)
}

fn squared_distance_m2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [dx, dy, dz] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dx * dx + dy * dy + dz * dz
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::kd_tree_components::{KdTreeScratch, kd_tree_components};

    #[track_caller]
    fn check_against_kd_tree(positions_m: &[[f32; 3]], tolerances_m: &[f32]) {
        let mut nested = NestedComponents::default();
        // Another scan before.
        nested.reset(3);
        nested.join(&[[0.0; 3]; 3], 0.5, |_, _| ());
        nested.reset(positions_m.len());
        let mut expected = Vec::new();
        let mut labels: Vec<u32> = (0..positions_m.len() as u32).collect();
        for &tolerance_m in tolerances_m {
            nested.join(positions_m, tolerance_m, |kept, gone| {
                assert!(kept < gone, "{kept} and {gone}");
                labels.iter_mut().filter(|it| **it == gone).for_each(|it| *it = kept);
            });
            kd_tree_components(positions_m, tolerance_m, &mut KdTreeScratch::default(), &mut expected);
            let found: Vec<u32> = (0..positions_m.len() as u32).map(|it| nested.component(it)).collect();
            assert_eq!(found, expected, "at {tolerance_m} m");
            assert_eq!(labels, expected, "as `on_join` reports, at {tolerance_m} m");
        }
    }

    #[test]
    fn points_that_are_not_finite_or_far_away_stay_alone() {
        let nan = [f32::NAN, 0.0, 0.0];
        check_against_kd_tree(&[nan, [0.0; 3], [f32::MAX; 3], [0.1, 0.0, 0.0], [f32::MIN; 3], nan], &[0.5]);
        check_against_kd_tree(&[], &[0.5]);
    }

    #[test]
    fn they_are_exact_within_a_kilometre_from_five_centimetres_on() {
        let exact = |x_m, tolerance_m| NestedComponents::are_exact(&[[0.0; 3], [x_m, 0.0, 0.0]], tolerance_m);
        assert!(exact(FARTHEST_M, 0.05) && exact(f32::NAN, 0.5));
        assert!(
            !exact(-FARTHEST_M.next_up(), 0.5) && !exact(1.0, 0.05_f32.next_down()) && !exact(1.0, f32::NAN)
        );
    }

    #[test]
    fn cells_far_from_the_origin_are_as_exact() {
        let row = |it: u16| [990.0 + f32::from(it) * 0.25, -999.0, 0.0];
        check_against_kd_tree(&(0..40).map(row).collect::<Vec<_>>(), &[0.05, 0.25, 0.3, 0.5]);
    }

    proptest! {
        #[test]
        fn they_are_those_over_a_kd_tree_at_each_tolerance(
            positions_m in prop::collection::vec([-2.0_f32..2.0, -2.0_f32..2.0, -0.8_f32..0.8], 0..120),
        ) {
            check_against_kd_tree(&positions_m, &[0.1, 0.3, 0.5, 0.8, 1.2]);
        }

        #[test]
        fn and_where_distances_are_the_tolerance(
            steps in prop::collection::vec([-6_i8..6, -6_i8..6, -3_i8..3], 0..120),
        ) {
            let positions_m: Vec<_> = steps.into_iter().map(|it| it.map(|it| f32::from(it) * 0.25)).collect();
            check_against_kd_tree(&positions_m, &[0.25, 0.3, 0.5, 0.75, 1.0]);
        }
    }
}
