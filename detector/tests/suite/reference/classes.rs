//! Clutter, ground, tall and short cells (HG sections 3.1 and 4).

use std::collections::BTreeMap;

use detector::params::front_end::FrontEndParams;
use detector::segment::ground_segmentation::HeightOver;
use detector::surface_class::SurfaceClass;

use super::cells::{Cell, CellPoints};
use super::density::points_per_cell;
use super::terrain::Terrain;

pub fn cell_classes(
    cells: &BTreeMap<Cell, CellPoints>,
    terrain: &Terrain,
    params: &FrontEndParams,
    sensor_height_m: f32,
) -> BTreeMap<Cell, SurfaceClass> {
    let class_of = |(&cell, points): (&Cell, &CellPoints)| {
        let terrain_m = terrain.elevation_m(cell);
        let height_m = points.z_max_m() - terrain_m;
        let expected = points_per_cell(cell, params.grid.cell_size_m, params).ceil();
        let params = &params.ground;
        let most = params.min_points as f32;
        let least = if params.fewer_far_away { expected.clamp(1.0, most) } else { most };
        let tall_m = match params.tall_over {
            HeightOver::Terrain => height_m,
            HeightOver::LevelRoad => points.z_max_m() - -sensor_height_m,
        };
        let is_flat = points.z_extent_m() < params.max_ground_extent_m;
        let is_near_terrain = || (neighborhood_mean_m(cells, cell) - terrain_m).abs() <= params.ground_band_m;
        let is_low = !params.low_itself || height_m <= params.ground_band_m;
        let class = if (points.point_indices.len() as f32) < least {
            SurfaceClass::Clutter
        } else if is_flat && is_low && is_near_terrain() {
            SurfaceClass::Ground
        } else if tall_m > params.tall_height_m || points.z_extent_m() > params.tall_height_m {
            SurfaceClass::Tall
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
