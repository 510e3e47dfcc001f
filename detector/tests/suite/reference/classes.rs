//! Clutter, ground, tall and short cells (HG sections 3.1 and 4).

use std::collections::BTreeMap;

use detector::params::HierarchicalParams;
use detector::surface_class::SurfaceClass;

use super::cells::{Cell, CellPoints};
use super::density::points_per_cell;
use super::terrain::Terrain;

pub fn cell_classes(
    cells: &BTreeMap<Cell, CellPoints>,
    terrain: &Terrain,
    params: &HierarchicalParams,
) -> BTreeMap<Cell, SurfaceClass> {
    let class_of = |(&cell, points): (&Cell, &CellPoints)| {
        let terrain_m = terrain.elevation_m(cell);
        let height_m = points.z_max_m() - terrain_m;
        let expected = points_per_cell(cell, params.grid.cell_size_m, params).ceil();
        let params = &params.ground;
        let least = expected.clamp(1.0, params.min_points as f32);
        let class = if (points.point_indices.len() as f32) < least {
            SurfaceClass::Clutter
        } else if height_m > params.tall_height_m || points.z_extent_m() > params.tall_height_m {
            SurfaceClass::Tall
        } else if points.z_extent_m() < params.max_ground_extent_m
            && height_m <= params.ground_band_m
            && (neighborhood_mean_m(cells, cell) - terrain_m).abs() <= params.ground_band_m
        {
            SurfaceClass::Ground
        } else {
            SurfaceClass::Short
        };
        (cell, class)
    };
    cells.iter().map(class_of).collect()
}

/// Mean of the mean elevations of the occupied cells around.
fn neighborhood_mean_m(cells: &BTreeMap<Cell, CellPoints>, cell: Cell) -> f32 {
    let means_m: Vec<f32> =
        cell.neighborhood().filter_map(|it| cells.get(&it)).map(CellPoints::z_mean_m).collect();
    means_m.iter().fold(0.0, |sum_m, mean_m| sum_m + mean_m) / means_m.len() as f32
}
