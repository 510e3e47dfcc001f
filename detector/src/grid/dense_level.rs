//! The dense cells below the foreground.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::point_cloud::PointCloud;

/// The dense level of the grid, kept only where there is foreground.
///
/// *Blocks* are the coarse cells with foreground points, numbered by ascending cell; block b holds the dense cells
/// `b·ξ² .. (b+1)·ξ²`, row by row. Foreground points are reached from here by their place in the foreground list.
///
/// Paper: HG section 3.
#[derive(Debug, Clone, Default)]
pub struct DenseLevel {
    n_dense_per_block: usize,
    cell_of_block: Vec<u32>,
    // For every coarse cell.
    block_of_cell: Vec<u32>,
    z_max_m: Vec<f32>,
    n_points: Vec<u32>,
    // For every foreground point.
    dense_of_point: Vec<u32>,
}

/// Marks coarse cells without foreground.
pub const NO_BLOCK: u32 = u32::MAX;

impl DenseLevel {
    /// Replaces the content by the points `point_indices` of `cloud`, which `grid` holds.
    pub fn fill(&mut self, cloud: &PointCloud, grid: &HierarchicalGrid, point_indices: &[u32]) {
        self.number_blocks(grid, point_indices);
        self.n_dense_per_block = (grid.params().xi * grid.params().xi) as usize;
        self.z_max_m.clear();
        self.z_max_m.resize(self.cell_of_block.len(), f32::NEG_INFINITY);
        self.n_points.clear();
        self.n_points.resize(self.cell_of_block.len() * self.n_dense_per_block, 0);
        self.dense_of_point.clear();
        for &point_idx in point_indices {
            let [x_m, y_m, z_m] = cloud.position_m(point_idx as usize);
            let cell_idx = grid.cell_of_point()[point_idx as usize];
            let block_idx = self.block_of_cell[cell_idx as usize] as usize;
            let dense_idx =
                block_idx * self.n_dense_per_block + grid.dense_cell_within(cell_idx, x_m, y_m) as usize;
            self.z_max_m[block_idx] = self.z_max_m[block_idx].max(z_m);
            self.n_points[dense_idx] += 1;
            self.dense_of_point.push(dense_idx as u32);
        }
    }

    fn number_blocks(&mut self, grid: &HierarchicalGrid, point_indices: &[u32]) {
        self.block_of_cell.resize(grid.cells().len(), NO_BLOCK);
        for &cell_idx in &self.cell_of_block {
            self.block_of_cell[cell_idx as usize] = NO_BLOCK;
        }
        self.cell_of_block.clear();
        for &point_idx in point_indices {
            let cell_idx = grid.cell_of_point()[point_idx as usize];
            let block_idx = &mut self.block_of_cell[cell_idx as usize];
            if *block_idx == NO_BLOCK {
                *block_idx = 0;
                self.cell_of_block.push(cell_idx);
            }
        }
        self.cell_of_block.sort_unstable();
        for (&cell_idx, block_idx) in self.cell_of_block.iter().zip(0..) {
            self.block_of_cell[cell_idx as usize] = block_idx;
        }
    }

    /// Number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.cell_of_block.len()
    }

    /// Dense cells in a block, ξ².
    pub fn n_dense_per_block(&self) -> usize {
        self.n_dense_per_block
    }

    /// The coarse cell of each block, ascending.
    pub fn cell_of_block(&self) -> &[u32] {
        &self.cell_of_block
    }

    /// The block of coarse cell `cell_idx`, or [`NO_BLOCK`].
    pub fn block_of_cell(&self, cell_idx: u32) -> u32 {
        self.block_of_cell[cell_idx as usize]
    }

    /// Highest foreground point of a block in metres.
    pub fn z_max_m(&self, block_idx: u32) -> f32 {
        self.z_max_m[block_idx as usize]
    }

    /// Foreground points in each dense cell of block `block_idx`.
    pub fn n_points_of_block(&self, block_idx: u32) -> &[u32] {
        let first = block_idx as usize * self.n_dense_per_block;
        &self.n_points[first..first + self.n_dense_per_block]
    }

    /// Foreground points in each dense cell of all blocks.
    pub fn n_points(&self) -> &[u32] {
        &self.n_points
    }

    /// The dense cell of each foreground point, in the order of the foreground list.
    pub fn dense_of_point(&self) -> &[u32] {
        &self.dense_of_point
    }
}
