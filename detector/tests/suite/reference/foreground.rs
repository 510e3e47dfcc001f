//! The points of short cells that stand clear of the ground (HG section 3.2).

use std::collections::BTreeMap;

use detector::PointCloud;
use detector::segment::foreground::ForegroundParams;
use detector::surface_class::SurfaceClass;

use super::cells::{Cell, CellPoints};
use super::terrain::Terrain;

/// The foreground points of every coarse cell that has any, ascending.
pub type Foreground = BTreeMap<Cell, Vec<u32>>;

pub fn foreground(
    cloud: &PointCloud,
    cells: &BTreeMap<Cell, CellPoints>,
    classes: &BTreeMap<Cell, SurfaceClass>,
    terrain: &Terrain,
    params: &ForegroundParams,
) -> Foreground {
    let mut foreground = Foreground::new();
    for (&cell, points) in cells.iter().filter(|(cell, _)| classes[cell] == SurfaceClass::Short) {
        let terrain_m = terrain.elevation_m(cell);
        // What lies far below the terrain was seen in a mirror.
        let ground_m = match points.z_min_m() - terrain_m {
            above_m if above_m > params.ground_band_m => terrain_m + params.ground_band_m,
            above_m if above_m < -params.ground_band_m => terrain_m,
            _ => points.z_min_m(),
        };
        let is_clear = |&&point_idx: &&u32| cloud.z_m()[point_idx as usize] > ground_m + params.clearance_m;
        let clear: Vec<u32> = points.point_indices.iter().filter(is_clear).copied().collect();
        if !clear.is_empty() {
            foreground.insert(cell, clear);
        }
    }
    foreground
}

/// The class of every point: that of its cell, but ground below the foreground of short cells.
pub fn point_classes(
    n_points: usize,
    cells: &BTreeMap<Cell, CellPoints>,
    classes: &BTreeMap<Cell, SurfaceClass>,
    foreground: &Foreground,
) -> Vec<SurfaceClass> {
    let mut point_classes = vec![SurfaceClass::Unseen; n_points];
    for (cell, points) in cells {
        let class = match classes[cell] {
            SurfaceClass::Short => SurfaceClass::Ground,
            class => class,
        };
        for &point_idx in &points.point_indices {
            point_classes[point_idx as usize] = class;
        }
    }
    for &point_idx in foreground.values().flatten() {
        point_classes[point_idx as usize] = SurfaceClass::Short;
    }
    point_classes
}
