//! Groups without gaps, cut where they have the fewest points.

use serde::Deserialize;

use crate::group::dense_cells::{CellStatistics, DenseCells};
use crate::group::grouping_tree::GroupingTree;
use crate::portable_math::single;
use crate::vector_instructions::{greater, lesser};

/// Tuning of [`LeafCuts::cut`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeafCutsParams {
    /// Groups as long as this are cut across, in metres.
    pub min_length_m: f32,
    /// Groups as wide as this are cut along, in metres.
    pub min_width_m: f32,
    /// Longer groups are façades, and are not cut, in metres.
    pub max_length_m: f32,
    /// Cuts are at least this far from both ends, in metres.
    pub min_end_m: f32,
    /// Groups of fewer points are not cut.
    pub min_points: u32,
    /// How often a group and its parts are cut.
    pub max_depth: u8,
    /// Number of groups of a tree from which on no more are cut.
    pub max_groups: u32,
}

/// Width of the columns in which points are counted, in metres; cuts lie in their middles.
const COLUMN_M: f32 = 0.2;
/// A cut at an end counts as one through a column fuller by this share of the mean.
const END_COST: f32 = 0.2;

/// Cuts the leaves of trees, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct LeafCuts {
    n_in_column: Vec<u32>,
    // Of the leaves of a round.
    cuts: Vec<(u32, Plane)>,
}

/// A vertical plane.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: [f32; 2],
    offset_m: f32,
}

impl Plane {
    fn is_before(self, [x_m, y_m]: [f32; 2]) -> bool {
        x_m * self.normal[0] + y_m * self.normal[1] < self.offset_m
    }
}

impl LeafCuts {
    /// Cuts every leaf of `tree` that is longer or wider than one person at the position with the fewest points, and its
    /// parts again, until there are as many groups as there may be: groups of many points are cut before groups of few.
    /// Returns how many were left uncut for that reason.
    pub fn cut(&mut self, tree: &mut GroupingTree, dense: &DenseCells, params: &LeafCutsParams) -> usize {
        let mut n_left_uncut = 0;
        // Parts are added at the end, and are cut in the next round.
        let mut round = 0..tree.nodes().len();
        while !round.is_empty() {
            let n_before = tree.nodes().len();
            self.cuts.clear();
            for leaf in round {
                let node = &tree.nodes()[leaf];
                if node.first_child.is_none()
                    && node.statistics.n_points >= params.min_points
                    && node.n_cuts < params.max_depth
                    && let Some(plane) = self.plane(tree.cells(node), &node.statistics, dense, params)
                {
                    self.cuts.push((leaf as u32, plane));
                }
            }
            n_left_uncut += self.keep_affordable(tree, (params.max_groups as usize).saturating_sub(n_before));
            for &(leaf, plane) in &self.cuts {
                tree.part(leaf, dense, |statistics| plane.is_before(statistics.middle_m()));
            }
            round = n_before..tree.nodes().len();
        }
        n_left_uncut
    }

    /// Keeps only the cuts of the leaves with the most points if all cuts of a round would make more than `n_more` groups.
    /// Returns how many cuts it drops.
    fn keep_affordable(&mut self, tree: &GroupingTree, n_more: usize) -> usize {
        let n_cuts = n_more / 2;
        let n_dropped = self.cuts.len().saturating_sub(n_cuts);
        if n_dropped > 0 {
            let rank = |&(leaf, _): &(u32, Plane)| {
                (std::cmp::Reverse(tree.nodes()[leaf as usize].statistics.n_points), leaf)
            };
            self.cuts.sort_unstable_by_key(rank);
            self.cuts.truncate(n_cuts);
            self.cuts.sort_unstable_by_key(|it| it.0);
        }
        n_dropped
    }

    fn plane(
        &mut self,
        cells: &[u32],
        statistics: &CellStatistics,
        dense: &DenseCells,
        params: &LeafCutsParams,
    ) -> Option<Plane> {
        let [across_m, along_m] = [0, 1].map(|axis| statistics.high_m[axis] - statistics.low_m[axis]);
        let diagonal_m = single::hypot(across_m, along_m);
        if cells.len() < 2
            || diagonal_m < params.min_length_m.min(params.min_width_m)
            || across_m.max(along_m) > params.max_length_m
        {
            return None;
        }
        let along = principal_axis(cells, dense);
        let mut best: Option<(f32, Plane)> = None;
        for (normal, least_m) in [(along, params.min_length_m), ([-along[1], along[0]], params.min_width_m)] {
            if let Some(found) = self.cheapest(cells, dense, normal, least_m, params.min_end_m)
                && best.is_none_or(|(least, _)| found.0 < least)
            {
                best = Some(found);
            }
        }
        best.map(|(_, plane)| plane)
    }

    /// The plane across `normal` that cuts the fewest points, and its cost; at least `min_end_m` from both ends. `None` if
    /// there is no such position, or the cells reach less than `least_m` along it.
    fn cheapest(
        &mut self,
        cells: &[u32],
        dense: &DenseCells,
        normal: [f32; 2],
        least_m: f32,
        min_end_m: f32,
    ) -> Option<(f32, Plane)> {
        let along_m = |cell: u32| {
            let [x_m, y_m] = dense.statistics()[cell as usize].middle_m();
            x_m * normal[0] + y_m * normal[1]
        };
        let (mut start_m, mut end_m) = (f32::INFINITY, f32::NEG_INFINITY);
        for &cell in cells {
            let it_m = along_m(cell);
            start_m = lesser(it_m, start_m);
            end_m = greater(it_m, end_m);
        }
        // The cells reach beyond their middles.
        start_m -= 0.5 * COLUMN_M;
        let extent_m = end_m + 0.5 * COLUMN_M - start_m;
        if extent_m < least_m {
            return None;
        }
        let last = (extent_m / COLUMN_M) as usize;
        self.n_in_column.clear();
        self.n_in_column.resize(last + 1, 0);
        let mut n_points = 0;
        for &cell in cells {
            let n_in_cell = dense.statistics()[cell as usize].n_points;
            self.n_in_column[(((along_m(cell) - start_m) / COLUMN_M) as usize).min(last)] += n_in_cell;
            n_points += n_in_cell;
        }
        let n_in = |column: usize| self.n_in_column.get(column).copied().unwrap_or(0);
        let mean = n_points as f32 / (last + 1) as f32;
        let n_end = (min_end_m / COLUMN_M) as usize;
        let mut best: Option<(f32, Plane)> = None;
        for column in n_end..(last + 1).saturating_sub(n_end) {
            let n_quadrupled = 2 * n_in(column) + n_in(column.wrapping_sub(1)) + n_in(column + 1);
            let from_middle = (2 * column).abs_diff(last) as f32 / last as f32;
            let cost = n_quadrupled as f32 / (4.0 * mean) + END_COST * from_middle;
            if best.is_none_or(|(least, _)| cost < least) {
                let offset_m = start_m + (column as f32 + 0.5) * COLUMN_M;
                best = Some((cost, Plane { normal, offset_m }));
            }
        }
        best
    }
}

/// The direction in which cells, at least one, spread most: a unit vector.
fn principal_axis(cells: &[u32], dense: &DenseCells) -> [f32; 2] {
    let middles_m = || cells.iter().map(|&it| dense.statistics()[it as usize].middle_m());
    let n = cells.len() as f32;
    let (mut x_sum, mut y_sum) = (0.0, 0.0);
    for [x_m, y_m] in middles_m() {
        x_sum += x_m;
        y_sum += y_m;
    }
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for [x_m, y_m] in middles_m() {
        let (dx, dy) = (x_m - x_sum / n, y_m - y_sum / n);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    // Of the eigenvectors of a symmetric matrix: half the angle of (xx − yy, 2 xy).
    let (cos_doubled, sin_doubled) = (xx - yy, 2.0 * xy);
    let length = (cos_doubled * cos_doubled + sin_doubled * sin_doubled).sqrt();
    if length <= 0.0 {
        return [1.0, 0.0];
    }
    let cos = (0.5 * (1.0 + cos_doubled / length)).max(0.0).sqrt();
    let sin = (0.5 * (1.0 - cos_doubled / length)).max(0.0).sqrt();
    [cos, if sin_doubled < 0.0 { -sin } else { sin }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::drawn_trees::tree_over;
    use crate::params::HierarchicalParams;

    /// The numbers of cells of the parts of the only leaf, once cut.
    fn parts(steps: &[[u8; 2]], max_depth: u8) -> Vec<usize> {
        let params = LeafCutsParams { max_depth, ..HierarchicalParams::shipped().grouping.cuts };
        let (dense, mut tree, _) = tree_over(steps);
        assert_eq!(tree.nodes().len(), 1, "it is one leaf");
        LeafCuts::default().cut(&mut tree, &dense, &params);
        tree.parts_of(&tree.nodes()[0]).map(|it| tree.cells(&tree.nodes()[it as usize]).len()).collect()
    }

    fn block(columns: std::ops::Range<u8>, rows: std::ops::Range<u8>) -> Vec<[u8; 2]> {
        columns.flat_map(|column| rows.clone().map(move |row| [column, row])).collect()
    }

    #[test]
    fn two_that_touch_are_cut_where_they_do() {
        let two = [block(0..6, 0..6), block(6..7, 2..3), block(7..13, 0..6)].concat();
        let found = parts(&two, 1);
        assert_eq!(found.iter().sum::<usize>(), 73);
        assert!(found.iter().all(|it| [36, 37].contains(it)), "{found:?}");
    }

    #[test]
    fn one_person_is_not_cut_and_nothing_is_if_no_cut_is_allowed() {
        assert_eq!(parts(&block(0..3, 0..2), 5), []);
        assert_eq!(parts(&block(0..20, 0..6), 0), []);
    }

    #[test]
    fn a_budget_is_spent_on_groups_of_many_points_and_what_is_left_is_counted() {
        // Three apart, of which the middle one is the largest; each gets two parts. A fourth would have to be cut too near
        // its end.
        let three =
            [block(0..6, 0..6), block(10..19, 0..6), block(23..28, 0..6), block(40..42, 0..2)].concat();
        let cut = |max_groups| {
            let params =
                LeafCutsParams { max_groups, max_depth: 1, ..HierarchicalParams::shipped().grouping.cuts };
            let (dense, mut tree, _) = tree_over(&three);
            let n_before = tree.nodes().len() as u32;
            let n_left = LeafCuts::default().cut(&mut tree, &dense, &params);
            let is_cut = |n_cells: usize| {
                let node = tree.nodes().iter().find(|it| tree.cells(it).len() == n_cells).unwrap();
                node.first_child.is_some()
            };
            (n_before, n_left, [36, 54, 30].map(is_cut))
        };
        let (n_before, n_left, are_cut) = cut(1000);
        assert_eq!((n_left, are_cut), (0, [true; 3]));
        assert_eq!(cut(n_before + 4), (n_before, 1, [true, true, false]));
        assert_eq!(cut(n_before + 3), (n_before, 2, [false, true, false]));
        assert_eq!(cut(0), (n_before, 3, [false; 3]));
    }

    #[test]
    fn parts_are_cut_again_and_lose_nothing() {
        let (dense, mut tree, _) = tree_over(&block(0..20, 0..6));
        LeafCuts::default().cut(&mut tree, &dense, &HierarchicalParams::shipped().grouping.cuts);
        assert!(tree.nodes().len() > 5);
        let leaves = tree.nodes().iter().filter(|it| it.first_child.is_none());
        assert_eq!(leaves.map(|it| tree.cells(it).len()).sum::<usize>(), 120);
        for node in tree.nodes() {
            let n_parts: u32 =
                tree.parts_of(node).map(|it| tree.nodes()[it as usize].statistics.n_points).sum();
            assert!(n_parts == 0 || n_parts == node.statistics.n_points);
        }
    }
}
