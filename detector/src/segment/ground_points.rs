//! Ground points, for users who ask a detector for no more than that.

use crate::grid::hierarchical_grid::{HierarchicalGrid, NO_CELL};
use crate::point_cloud::PointCloud;
use crate::segment::foreground::ForegroundParams;
use crate::segment::terrain::Terrain;
use crate::surface_class::SurfaceClass;

/// Whether each point of `cloud` is ground, in the order of the scan; `grid` holds the cloud, and `classes` has the class of
/// each cell.
///
/// All points of a ground cell are ground. Points of any other cell are ground if they do not stand clear of its ground: the
/// road around an object's feet, the grass below a tree. Points outside of the grid are not.
pub fn ground_points(
    cloud: &PointCloud,
    grid: &HierarchicalGrid,
    classes: &[SurfaceClass],
    terrain: &Terrain,
    params: &ForegroundParams,
) -> Vec<bool> {
    let mut top_m = vec![f32::NEG_INFINITY; classes.len()];
    for &cell_idx in grid.occupied() {
        top_m[cell_idx as usize] = match classes[cell_idx as usize] {
            SurfaceClass::Ground => f32::INFINITY,
            _ => params.ground_top_m(grid, terrain, cell_idx),
        };
    }
    let is_ground = |(&cell_idx, &z_m): (&u32, &f32)| cell_idx != NO_CELL && z_m <= top_m[cell_idx as usize];
    grid.cell_of_point().iter().zip(cloud.z_m()).map(is_ground).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;
    use crate::pipeline::frame::Frame;
    use crate::segment::drawn_ground::{road, segmented};

    #[test]
    fn the_foot_of_a_pole_is_ground_and_what_stands_on_it_is_not() {
        let params = HierarchicalParams::shipped();
        let mut cloud: PointCloud = road(100).collect();
        let n_road = cloud.len();
        // A pole of 4 m, and a point beyond the grid.
        for height_m in [0.05, 0.1, 0.3, 1.0, 2.0, 3.0, 4.0] {
            cloud.push([9.0, 3.0, height_m - 1.73], 0.0);
        }
        cloud.push([1e6, 0.0, -1.73], 0.0);
        let Frame { grid, terrain, .. } = segmented(&params.front_end(), &cloud);
        let cell_of_pole = grid.cell_of_point()[n_road] as usize;
        let mut classes = vec![SurfaceClass::Ground; grid.cells().len()];
        for class in [SurfaceClass::Tall, SurfaceClass::Short, SurfaceClass::Clutter] {
            classes[cell_of_pole] = class;
            let is_ground = ground_points(&cloud, &grid, &classes, &terrain, &params.foreground);
            assert!(is_ground[..n_road].iter().all(|&it| it));
            assert_eq!(is_ground[n_road..], [true, true, false, false, false, false, false, false]);
        }
    }
}
