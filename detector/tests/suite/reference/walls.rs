//! Short cells of walls become tall (HG section 3.1).

use std::collections::BTreeMap;

use detector::PointCloud;
use detector::grid::hierarchical_grid::HierarchicalGrid;
use detector::params::front_end::FrontEndParams;
use detector::segment::terrain::Terrain;
use detector::segment::wall_refinement::WallRefinement;
use detector::surface_class::SurfaceClass;

use super::cells::Cell;

/// The detector's own refinement, which is simple as it is and draws lots: only its input and its output are the
/// reference's.
pub fn refine(
    cloud: &PointCloud,
    classes: BTreeMap<Cell, SurfaceClass>,
    params: &FrontEndParams,
    sensor_height_m: f32,
) -> BTreeMap<Cell, SurfaceClass> {
    let mut grid = HierarchicalGrid::new(params.grid.clone());
    grid.fill(cloud);
    let mut terrain = Terrain::new(params.terrain.clone(), &grid, sensor_height_m);
    terrain.estimate(&grid);
    let index_of = |cell: Cell| cell.row as usize * grid.n_columns() as usize + cell.column as usize;
    let mut by_idx = vec![SurfaceClass::Unseen; grid.cells().len()];
    for (&cell, &class) in &classes {
        by_idx[index_of(cell)] = class;
    }
    WallRefinement::new(params.walls.clone(), &grid).refine(&grid, &terrain, &mut by_idx);
    classes.into_keys().map(|cell| (cell, by_idx[index_of(cell)])).collect()
}
