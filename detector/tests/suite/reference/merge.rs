//! Neighbouring cells of similar height (HG section 3.2).

use detector::PointCloud;
use detector::segment::connected_components::ConnectedComponentsParams;

use super::cells::Cell;
use super::foreground::Foreground;

/// Pairs of neighbours that belong together, the earlier cell first.
pub fn links(
    cloud: &PointCloud,
    foreground: &Foreground,
    params: &ConnectedComponentsParams,
) -> Vec<[Cell; 2]> {
    let z_max_m = |cell: Cell| {
        let z_m = foreground[&cell].iter().map(|&point_idx| cloud.z_m()[point_idx as usize]);
        z_m.fold(f32::NEG_INFINITY, f32::max)
    };
    let pairs = foreground.keys().flat_map(|&cell| cell.neighborhood().map(move |it| [cell, it]));
    pairs
        .filter(|[cell, neighbor]| neighbor > cell && foreground.contains_key(neighbor))
        .filter(|&[cell, neighbor]| {
            (z_max_m(cell) - z_max_m(neighbor)).abs() < params.max_height_difference_m
        })
        .collect()
}
