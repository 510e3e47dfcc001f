//! Statistics of the candidates over each dense cell.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::Candidates;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;
use crate::vector_instructions::{greater, lesser};

/// Heights above the ground that points are counted above, in metres: a car's bumper, bonnet and windows end at the first
/// three, more or less, and people at the last.
pub const LEVELS_M: [f32; 4] = [0.5, 1.1, 1.4, 2.0];

/// The candidates over a dense cell, or over many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellStatistics {
    /// Number of points.
    pub n_points: u32,
    /// The corners of the rectangle around them on the ground plan, in metres.
    pub low_m: [f32; 2],
    /// The other corner.
    pub high_m: [f32; 2],
    /// Lowest and highest point in metres.
    pub z_range_m: [f32; 2],
    /// Sum of the heights above the ground in metres.
    pub height_sum_m: f32,
    /// Sum of their squares.
    pub height_squares_m2: f32,
    /// Points above each of [`LEVELS_M`].
    pub n_above: [u32; 4],
}

impl CellStatistics {
    /// No points.
    pub const EMPTY: Self = Self {
        n_points: 0,
        low_m: [f32::INFINITY; 2],
        high_m: [f32::NEG_INFINITY; 2],
        z_range_m: [f32::INFINITY, f32::NEG_INFINITY],
        height_sum_m: 0.0,
        height_squares_m2: 0.0,
        n_above: [0; 4],
    };

    #[inline(always)]
    fn add(&mut self, [x_m, y_m, z_m]: [f32; 3], ground_m: f32) {
        let height_m = z_m - ground_m;
        self.n_points += 1;
        self.low_m = [lesser(x_m, self.low_m[0]), lesser(y_m, self.low_m[1])];
        self.high_m = [greater(x_m, self.high_m[0]), greater(y_m, self.high_m[1])];
        self.z_range_m = [lesser(z_m, self.z_range_m[0]), greater(z_m, self.z_range_m[1])];
        self.height_sum_m += height_m;
        self.height_squares_m2 += height_m * height_m;
        for (n_above, level_m) in self.n_above.iter_mut().zip(LEVELS_M) {
            *n_above += u32::from(height_m > level_m);
        }
    }

    /// Adds the candidates of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.n_points += other.n_points;
        for axis in 0..2 {
            self.low_m[axis] = lesser(other.low_m[axis], self.low_m[axis]);
            self.high_m[axis] = greater(other.high_m[axis], self.high_m[axis]);
        }
        let [low_m, high_m] = other.z_range_m;
        self.z_range_m = [lesser(low_m, self.z_range_m[0]), greater(high_m, self.z_range_m[1])];
        self.height_sum_m += other.height_sum_m;
        self.height_squares_m2 += other.height_squares_m2;
        for (n_above, other) in self.n_above.iter_mut().zip(other.n_above) {
            *n_above += other;
        }
    }

    /// The middle of the rectangle, in metres.
    pub fn middle_m(&self) -> [f32; 2] {
        [0, 1].map(|axis| 0.5 * (self.low_m[axis] + self.high_m[axis]))
    }

    /// The corners of the rectangle, in metres.
    pub fn corners_m(&self) -> [[f32; 2]; 4] {
        let ([left, low], [right, high]) = (self.low_m, self.high_m);
        [[left, low], [right, low], [right, high], [left, high]]
    }
}

/// The dense level over the candidates of a scan.
///
/// *Blocks* are the coarse cells with candidates, by ascending cell; block b holds the dense cells `b·ξ² .. (b+1)·ξ²`, row
/// by row. Behind those of all blocks come cells for further parts over a dense cell.
///
/// Paper: HG section 3.
#[derive(Debug, Clone, Default)]
pub struct DenseCells {
    n_per_block: usize,
    cell_of_block: Vec<u32>,
    // For every coarse cell.
    block_of_cell: Vec<u32>,
    // For every block, in metres.
    ground_m: Vec<f32>,
    statistics: Vec<CellStatistics>,
    // For every candidate.
    dense_of_point: Vec<u32>,
    // For the cells behind those of the blocks.
    block_of_other: Vec<u32>,
    // Which part each cell holds, and the next cell at the same position.
    part_of_dense: Vec<u32>,
    next_at_position: Vec<u32>,
}

const NO_BLOCK: u32 = u32::MAX;
const NOTHING: u32 = u32::MAX;

impl DenseCells {
    /// Replaces the content by the candidates of `cloud`.
    pub fn fill(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        candidates: &Candidates,
    ) {
        self.clear(grid, terrain, candidates);
        let (cell_of_point, within_of_point) = (grid.cell_of_point(), grid.dense_within_of_point());
        for &point_idx in candidates.point_indices() {
            let point_idx = point_idx as usize;
            let block_idx = self.block_of_cell[cell_of_point[point_idx] as usize] as usize;
            let dense_idx = block_idx * self.n_per_block + usize::from(within_of_point[point_idx]);
            self.statistics[dense_idx].add(cloud.position_m(point_idx), self.ground_m[block_idx]);
            self.dense_of_point.push(dense_idx as u32);
        }
    }

    /// As [`Self::fill`], but candidates of different parts are in different cells, even over the same position:
    /// `part_of_candidate` holds the part of each candidate, in their order.
    pub fn fill_apart(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        candidates: &Candidates,
        part_of_candidate: &[u32],
    ) {
        self.clear(grid, terrain, candidates);
        for cells in [&mut self.part_of_dense, &mut self.next_at_position] {
            cells.clear();
            cells.resize(self.statistics.len(), NOTHING);
        }
        let (cell_of_point, within_of_point) = (grid.cell_of_point(), grid.dense_within_of_point());
        for (&point_idx, &part) in candidates.point_indices().iter().zip(part_of_candidate) {
            let point_idx = point_idx as usize;
            let block_idx = self.block_of_cell[cell_of_point[point_idx] as usize];
            let index = block_idx as usize * self.n_per_block + usize::from(within_of_point[point_idx]);
            let dense_idx = self.cell_of_part(index, block_idx, part);
            self.statistics[dense_idx].add(cloud.position_m(point_idx), self.ground_m[block_idx as usize]);
            self.dense_of_point.push(dense_idx as u32);
        }
    }

    /// The cell that holds a part at a position: that of the position, or one behind those of the blocks.
    fn cell_of_part(&mut self, index: usize, block_idx: u32, part: u32) -> usize {
        let mut dense_idx = index;
        loop {
            if [NOTHING, part].contains(&self.part_of_dense[dense_idx]) {
                self.part_of_dense[dense_idx] = part;
                return dense_idx;
            }
            if self.next_at_position[dense_idx] == NOTHING {
                self.next_at_position[dense_idx] = self.statistics.len() as u32;
                self.statistics.push(CellStatistics::EMPTY);
                self.block_of_other.push(block_idx);
                self.part_of_dense.push(NOTHING);
                self.next_at_position.push(NOTHING);
            }
            dense_idx = self.next_at_position[dense_idx] as usize;
        }
    }

    fn clear(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, candidates: &Candidates) {
        self.block_of_cell.resize(grid.cells().len(), NO_BLOCK);
        self.cell_of_block.clear();
        self.cell_of_block.extend_from_slice(candidates.cells());
        self.ground_m.clear();
        for (&cell_idx, block_idx) in self.cell_of_block.iter().zip(0..) {
            self.block_of_cell[cell_idx as usize] = block_idx;
            self.ground_m.push(terrain.elevation_m(grid.column_and_row(cell_idx)));
        }
        self.n_per_block = (grid.params().xi * grid.params().xi) as usize;
        self.statistics.clear();
        self.statistics.resize(self.cell_of_block.len() * self.n_per_block, CellStatistics::EMPTY);
        self.dense_of_point.clear();
        self.block_of_other.clear();
    }

    /// The coarse cell of each block, ascending.
    pub fn cell_of_block(&self) -> &[u32] {
        &self.cell_of_block
    }

    /// Statistics of each dense cell, those without candidates included.
    pub fn statistics(&self) -> &[CellStatistics] {
        &self.statistics
    }

    /// Statistics of the dense cells of one block.
    pub fn statistics_of_block(&self, block_idx: usize) -> &[CellStatistics] {
        &self.statistics[block_idx * self.n_per_block..][..self.n_per_block]
    }

    /// The block of a dense cell.
    pub fn block_of_dense(&self, dense_idx: u32) -> usize {
        let other = (dense_idx as usize).checked_sub(self.cell_of_block.len() * self.n_per_block);
        other.map_or(dense_idx as usize / self.n_per_block, |it| self.block_of_other[it] as usize)
    }

    /// The dense cell of every candidate, in scan order.
    pub fn dense_of_point(&self) -> &[u32] {
        &self.dense_of_point
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::group::drawn_trees::{DrawnGroups, corner_m, groups_over};

    #[test]
    fn statistics_are_of_what_stands_over_a_cell() {
        let DrawnGroups { dense, grid, .. } = groups_over(&[[3, 1]]);
        let [x_m, y_m] = corner_m([3, 1]).map(|it| it + 0.1);
        let mut occupied = dense.statistics().iter().zip(0..).filter(|(it, _)| it.n_points > 0);
        let (statistics, dense_idx) = occupied.next().unwrap();
        assert_eq!(occupied.next(), None);
        assert_eq!((statistics.n_points, statistics.low_m, statistics.high_m), (16, [x_m, y_m], [x_m, y_m]));
        assert_eq!(statistics.z_range_m, [4.0 * 0.05 - 1.5, 19.0 * 0.05 - 1.5]);
        // The road is 1.73 m below the sensor: heights are 0.43, 0.48 … 1.18 m.
        assert_eq!(statistics.n_above, [14, 2, 0, 0]);
        let heights_m = || (4..20_u8).map(|it| 0.23 + 0.05 * f32::from(it));
        assert!((statistics.height_sum_m - heights_m().sum::<f32>()).abs() < 1e-3, "{statistics:?}");
        let squares_m2: f32 = heights_m().map(|it| it * it).sum();
        assert!((statistics.height_squares_m2 - squares_m2).abs() < 1e-3, "{statistics:?}");
        // The block is the coarse cell, and the cell is where it lies in it, row by row.
        let cell_idx = dense.cell_of_block()[dense.block_of_dense(dense_idx)];
        let corner_of_block_m = grid.center_m(cell_idx).map(|it| it - 0.3);
        let [across, along] =
            [x_m - corner_of_block_m[0], y_m - corner_of_block_m[1]].map(|it| (it / 0.2) as u32);
        assert_eq!(dense_idx % 9, 3 * along + across);
    }

    #[test]
    fn nothing_stays_of_the_scan_before() {
        let (mut first, second) = (groups_over(&[[0, 0], [9, 9]]), groups_over(&[[4, 0], [5, 0]]));
        first.dense.fill(&second.cloud, &second.grid, &second.terrain, &second.candidates);
        assert_eq!(first.dense.statistics(), second.dense.statistics());
        assert_eq!(first.dense.cell_of_block(), second.dense.cell_of_block());
        assert_eq!(first.dense.dense_of_point(), second.dense.dense_of_point());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_candidate_is_counted_in_its_cell(
            steps in prop::collection::btree_set((0_u8..25, 0_u8..12), 1..30),
        ) {
            let steps: Vec<[u8; 2]> = steps.into_iter().map(<[u8; 2]>::from).collect();
            let DrawnGroups { dense, grid, candidates, cloud, .. } = groups_over(&steps);
            prop_assert_eq!(candidates.point_indices().len(), dense.dense_of_point().len());
            let mut n_points = vec![0; dense.statistics().len()];
            for (&point_idx, &dense_idx) in candidates.point_indices().iter().zip(dense.dense_of_point()) {
                let block_idx = dense.block_of_dense(dense_idx);
                prop_assert_eq!(dense.cell_of_block()[block_idx], grid.cell_of_point()[point_idx as usize]);
                let statistics = dense.statistics()[dense_idx as usize];
                let [x_m, y_m, z_m] = cloud.position_m(point_idx as usize);
                for (at_m, [low_m, high_m]) in [
                    (x_m, [statistics.low_m[0], statistics.high_m[0]]),
                    (y_m, [statistics.low_m[1], statistics.high_m[1]]),
                    (z_m, statistics.z_range_m),
                ] {
                    prop_assert!((low_m..=high_m).contains(&at_m), "{at_m} is not in {statistics:?}");
                }
                n_points[dense_idx as usize] += 1;
            }
            let n_in_cells: Vec<u32> = dense.statistics().iter().map(|it| it.n_points).collect();
            prop_assert_eq!(n_in_cells, n_points);
        }

        #[test]
        fn parts_over_one_position_are_in_cells_of_their_own(
            steps in prop::collection::btree_set((0_u8..8, 0_u8..4), 1..12),
            n_parts in 1_u32..4,
        ) {
            let steps: Vec<[u8; 2]> = steps.into_iter().map(<[u8; 2]>::from).collect();
            let DrawnGroups { mut dense, grid, terrain, candidates, cloud, .. } = groups_over(&steps);
            let as_one = dense.clone();
            let part_of = |index: usize| index as u32 % n_parts;
            let parts: Vec<u32> = (0..candidates.point_indices().len()).map(part_of).collect();
            dense.fill_apart(&cloud, &grid, &terrain, &candidates, &parts);
            let mut part_of_dense = vec![None; dense.statistics().len()];
            for ((&dense_idx, &part), &whole_idx) in dense.dense_of_point().iter().zip(&parts).zip(as_one.dense_of_point()) {
                let known = part_of_dense[dense_idx as usize].get_or_insert(part);
                prop_assert_eq!(*known, part);
                prop_assert_eq!(dense.block_of_dense(dense_idx), as_one.block_of_dense(whole_idx));
            }
            let n_points: u32 = dense.statistics().iter().map(|it| it.n_points).sum();
            prop_assert_eq!(n_points as usize, parts.len());
            // Each position has a cell of every part, since each of its 16 candidates' parts come in turn.
            let n_occupied = |it: &DenseCells| it.statistics().iter().filter(|it| it.n_points > 0).count();
            prop_assert_eq!(n_occupied(&dense), n_occupied(&as_one) * n_parts as usize);
            if n_parts == 1 {
                prop_assert_eq!(dense.statistics(), as_one.statistics());
            }
        }

        #[test]
        fn merged_statistics_are_those_of_all_points(
            points in prop::collection::vec((-9_i8..9, -9_i8..9, 0_i8..9), 1..20),
            split in 0_usize..20,
        ) {
            // Halves of a metre, of which sums are exact.
            let points = points.into_iter().map(|(x, y, z)| [x, y, z].map(|it| f32::from(it) * 0.5));
            let points: Vec<[f32; 3]> = points.collect();
            let statistics_of = |points: &[[f32; 3]]| {
                let mut statistics = CellStatistics::EMPTY;
                for it in points {
                    statistics.add(*it, -1.5);
                }
                statistics
            };
            let (left, right) = points.split_at(split.min(points.len()));
            let mut merged = statistics_of(left);
            merged.merge(&statistics_of(right));
            prop_assert_eq!(merged, statistics_of(&points));
        }
    }
}
