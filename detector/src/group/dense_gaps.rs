//! How far apart the dense cells of a scan are.

use serde::Deserialize;

use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::group::candidates::{Candidates, Evidence};
use crate::group::dense_cells::DenseCells;
use crate::group::linkage::{Linkage, LinkedScan, Links, N_LEVELS};
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

const NO_LABEL: u32 = u32::MAX;

/// Gaps between dense cells, in reusable buffers.
#[derive(Debug, Clone)]
pub struct DenseGaps {
    params: DenseGapsParams,
    xi: u32,
    // Dense cells along a side of the grid.
    n_along: usize,
    expected: ExpectedDensity,
    // For every dense cell of the grid: the dense cell that reached it first, and in how many steps.
    reached: Vec<Reached>,
    steps: Vec<u8>,
    // Positions that were reached, in this order.
    queue: Vec<u32>,
    // For every dense cell of a block: the block, which costs a division otherwise, its position in the grid, whether it
    // holds enough points, and its group.
    block: Vec<u32>,
    at: Vec<u32>,
    is_conducting: Vec<bool>,
    groups: DisjointSets,
    // For every block.
    resolved_steps: Vec<u32>,
    is_on_wall: Vec<bool>,
    links: Links,
}

/// The dense cell that reached a position first, and its group.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reached {
    label: u32,
    group: u32,
}

impl Reached {
    const NOTHING: Self = Self { label: NO_LABEL, group: NO_LABEL };
    /// The outermost cells, which hold no points and are never reached; their group is another one, so that they are not
    /// taken for free cells.
    const BORDER: Self = Self { label: NO_LABEL, group: NO_LABEL - 1 };
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
            steps: Vec::new(),
            queue: Vec::new(),
            block: Vec::new(),
            at: Vec::new(),
            is_conducting: Vec::new(),
            groups: DisjointSets::default(),
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
            self.queue.clear();
            self.steps = vec![0; n_along * n_along];
            let is_outermost = |step: usize| step == 0 || step == n_along - 1;
            let is_border = |index: usize| is_outermost(index % n_along) || is_outermost(index / n_along);
            let at_first = |index| if is_border(index) { Reached::BORDER } else { Reached::NOTHING };
            self.reached = (0..n_along * n_along).map(at_first).collect();
        }
        for index in self.queue.drain(..) {
            self.reached[index as usize] = Reached::NOTHING;
        }
        self.place_cells(grid, dense, candidates);
        self.join_touching(candidates);
        self.spread(candidates);
        // Near-empty cells belong to the nearest group.
        for (dense_idx, statistics) in dense.statistics().iter().enumerate() {
            if statistics.n_points > 0 && !self.is_conducting[dense_idx] {
                let reached = self.reached[self.at[dense_idx] as usize];
                self.links.group_of_dense[dense_idx] =
                    if reached == Reached::NOTHING { dense_idx as u32 } else { reached.group };
            }
        }
    }

    fn place_cells(&mut self, grid: &HierarchicalGrid, dense: &DenseCells, candidates: &Candidates) {
        let n_dense = dense.statistics().len();
        self.block.clear();
        self.at.clear();
        self.is_conducting.clear();
        self.resolved_steps.clear();
        self.is_on_wall.clear();
        for (block_idx, &cell_idx) in dense.cell_of_block().iter().enumerate() {
            let [column, row] = grid.column_and_row(cell_idx);
            let statistics = dense.statistics_of_block(block_idx);
            let n_occupied = statistics.iter().filter(|it| it.n_points > 0).count().max(1);
            let mean = statistics.iter().map(|it| it.n_points).sum::<u32>() as f32 / n_occupied as f32;
            let expected = self.expected.of_cell(grid, cell_idx);
            self.resolved_steps.push(expected.max_steps);
            self.is_on_wall.push(candidates.evidence_against(cell_idx).has(Evidence::OnWall));
            let least = (self.params.low_density_share * mean.min(expected.object_points)).max(1.0);
            let mut statistics = statistics.iter();
            for along in 0..self.xi {
                let start = (row * self.xi + along) as usize * self.n_along + (column * self.xi) as usize;
                for (index, statistics) in (start..start + self.xi as usize).zip(&mut statistics) {
                    self.block.push(block_idx as u32);
                    self.at.push(index as u32);
                    self.is_conducting.push(statistics.n_points as f32 >= least);
                }
            }
        }
        self.links.group_of_dense.clear();
        self.links.group_of_dense.extend(0..n_dense as u32);
        self.groups.reset(n_dense);
        for dense_idx in 0..n_dense {
            if self.is_conducting[dense_idx] {
                let index = self.at[dense_idx];
                self.reached[index as usize].label = dense_idx as u32;
                self.steps[index as usize] = 0;
                self.queue.push(index);
            }
        }
    }

    /// Joins neighbouring cells to one group, unless their height or a wall sets them apart.
    fn join_touching(&mut self, candidates: &Candidates) {
        self.links.between.iter_mut().for_each(Vec::clear);
        let n = self.n_along;
        for dense_idx in 0..self.at.len() as u32 {
            if !self.is_conducting[dense_idx as usize] {
                continue;
            }
            let index = self.at[dense_idx as usize] as usize;
            for neighbor in [index + 1, index + n - 1, index + n, index + n + 1] {
                let other = self.reached[neighbor].label;
                if other == NO_LABEL {
                    continue;
                }
                let level = self.level(candidates, [dense_idx, other], 1);
                if level == 0 {
                    self.groups.join(dense_idx, other);
                } else {
                    self.links.between[level].push([dense_idx, other]);
                }
            }
        }
        for dense_idx in 0..self.at.len() {
            if self.is_conducting[dense_idx] {
                let group = self.groups.representative(dense_idx as u32);
                self.links.group_of_dense[dense_idx] = group;
                self.reached[self.at[dense_idx] as usize].group = group;
            }
        }
        for between in self.links.between.iter_mut().flatten() {
            *between = between.map(|it| self.links.group_of_dense[it as usize]);
        }
    }

    /// Level of the gap between two dense cells that are `steps` apart.
    fn level(&self, candidates: &Candidates, between: [u32; 2], steps: u32) -> usize {
        let blocks = between.map(|it| self.block[it as usize] as usize);
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
        let n = self.n_along;
        let mut front = 0..self.queue.len();
        for round in 0..self.params.n_rounds as u8 {
            for at in front.clone() {
                let index = self.queue[at] as usize;
                let own = self.reached[index];
                for first in [index - n - 1, index - 1, index + n - 1] {
                    let three: [Reached; 3] = std::array::from_fn(|step| self.reached[first + step]);
                    for (other, neighbor) in three.into_iter().zip(first..) {
                        if other.group == own.group {
                            continue;
                        }
                        if other == Reached::NOTHING {
                            self.reached[neighbor] = own;
                            self.steps[neighbor] = round + 1;
                            self.queue.push(neighbor as u32);
                        } else {
                            self.meet(candidates, round, [(index, own), (neighbor, other)]);
                        }
                    }
                }
            }
            front = front.end..self.queue.len();
        }
    }

    /// Records that two groups meet at neighbouring positions, the first of which was reached in `own_steps`. If both were
    /// reached in as many steps, only the one with the lower number records it. Not inlined, so that the loop that calls it
    /// keeps its values in registers.
    #[inline(never)]
    fn meet(
        &mut self,
        candidates: &Candidates,
        own_steps: u8,
        [(index, own), (neighbor, other)]: [(usize, Reached); 2],
    ) {
        let other_steps = self.steps[neighbor];
        if other_steps > own_steps || (other_steps == own_steps && own_steps > 0 && neighbor > index) {
            let steps = u32::from(own_steps) + u32::from(other_steps) + 1;
            let level = self.level(candidates, [own.label, other.label], steps);
            self.links.between[level].push([own.group, other.group]);
        }
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

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]
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
