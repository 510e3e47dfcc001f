//! How far apart the dense cells of a scan are.

use std::ops::Range;

use serde::Deserialize;

use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::group::candidates::{Candidates, Evidence};
use crate::group::dense_cells::DenseCells;
use crate::group::linkage::{Linkage, LinkedScan, Links, N_LEVELS};
use crate::group::reached::{GroupRange, NOWHERE, Reached, Step};
use crate::segment::disjoint_sets::DisjointSets;
use crate::segment::expected_density::ExpectedDensity;

/// Tuning of [`DenseGaps::find`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenseGapsParams {
    /// Gaps of up to twice this many dense cells are found.
    pub n_rounds: u32,
    /// A dense cell with less than this share of the points it could be expected to hold is near-empty.
    pub low_density_share: f32,
    /// Points in a dense cell of an upright object, over those that all points together put into one at its range.
    pub object_density_ratio: f32,
    /// Where all points together put this many into a dense cell, a single empty dense cell is a gap.
    pub single_gap_points: f32,
    /// Neighbours whose highest points differ by less are of the same height, in metres; ψ in the paper.
    pub max_height_difference_m: f32,
    /// Dense cells by which neighbours of other height are taken to be farther apart.
    pub height_steps: u32,
    /// Dense cells by which a wall and a neighbour that is none are taken to be farther apart.
    pub wall_steps: u32,
}

/// Gaps between dense cells, in reusable buffers.
#[derive(Debug, Clone)]
pub struct DenseGaps {
    params: DenseGapsParams,
    xi: u32,
    // Dense cells along a side of the grid.
    n_along: usize,
    expected: ExpectedDensity,
    // For every dense cell of the grid.
    reached: Vec<Reached>,
    // The dense cells that hold enough points, and the group of each. They are joined in the order of the grid, and spread
    // in the order of their groups.
    conducting: Vec<PlacedCell>,
    group: Vec<GroupRange>,
    joined: Vec<PlacedCell>,
    next_of_group: Vec<u32>,
    groups: DisjointSets,
    // The dense cells that hold fewer.
    near_empty: Vec<PlacedCell>,
    // Positions that were reached, in this order, and behind them room for more.
    queue: Vec<Step>,
    n_queued: usize,
    // The cells whose groups met in the latest round, and room for more.
    met: Vec<[Reached; 2]>,
    // For every block.
    resolved_steps: Vec<u32>,
    is_on_wall: Vec<bool>,
    links: Links,
}

/// A dense cell that holds points.
#[derive(Debug, Clone, Copy, Default)]
struct PlacedCell {
    dense_idx: u32,
    // Its position in the grid.
    at: u32,
    // Its block, which costs a division otherwise.
    block: u32,
}

impl DenseGaps {
    /// No gaps yet, in grids of the geometry `grid`. The density decides which cells are near-empty and which gaps are none.
    pub fn new(params: DenseGapsParams, grid: &GridParams, weighting: &DensityWeighting) -> Self {
        let DenseGapsParams { object_density_ratio, single_gap_points, .. } = params;
        Self {
            xi: grid.xi,
            n_along: 0,
            expected: ExpectedDensity::new(object_density_ratio, single_gap_points, grid, weighting),
            params,
            reached: Vec::new(),
            conducting: Vec::new(),
            group: Vec::new(),
            joined: Vec::new(),
            next_of_group: Vec::new(),
            groups: DisjointSets::default(),
            near_empty: Vec::new(),
            queue: Vec::new(),
            n_queued: 0,
            met: Vec::new(),
            resolved_steps: Vec::new(),
            is_on_wall: Vec::new(),
            links: Links::default(),
        }
    }

    /// Finds the gaps between the candidates in `dense`: which groups touch, and by how many steps others are apart, up to
    /// twice [`DenseGapsParams::n_rounds`]. Groups are those of single linkage, by steps sideways or diagonal.
    pub fn find(&mut self, grid: &HierarchicalGrid, dense: &DenseCells, candidates: &Candidates) {
        let n_along = (grid.n_columns() * self.xi) as usize;
        if self.n_along != n_along {
            self.n_along = n_along;
            self.n_queued = 0;
            let is_outermost = |step: usize| step == 0 || step == n_along - 1;
            let is_border = |index: usize| is_outermost(index % n_along) || is_outermost(index / n_along);
            let at_first = |index| if is_border(index) { Reached::BORDER } else { Reached::NOTHING };
            self.reached = (0..n_along * n_along).map(at_first).collect();
        }
        for step in &self.queue[..self.n_queued] {
            self.reached[step.position() as usize] = Reached::NOTHING;
        }
        self.place_cells(grid, dense, candidates);
        self.join_touching(candidates);
        self.spread(candidates);
        // Near-empty cells belong to the nearest group.
        for it in &self.near_empty {
            let reached = self.reached[it.at as usize];
            if reached != Reached::NOTHING {
                self.links.group_of_dense[it.dense_idx as usize] = self.representative(reached);
            }
        }
    }

    fn place_cells(&mut self, grid: &HierarchicalGrid, dense: &DenseCells, candidates: &Candidates) {
        self.conducting.clear();
        self.near_empty.clear();
        self.resolved_steps.clear();
        self.is_on_wall.clear();
        let mut dense_idx = 0;
        for (&cell_idx, block) in dense.cell_of_block().iter().zip(0..) {
            let [column, row] = grid.column_and_row(cell_idx);
            let statistics = dense.statistics_of_block(block as usize);
            let expected = self.expected.of_cell(grid, cell_idx);
            self.resolved_steps.push(expected.max_steps);
            self.is_on_wall.push(candidates.evidence_against(cell_idx).has(Evidence::OnWall));
            let n_points = statistics.iter().map(|it| it.n_points);
            let least = expected.least_points(self.params.low_density_share, n_points);
            let mut statistics = statistics.iter();
            for along in 0..self.xi {
                let start = (row * self.xi + along) * self.n_along as u32 + column * self.xi;
                for (at, statistics) in (start..start + self.xi).zip(&mut statistics) {
                    let placed = PlacedCell { dense_idx, at, block };
                    dense_idx += 1;
                    if statistics.n_points as f32 >= least {
                        self.reached[at as usize] = Reached::by(self.conducting.len());
                        self.conducting.push(placed);
                    } else if statistics.n_points > 0 {
                        self.near_empty.push(placed);
                    }
                }
            }
        }
        self.links.group_of_dense.clear();
        self.links.group_of_dense.extend(0..dense.statistics().len() as u32);
    }

    /// Joins neighbouring cells to one group, unless their height or a wall sets them apart.
    fn join_touching(&mut self, candidates: &Candidates) {
        self.links.between.iter_mut().for_each(Vec::clear);
        let n = self.n_along;
        self.groups.reset(self.conducting.len());
        for conducting_idx in 0..self.conducting.len() {
            let at = self.conducting[conducting_idx].at as usize;
            for neighbor in [at + 1, at + n - 1, at + n, at + n + 1] {
                let other = self.reached[neighbor];
                if [Reached::NOTHING, Reached::BORDER].contains(&other) {
                    continue;
                }
                let between = [conducting_idx, other.conducting_idx()];
                let level = self.level(candidates, between, 1);
                let between = between.map(|it| it as u32);
                if level == 0 {
                    self.groups.join(between[0], between[1]);
                } else {
                    self.links.between[level].push(between);
                }
            }
        }
        for between in self.links.between.iter_mut().flatten() {
            *between = between.map(|it| self.conducting[self.groups.representative(it) as usize].dense_idx);
        }
        self.sort_by_group();
    }

    /// Sorts the conducting cells by their groups, and queues them.
    fn sort_by_group(&mut self) {
        std::mem::swap(&mut self.conducting, &mut self.joined);
        let n = self.joined.len();
        // The number of cells of each group, at its first cell; then where its next one goes.
        self.next_of_group.clear();
        self.next_of_group.resize(n, 0);
        for joined_idx in 0..n as u32 {
            self.next_of_group[self.groups.representative(joined_idx) as usize] += 1;
        }
        self.group.clear();
        self.conducting.clear();
        self.conducting.resize(n, PlacedCell::default());
        self.queue.resize(self.queue.len().max(n), Step::default());
        self.n_queued = n;
        for joined_idx in 0..n {
            let placed = self.joined[joined_idx];
            let group = self.groups.representative(joined_idx as u32) as usize;
            if group == joined_idx {
                let first_idx = self.group.len();
                let n_of_group = std::mem::replace(&mut self.next_of_group[group], first_idx as u32) as usize;
                let range = GroupRange { first: Reached::by(first_idx), n_values: Reached::by(n_of_group).0 };
                self.group.resize(first_idx + n_of_group, range);
            }
            let conducting_idx = self.next_of_group[group] as usize;
            self.next_of_group[group] += 1;
            self.conducting[conducting_idx] = placed;
            self.reached[placed.at as usize] = Reached::by(conducting_idx);
            self.links.group_of_dense[placed.dense_idx as usize] = self.joined[group].dense_idx;
            self.queue[joined_idx] = Step::new(placed.at, NOWHERE);
        }
    }

    /// Level of the gap between two conducting cells that are `steps` apart.
    fn level(&self, candidates: &Candidates, between: [usize; 2], steps: u32) -> usize {
        let blocks = between.map(|it| self.conducting[it].block as usize);
        let mut penalty = 0;
        if blocks[0] != blocks[1] {
            let [a, b] = blocks.map(|it| candidates.tops_m()[it]);
            if (a - b).abs() >= self.params.max_height_difference_m {
                penalty += self.params.height_steps;
            }
            if self.is_on_wall[blocks[0]] != self.is_on_wall[blocks[1]] {
                penalty += self.params.wall_steps;
            }
        }
        let resolved = self.resolved_steps[blocks[0]];
        (steps.saturating_sub(resolved) + penalty).min(N_LEVELS as u32 - 1) as usize
    }

    /// Every group grows into the free cells around it, until groups meet.
    fn spread(&mut self, candidates: &Candidates) {
        let mut front = 0..self.n_queued;
        for round in 0..self.params.n_rounds {
            let n_met = self.grow(front.clone(), round);
            for index in 0..n_met {
                self.meet(candidates, self.met[index]);
            }
            front = front.end..self.n_queued;
        }
    }

    /// Every position of `front`, which was reached in so many `steps`, reaches the free positions around it. Returns how
    /// often groups meet.
    fn grow(&mut self, front: Range<usize>, steps: u32) -> usize {
        let most = front.len() * 8;
        self.queue.resize(self.queue.len().max(self.n_queued + most), Step::default());
        self.met.resize(self.met.len().max(most), [Reached::NOTHING; 2]);
        let mut n_met = 0;
        for index in front {
            let step = self.queue[index];
            // What is beside the position before was seen from there.
            n_met = match step.direction() {
                0 => self.look(step, [0, 1, 2, 3, 6], steps, n_met),
                1 => self.look(step, [0, 1, 2], steps, n_met),
                2 => self.look(step, [0, 1, 2, 5, 8], steps, n_met),
                3 => self.look(step, [0, 3, 6], steps, n_met),
                5 => self.look(step, [2, 5, 8], steps, n_met),
                6 => self.look(step, [0, 3, 6, 7, 8], steps, n_met),
                7 => self.look(step, [6, 7, 8], steps, n_met),
                8 => self.look(step, [2, 5, 6, 7, 8], steps, n_met),
                _ => self.look(step, [0, 1, 2, 3, 5, 6, 7, 8], steps, n_met),
            };
        }
        n_met
    }

    /// Whether a neighbour is free is like the toss of a coin, so that a branch costs more than to write in vain.
    #[inline(always)]
    fn look<const N: usize>(
        &mut self,
        from: Step,
        directions: [usize; N],
        steps: u32,
        mut n_met: usize,
    ) -> usize {
        let position = from.position();
        let own = self.reached[position as usize];
        let group = self.group[own.conducting_idx()];
        let n = self.n_along as i32;
        let offsets = [-n - 1, -n, -n + 1, -1, 0, 1, n - 1, n, n + 1];
        let mut n_queued = self.n_queued;
        for direction in directions {
            let neighbor = position.wrapping_add_signed(offsets[direction]);
            let reached = &mut self.reached[neighbor as usize];
            let other = *reached;
            let is_free = other == Reached::NOTHING;
            *reached = if is_free { own.next() } else { other };
            self.queue[n_queued] = Step::new(neighbor, direction);
            n_queued += usize::from(is_free);
            // If both were reached in as many steps, only the one before the other in the grid records that they meet.
            let least_steps = steps + u32::from(steps == 0 || direction < NOWHERE);
            let is_met = (other.0 < Reached::BORDER.0) & !other.is_of(group) & (other.steps() >= least_steps);
            self.met[n_met] = [own, other];
            n_met += usize::from(is_met);
        }
        self.n_queued = n_queued;
        n_met
    }

    /// Records that the groups of two cells meet.
    fn meet(&mut self, candidates: &Candidates, between: [Reached; 2]) {
        let steps = between.map(Reached::steps).iter().sum::<u32>() + 1;
        let level = self.level(candidates, between.map(Reached::conducting_idx), steps);
        let groups = between.map(|it| self.representative(it));
        // Along a front the same two meet again and again.
        if self.links.between[level].last() != Some(&groups) {
            self.links.between[level].push(groups);
        }
    }

    /// The dense cell that represents the group that reached a position.
    fn representative(&self, reached: Reached) -> u32 {
        let group = self.group[reached.conducting_idx()];
        self.conducting[group.first.conducting_idx()].dense_idx
    }
}

/// The wider a gap is, the later it is closed. At level 0 the sensor cannot resolve one.
impl Linkage for DenseGaps {
    fn stages(&self) -> [&'static str; 2] {
        ["dense_level", "gaps"]
    }

    fn fill(&mut self, scan: &LinkedScan<'_>, dense: &mut DenseCells) {
        dense.fill(scan.cloud, scan.grid, scan.terrain, scan.candidates);
    }

    fn link(&mut self, scan: &LinkedScan<'_>, dense: &DenseCells) {
        self.find(scan.grid, dense, scan.candidates);
    }

    fn links(&self) -> &Links {
        &self.links
    }

    fn is_nested(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;
    use crate::group::drawn_trees::{DrawnGroups, corner_m, groups_of, groups_over};
    use crate::point_cloud::PointCloud;

    /// The groups of the dense cells at two steps, and the lowest level of a gap between them.
    fn between(drawn: &DrawnGroups, steps: [[u8; 2]; 2]) -> ([u32; 2], Option<u8>) {
        let groups = steps.map(|step| {
            let [x_m, y_m] = corner_m(step).map(|it| it + 0.1);
            let is_there = |it: &[f32; 2]| (it[0] - x_m).abs() < 0.1 && (it[1] - y_m).abs() < 0.1;
            let mut statistics = drawn.dense.statistics().iter();
            let dense_idx = statistics.position(|it| it.n_points > 0 && is_there(&it.middle_m()));
            drawn.gaps.links.group_of_dense[dense_idx.expect("a column stands there")]
        });
        let parts = |level: &u8| {
            let mut pairs = drawn.gaps.links.between[usize::from(*level)].iter();
            pairs.any(|it| *it == groups || *it == [groups[1], groups[0]])
        };
        (groups, (0..N_LEVELS as u8).find(parts))
    }

    /// Columns at steps, each of so many points, five centimetres one above the other, from 0.43 m above the road.
    fn columns(columns: &[([u8; 2], u8)]) -> DrawnGroups {
        let mut cloud = PointCloud::default();
        for &(step, n_points) in columns {
            let [x_m, y_m] = corner_m(step).map(|it| it + 0.1);
            (0..n_points).for_each(|it| cloud.push([x_m, y_m, f32::from(it) * 0.05 - 1.3], 0.0));
        }
        groups_of(cloud)
    }

    /// The first step that is in another coarse cell than the one before.
    fn first_of_block() -> u8 {
        let DrawnGroups { grid, .. } = columns(&[0, 1, 2, 3].map(|it| ([it, 0], 1)));
        let cells = grid.cell_of_point();
        (1..4).find(|&it| cells[usize::from(it)] != cells[usize::from(it) - 1]).expect("one has three steps")
    }

    #[track_caller]
    fn check(drawn: &DrawnGroups, steps: [[u8; 2]; 2], expected_level: Option<u8>) {
        let (groups, level) = between(drawn, steps);
        // Cells that touch are one group, without a gap to itself.
        assert_eq!((groups[0] == groups[1], level), (expected_level.is_none(), expected_level));
    }

    #[test]
    fn neighbours_of_other_height_are_farther_apart() {
        let first = first_of_block();
        let beside = |from: u8, n_points: u8| columns(&[([from, 0], 12), ([from + 1, 0], n_points)]);
        let across = [[first - 1, 0], [first, 0]];
        check(&beside(first - 1, 31), across, None);
        // More than 1 m higher, for which two dense cells are added to the step.
        check(&beside(first - 1, 34), across, Some(2));
        // Within a coarse cell there is one height.
        check(&beside(first, 34), [[first, 0], [first + 1, 0]], None);
    }

    #[test]
    fn what_is_near_empty_belongs_to_what_is_nearest() {
        // In one coarse cell, where half the mean is more than two points.
        let [here, there] = [[first_of_block(), 0], [first_of_block() + 2, 0]];
        check(&columns(&[(here, 20), (there, 20)]), [here, there], Some(1));
        check(&columns(&[(here, 20), (there, 2)]), [here, there], None);
        let nearer = [there[0] + 1, 0];
        let drawn = columns(&[(here, 20), (there, 2), (nearer, 20)]);
        check(&drawn, [nearer, there], None);
        check(&drawn, [here, nearer], Some(2));
    }

    #[test]
    fn nothing_stays_of_the_scan_before() {
        let (mut first, second) = (groups_over(&[[0, 0], [1, 0], [4, 4]]), groups_over(&[[0, 0], [4, 1]]));
        first.gaps.find(&second.grid, &second.dense, &second.candidates);
        assert_eq!(first.gaps.links, second.gaps.links);
    }

    /// The links between groups as they are found without short cuts: every position looks at all eight around it.
    fn plainly_linked(drawn: &DrawnGroups) -> [Vec<[u32; 2]>; N_LEVELS] {
        let DrawnGroups { gaps, candidates, .. } = drawn;
        let mut between: [Vec<[u32; 2]>; N_LEVELS] = Default::default();
        let group_of = |it: usize| gaps.links.group_of_dense[gaps.conducting[it].dense_idx as usize];
        let mut link = |pair: [usize; 2], steps: u32| {
            between[gaps.level(candidates, pair, steps)].push(pair.map(group_of));
        };
        let mut order: Vec<usize> = (0..gaps.conducting.len()).collect();
        order.sort_by_key(|&it| gaps.conducting[it].dense_idx);
        let mut front: Vec<(u32, usize)> = order.iter().map(|&it| (gaps.conducting[it].at, it)).collect();
        let mut reached: BTreeMap<u32, (usize, u32)> = front.iter().map(|&(at, it)| (at, (it, 0))).collect();
        let n = gaps.n_along as u32;
        let around =
            |at: u32| [at - n - 1, at - n, at - n + 1, at - 1, at + 1, at + n - 1, at + n, at + n + 1];
        for &(at, own) in &front {
            for neighbor in [at + 1, at + n - 1, at + n, at + n + 1] {
                if let Some(&(other, _)) = reached.get(&neighbor).filter(|it| group_of(it.0) != group_of(own))
                {
                    link([own, other], 1);
                }
            }
        }
        for steps in 0..gaps.params.n_rounds {
            let mut next = Vec::new();
            for (at, own) in std::mem::take(&mut front) {
                for neighbor in around(at) {
                    let Some(&(other, other_steps)) = reached.get(&neighbor) else {
                        reached.insert(neighbor, (own, steps + 1));
                        next.push((neighbor, own));
                        continue;
                    };
                    let is_later = other_steps > steps || other_steps == steps && steps > 0 && neighbor > at;
                    if group_of(other) != group_of(own) && is_later {
                        link([own, other], steps + other_steps + 1);
                    }
                }
            }
            front = next;
        }
        between
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]
        #[test]
        fn groups_are_joined_as_if_every_position_looked_around(
            heights in prop::collection::btree_map((0_u8..24, 0_u8..12), 1_u8..60, 2..40),
        ) {
            let heights: Vec<([u8; 2], u8)> = heights.into_iter().map(|((x, y), n)| ([x, y], n)).collect();
            let drawn = columns(&heights);
            let plain = plainly_linked(&drawn);
            let n_dense = drawn.dense.statistics().len();
            let [mut found, mut expected] = [DisjointSets::default(), DisjointSets::default()];
            found.reset(n_dense);
            expected.reset(n_dense);
            for (level, (links, plain)) in drawn.gaps.links.between.iter().zip(&plain).enumerate() {
                for &[a, b] in links {
                    found.join(a, b);
                }
                for &[a, b] in plain {
                    expected.join(a, b);
                }
                for dense_idx in 0..n_dense as u32 {
                    let [found, expected] = [found.representative(dense_idx), expected.representative(dense_idx)];
                    prop_assert_eq!(found, expected, "at level {}", level);
                }
            }
        }

        #[test]
        fn two_columns_are_apart_by_the_longer_of_their_steps(
            from in prop::array::uniform2(8_u8..16),
            by in prop::array::uniform2(-12_i8..=12),
        ) {
            let to = [0, 1].map(|axis| from[axis].saturating_add_signed(by[axis]));
            let longest = [0, 1].map(|axis| from[axis].abs_diff(to[axis])).into_iter().max().unwrap();
            prop_assume!(longest > 0);
            let (groups, level) = between(&groups_over(&[from, to]), [from, to]);
            // One step cannot be resolved; groups that grow by four steps meet over eight.
            let expected = (2..=8).contains(&longest).then(|| longest - 1);
            prop_assert_eq!(level, expected, "{} steps", longest);
            prop_assert_eq!(groups[0] == groups[1], longest == 1);
        }
    }
}
