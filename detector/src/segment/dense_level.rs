//! The dense cells below the foreground.

use crate::grid::hierarchical_grid::HierarchicalGrid;

/// The dense level of the grid, kept only where there is foreground.
///
/// *Blocks* are the coarse cells with foreground points, numbered by ascending cell; block b holds the dense cells
/// `b·ξ² .. (b+1)·ξ²`, row by row. Foreground points are reached from here by their index in the foreground list.
///
/// Paper: HG section 3.
#[derive(Debug, Clone, Default)]
pub struct DenseLevel {
    n_dense_per_block: usize,
    cell_of_block: Vec<u32>,
    // For every coarse cell.
    block_of_cell: Vec<u32>,
    // For every block.
    z_max_m: Vec<f32>,
    // For every dense cell.
    n_points: Vec<u32>,
    first_idx: Vec<u32>,
    // For every foreground point.
    dense_of_point: Vec<u32>,
}

/// Marks coarse cells without foreground.
pub const NO_BLOCK: u32 = u32::MAX;

impl DenseLevel {
    /// Replaces the content by the points `point_indices` of the scan in `grid`: the highest ones of `cells`, which are
    /// coarse cells in ascending order, each with at least one of these points.
    pub fn fill(&mut self, grid: &HierarchicalGrid, cells: &[u32], point_indices: &[u32]) {
        self.number_blocks(grid, cells);
        self.n_dense_per_block = (grid.params().xi * grid.params().xi) as usize;
        let n_dense = self.cell_of_block.len() * self.n_dense_per_block;
        self.n_points.clear();
        self.n_points.resize(n_dense, 0);
        self.first_idx.resize(n_dense, 0);
        self.dense_of_point.resize(point_indices.len(), 0);
        let (cell_of_point, dense_within) = (grid.cell_of_point(), grid.dense_within_of_point());
        let block_of_cell = &self.block_of_cell[..];
        let (n_points, first_idx) = (&mut self.n_points[..], &mut self.first_idx[..n_dense]);
        // Backward, so that the first index is written last.
        let indices = (0..point_indices.len() as u32).rev();
        let points = point_indices.iter().rev().zip(self.dense_of_point.iter_mut().rev());
        for (index, (&point_idx, dense_of_point)) in indices.zip(points) {
            let point_idx = point_idx as usize;
            let block_idx = block_of_cell[cell_of_point[point_idx] as usize] as usize;
            let dense_idx = block_idx * self.n_dense_per_block + usize::from(dense_within[point_idx]);
            *dense_of_point = dense_idx as u32;
            n_points[dense_idx] += 1;
            first_idx[dense_idx] = index;
        }
    }

    fn number_blocks(&mut self, grid: &HierarchicalGrid, cells: &[u32]) {
        self.block_of_cell.resize(grid.cells().len(), NO_BLOCK);
        for &cell_idx in &self.cell_of_block {
            self.block_of_cell[cell_idx as usize] = NO_BLOCK;
        }
        self.cell_of_block.clear();
        self.cell_of_block.extend_from_slice(cells);
        self.z_max_m.clear();
        for (&cell_idx, block_idx) in cells.iter().zip(0..) {
            self.block_of_cell[cell_idx as usize] = block_idx;
            self.z_max_m.push(grid.cells()[cell_idx as usize].z_max_m);
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

    /// The index in the foreground list of the first point of dense cell `dense_idx`, which must not be empty.
    pub fn first_idx(&self, dense_idx: usize) -> u32 {
        self.first_idx[dense_idx]
    }

    /// The dense cell of each foreground point, in the order of the foreground list.
    pub fn dense_of_point(&self) -> &[u32] {
        &self.dense_of_point
    }
}
