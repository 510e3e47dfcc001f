//! What lies in the box of an object and belongs to none.

use std::collections::{BTreeMap, BTreeSet};

use detector::params::HierarchicalParams;
use detector::{OrientedBox, PointCloud};

use super::cells::{Cell, CellPoints, coarse_cells};
use super::terrain::Terrain;

/// Gives objects the points in their boxes, and their boxes the height of these.
pub fn complete(
    cloud: &PointCloud,
    params: &HierarchicalParams,
    sensor_height_m: f32,
    objects: &mut [(Vec<u32>, OrientedBox)],
) {
    let cells: BTreeMap<Cell, CellPoints> = coarse_cells(cloud, &params.grid);
    let terrain = &Terrain::grown(&cells, &params.front_end(), sensor_height_m);
    let taken: BTreeSet<u32> = objects.iter().flat_map(|it| it.0.clone()).collect();
    let boxes: Vec<OrientedBox> = objects.iter().map(|it| it.1).collect();
    let mut free: Vec<u32> = cells.values().flat_map(|it| it.point_indices.clone()).collect();
    free.retain(|it| !taken.contains(it));
    free.sort_unstable();
    for point_idx in free {
        let position_m = cloud.position_m(point_idx as usize);
        let is_around = |it: &OrientedBox| is_in(it, ground_m(it, terrain, params), position_m, params);
        if let Some(object_idx) = boxes.iter().position(is_around) {
            let (point_indices, bounding_box) = &mut objects[object_idx];
            point_indices.push(point_idx);
            point_indices.sort_unstable();
            make_room(bounding_box, position_m[2]);
        }
    }
}

fn ground_m(it: &OrientedBox, terrain: &Terrain, params: &HierarchicalParams) -> f32 {
    let grid = &params.grid;
    let last = (2.0 * grid.extent_m / grid.cell_size_m) as i32 + 2;
    let step = |at_m: f32| (((at_m + grid.extent_m) / grid.cell_size_m + 1.0) as i32).clamp(0, last);
    terrain.elevation_m(Cell { column: step(it.center_m[0]), row: step(it.center_m[1]) })
}

fn is_in(it: &OrientedBox, ground_m: f32, position_m: [f32; 3], params: &HierarchicalParams) -> bool {
    let growth_m = params.completion.growth_m;
    let [length_m, width_m, height_m] = it.length_width_height_m;
    let [along_m, across_m, _] = it.in_box_frame(position_m);
    let top_m = it.center_m[2] + 0.5 * height_m + growth_m;
    along_m.abs() <= 0.5 * length_m + growth_m
        && across_m.abs() <= 0.5 * width_m + growth_m
        && position_m[2] > ground_m + params.completion.clearance_m
        && position_m[2] <= top_m
}

fn make_room(it: &mut OrientedBox, z_m: f32) {
    let half_m = 0.5 * it.length_width_height_m[2];
    let ends_m = [it.center_m[2] - half_m, it.center_m[2] + half_m];
    if z_m < ends_m[0] || ends_m[1] < z_m {
        let ends_m = [ends_m[0].min(z_m), ends_m[1].max(z_m)];
        it.center_m[2] = 0.5 * (ends_m[0] + ends_m[1]);
        it.length_width_height_m[2] = ends_m[1] - ends_m[0];
    }
}
