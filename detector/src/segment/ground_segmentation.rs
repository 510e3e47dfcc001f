//! Which cells are ground, which are tall, and which are the street's objects.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::terrain::Terrain;
use crate::stage_product::SurfaceClass;

/// Tuning of [`segment_ground`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundSegmentationParams {
    /// Cells with fewer points are clutter; the paper has 4 to 8.
    pub min_points: u32,
    /// Highest minus lowest point of a ground cell stays below this, in metres.
    pub max_ground_extent_m: f32,
    /// The mean elevation around a ground cell is within this of the terrain, in metres.
    pub ground_band_m: f32,
    /// A cell that reaches higher above the ground, or spans more, is tall; in metres.
    pub tall_height_m: f32,
}

/// Writes the class of every cell of `grid` to `classes`, which has one entry a cell; empty cells are unseen.
///
/// The paper calls a cell tall above 1.40 m over the sensor or when it spans 3.10 m. With its sensor at 1.73 m both
/// are 3.1 m over a level road; we take 3.10 m over the *terrain* for both, so that a climbing road does not turn
/// its cars into walls.
///
/// Paper: HG section 3.1.
pub fn segment_ground(
    grid: &HierarchicalGrid,
    terrain: &Terrain,
    params: &GroundSegmentationParams,
    classes: &mut Vec<SurfaceClass>,
) {
    classes.clear();
    classes.resize(grid.cells().len(), SurfaceClass::Unseen);
    for &cell_idx in grid.occupied() {
        classes[cell_idx as usize] = class_of(grid, terrain, params, cell_idx);
    }
}

fn class_of(
    grid: &HierarchicalGrid,
    terrain: &Terrain,
    params: &GroundSegmentationParams,
    cell_idx: u32,
) -> SurfaceClass {
    let cell = &grid.cells()[cell_idx as usize];
    if cell.n_points < params.min_points {
        return SurfaceClass::Clutter;
    }
    let terrain_m = terrain.elevation_m(grid.column_and_row(cell_idx));
    if cell.z_max_m - terrain_m > params.tall_height_m || cell.z_extent_m() > params.tall_height_m {
        return SurfaceClass::Tall;
    }
    let flat = cell.z_extent_m() < params.max_ground_extent_m;
    if flat && (neighborhood_mean_m(grid, cell_idx) - terrain_m).abs() <= params.ground_band_m {
        SurfaceClass::Ground
    } else {
        SurfaceClass::Short
    }
}

/// Mean over the occupied cells of the neighbourhood of their mean elevations.
fn neighborhood_mean_m(grid: &HierarchicalGrid, cell_idx: u32) -> f32 {
    let mut sum_m = 0.0;
    let mut n_occupied = 0.0;
    for neighbor_idx in grid.neighborhood(cell_idx) {
        let cell = &grid.cells()[neighbor_idx as usize];
        if cell.n_points > 0 {
            sum_m += cell.z_mean_m();
            n_occupied += 1.0;
        }
    }
    sum_m / n_occupied
}
