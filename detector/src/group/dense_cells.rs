//! What there is over each dense cell.

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
pub struct Heap {
    /// How many points.
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

impl Heap {
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

    /// Adds all of another one.
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
/// by row.
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
    heaps: Vec<Heap>,
    // For every candidate.
    dense_of_point: Vec<u32>,
}

const NO_BLOCK: u32 = u32::MAX;

impl DenseCells {
    /// Replaces the content by the candidates of `cloud`.
    pub fn fill(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        candidates: &Candidates,
    ) {
        self.block_of_cell.resize(grid.cells().len(), NO_BLOCK);
        self.cell_of_block.clear();
        self.cell_of_block.extend_from_slice(candidates.cells());
        self.ground_m.clear();
        for (&cell_idx, block_idx) in self.cell_of_block.iter().zip(0..) {
            self.block_of_cell[cell_idx as usize] = block_idx;
            self.ground_m.push(terrain.elevation_m(grid.column_and_row(cell_idx)));
        }
        self.n_per_block = (grid.params().xi * grid.params().xi) as usize;
        self.heaps.clear();
        self.heaps.resize(self.cell_of_block.len() * self.n_per_block, Heap::EMPTY);
        self.dense_of_point.clear();
        let (cell_of_point, within_of_point) = (grid.cell_of_point(), grid.dense_within_of_point());
        for &point_idx in candidates.point_indices() {
            let point_idx = point_idx as usize;
            let block_idx = self.block_of_cell[cell_of_point[point_idx] as usize] as usize;
            let dense_idx = block_idx * self.n_per_block + usize::from(within_of_point[point_idx]);
            self.heaps[dense_idx].add(cloud.position_m(point_idx), self.ground_m[block_idx]);
            self.dense_of_point.push(dense_idx as u32);
        }
    }

    /// The coarse cell of each block, ascending.
    pub fn cell_of_block(&self) -> &[u32] {
        &self.cell_of_block
    }

    /// What there is over each dense cell, those without candidates included.
    pub fn heaps(&self) -> &[Heap] {
        &self.heaps
    }

    /// The same of one block.
    pub fn heaps_of_block(&self, block_idx: usize) -> &[Heap] {
        &self.heaps[block_idx * self.n_per_block..][..self.n_per_block]
    }

    /// The block of a dense cell.
    pub fn block_of_dense(&self, dense_idx: u32) -> usize {
        dense_idx as usize / self.n_per_block
    }

    /// The dense cell of every candidate, in scan order.
    pub fn dense_of_point(&self) -> &[u32] {
        &self.dense_of_point
    }
}
