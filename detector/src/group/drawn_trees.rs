//! Trees to test with.

use crate::grid::density_curve::DensityCurve;
use crate::grid::density_weighting::{DensityWeighting, DensityWeightingParams};
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::group::dense_gaps::DenseGaps;
use crate::group::grouping_tree::GroupingTree;
use crate::params::HierarchicalParams;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::surface_class::SurfaceClass;

/// The tree over dense cells of 20 cm at these steps from a place in front of the sensor, 20 points in each.
pub fn tree_over(steps: &[[u8; 2]]) -> (DenseCells, GroupingTree, PointCloud) {
    let params = HierarchicalParams::shipped();
    let geometry = GridParams { extent_m: 40.0, ..params.grid.clone() };
    let mut cloud = PointCloud::default();
    for step in steps {
        let [x_m, y_m] = step.map(|it| 6.0 + (f32::from(it) + 0.5) * 0.2);
        for level in 0..20_u8 {
            cloud.push([x_m, y_m, f32::from(level) * 0.05 - 1.5], 0.0);
        }
    }
    let mut grid = HierarchicalGrid::new(geometry.clone());
    grid.fill(&cloud);
    let terrain = Terrain::new(params.terrain.clone(), &grid, 1.73);
    let mut classes = vec![SurfaceClass::Unseen; grid.cells().len()];
    for &cell_idx in grid.occupied() {
        classes[cell_idx as usize] = SurfaceClass::Short;
    }
    let mut candidates = Candidates::new(
        params.grouping.candidates.clone(),
        params.foreground.clone(),
        params.ground.tall_height_m,
    );
    candidates.find_hanging(&cloud, &grid, &terrain, &mut classes);
    let walls = WallRefinement::new(params.walls.clone(), &grid);
    candidates.find(&cloud, &grid, &classes, &walls);
    let mut dense = DenseCells::default();
    dense.fill(&cloud, &grid, &terrain, &candidates);
    let curve = DensityCurve::shipped("hdl-64e-s2").unwrap();
    let weighting = DensityWeighting::new(&DensityWeightingParams { enabled: true, curve });
    let mut gaps = DenseGaps::new(
        params.grouping.gaps.clone(),
        (&params.merge, &params.separation),
        &geometry,
        &weighting,
    );
    gaps.find(&grid, &dense, &candidates);
    let mut tree = GroupingTree::default();
    tree.build(&dense, &gaps);
    (dense, tree, cloud)
}
