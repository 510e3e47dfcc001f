//! The points that may belong to objects.

use serde::Deserialize;

use crate::grid::hierarchical_grid::{HierarchicalGrid, NO_CELL};
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;
use crate::stage_product::SurfaceClass;

/// Tuning of [`Foreground::extract`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForegroundParams {
    /// Points of a foreground cell that are no higher than this above the lowest ground of the cell are road, in metres.
    pub clearance_m: f32,
    /// The lowest point of a cell counts as its ground up to this far above the terrain, in metres: kerbs and pavements.
    pub ground_band_m: f32,
}

/// The points of short-object cells that stand clear of the ground.
///
/// The paper takes all points of the foreground cells; those of the road around an object's feet would tie it to its
/// neighbours and spoil its outline, so they are left out here. `clearance_m = -inf` gives the paper's reading.
#[derive(Debug, Clone)]
pub struct Foreground {
    params: ForegroundParams,
    // Elevation above which a point counts, for every cell; infinite where none does.
    cut_m: Vec<f32>,
    point_indices: Vec<u32>,
}

impl Foreground {
    /// No points yet.
    pub fn new(params: ForegroundParams) -> Self {
        Self { params, cut_m: Vec::new(), point_indices: Vec::new() }
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
        self.cut_m.clear();
        self.cut_m.resize(classes.len(), f32::INFINITY);
        for &cell_idx in grid.occupied() {
            if classes[cell_idx as usize] == SurfaceClass::Short {
                let terrain_m = terrain.elevation_m(grid.column_and_row(cell_idx));
                let lowest_m = grid.cells()[cell_idx as usize].z_min_m;
                let band_m = self.params.ground_band_m;
                let ground_m = lowest_m.clamp(terrain_m - band_m, terrain_m + band_m);
                self.cut_m[cell_idx as usize] = ground_m + self.params.clearance_m;
            }
        }
        self.point_indices.clear();
        for ((&cell_idx, &z_m), point_idx) in grid.cell_of_point().iter().zip(cloud.z_m()).zip(0_u32..) {
            if cell_idx != NO_CELL && z_m > self.cut_m[cell_idx as usize] {
                self.point_indices.push(point_idx);
            }
        }
    }

    /// Indices of the foreground points in the scan, ascending.
    pub fn point_indices(&self) -> &[u32] {
        &self.point_indices
    }
}
