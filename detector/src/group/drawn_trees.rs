//! Trees to test with.

use crate::grid::density_curve::DensityCurve;
use crate::grid::density_weighting::{DensityWeighting, DensityWeightingParams};
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::group::dense_gaps::DenseGaps;
use crate::group::grouping_tree::GroupingTree;
use crate::group::linkage::Linkage;
use crate::params::HierarchicalParams;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::surface_class::SurfaceClass;

/// A scan, and the results of all stages up to the tree.
pub(crate) struct DrawnGroups {
    pub(crate) cloud: PointCloud,
    pub(crate) grid: HierarchicalGrid,
    pub(crate) terrain: Terrain,
    pub(crate) classes: Vec<SurfaceClass>,
    pub(crate) walls: WallRefinement,
    pub(crate) candidates: Candidates,
    pub(crate) dense: DenseCells,
    pub(crate) gaps: DenseGaps,
    pub(crate) tree: GroupingTree,
}

/// Height of the sensor of drawn scans above the road.
const SENSOR_HEIGHT_M: f32 = 1.73;

/// Corner of the dense cell of 20 cm that is so many steps from a position in front of the sensor.
pub(crate) fn corner_m(step: [u8; 2]) -> [f32; 2] {
    step.map(|it| 6.0 + f32::from(it) * 0.2)
}

/// The tree over dense cells of 20 cm at these steps from a position in front of the sensor, 20 points in each, of which the
/// lowest four are taken for the road.
pub fn tree_over(steps: &[[u8; 2]]) -> (DenseCells, GroupingTree, PointCloud) {
    let DrawnGroups { dense, tree, cloud, .. } = groups_over(steps);
    (dense, tree, cloud)
}

/// [`tree_over`] with the results of all stages before it.
pub(crate) fn groups_over(steps: &[[u8; 2]]) -> DrawnGroups {
    let mut cloud = PointCloud::default();
    for &step in steps {
        let [x_m, y_m] = corner_m(step).map(|it| it + 0.1);
        for level in 0..20_u8 {
            cloud.push([x_m, y_m, f32::from(level) * 0.05 - 1.5], 0.0);
        }
    }
    groups_of(cloud)
}

/// The results of all stages on `cloud`, over a level road.
pub(crate) fn groups_of(cloud: PointCloud) -> DrawnGroups {
    let params = HierarchicalParams::shipped();
    let geometry = GridParams { extent_m: 40.0, ..params.grid.clone() };
    let mut grid = HierarchicalGrid::new(geometry.clone());
    grid.fill(&cloud);
    let terrain = Terrain::new(params.terrain.clone(), &grid, SENSOR_HEIGHT_M);
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
    let mut gaps = DenseGaps::new(params.grouping.gaps.clone(), &geometry, &weighting);
    gaps.find(&grid, &dense, &candidates);
    let mut tree = GroupingTree::default();
    tree.build(&dense, gaps.links());
    DrawnGroups { cloud, grid, terrain, classes, walls, candidates, dense, gaps, tree }
}
