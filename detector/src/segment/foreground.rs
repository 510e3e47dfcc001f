//! The points that may belong to objects.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;
use crate::surface_class::SurfaceClass;

/// Tuning of [`Foreground::extract`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForegroundParams {
    /// Points of a foreground cell that are no higher than this above the lowest ground of the cell are road, in metres.
    pub clearance_m: f32,
    /// The lowest point of a cell is its ground if it lies within this of the terrain, in metres: kerbs, pavements, gutters.
    /// A higher one counts as this far above the terrain. A lower one is a mirror image, and the terrain is the ground.
    pub ground_band_m: f32,
}

impl ForegroundParams {
    /// Elevation of the upper end of a cell's ground, in metres: higher points stand clear of it.
    pub fn ground_top_m(&self, grid: &HierarchicalGrid, terrain: &Terrain, cell_idx: u32) -> f32 {
        let terrain_m = terrain.elevation_m(grid.column_and_row(cell_idx));
        let lowest_m = grid.cells()[cell_idx as usize].z_min_m;
        let is_mirror_image = lowest_m < terrain_m - self.ground_band_m;
        let ground_m = if is_mirror_image { terrain_m } else { lowest_m.min(terrain_m + self.ground_band_m) };
        ground_m + self.clearance_m
    }
}

/// The points of short-object cells that stand clear of the ground.
///
/// The paper takes all points of the foreground cells; those of the road around an object's feet would tie it to its
/// neighbours and spoil its outline, so they are left out here. `clearance_m = -inf` gives the paper's reading.
#[derive(Debug, Clone)]
pub struct Foreground {
    params: ForegroundParams,
    // Elevation above which a point counts, infinite where none does; of an earlier scan for cells that are not occupied.
    cut_m: Vec<f32>,
    cells: Vec<u32>,
    // With room for every point of the scan, so that writing needs no branch.
    point_indices: Vec<u32>,
    n_points: usize,
}

impl Foreground {
    /// No points yet.
    pub fn new(params: ForegroundParams) -> Self {
        Self { params, cut_m: Vec::new(), cells: Vec::new(), point_indices: Vec::new(), n_points: 0 }
    }

    /// Replaces the content by the foreground of `cloud`, which `grid` holds and `classes` classifies.
    ///
    /// Paper: HG section 3.2, first paragraph.
    pub fn extract(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        classes: &[SurfaceClass],
        terrain: &Terrain,
    ) {
        self.cut_m.resize(classes.len(), f32::INFINITY);
        self.cells.clear();
        for &cell_idx in grid.occupied() {
            let cut_m = match classes[cell_idx as usize] {
                SurfaceClass::Short => self.params.ground_top_m(grid, terrain, cell_idx),
                _ => f32::INFINITY,
            };
            self.cut_m[cell_idx as usize] = cut_m;
            if grid.cells()[cell_idx as usize].z_max_m > cut_m {
                self.cells.push(cell_idx);
            }
        }
        self.point_indices.resize(self.point_indices.len().max(cloud.len()), 0);
        let mut n_points = 0;
        for ((&cell_idx, &z_m), point_idx) in grid.cell_of_point().iter().zip(cloud.z_m()).zip(0..) {
            let cut_m = self.cut_m.get(cell_idx as usize).copied().unwrap_or(f32::INFINITY);
            self.point_indices[n_points] = point_idx;
            n_points += usize::from(z_m > cut_m);
        }
        self.n_points = n_points;
    }

    /// Replaces the cells by others, ascending, that were found in another way.
    pub fn set_cells(&mut self, cells: impl Iterator<Item = u32>) {
        self.cells.clear();
        self.cells.extend(cells);
    }

    /// Replaces the points by others, ascending.
    pub fn set_points(&mut self, point_indices: impl Iterator<Item = u32>) {
        self.point_indices.clear();
        self.point_indices.extend(point_indices);
        self.n_points = self.point_indices.len();
    }

    /// The parameters: which points stand clear of the ground.
    pub fn params(&self) -> &ForegroundParams {
        &self.params
    }

    /// The coarse cells that hold foreground points, ascending.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Indices of the foreground points in the scan, ascending.
    pub fn point_indices(&self) -> &[u32] {
        &self.point_indices[..self.n_points]
    }
}
