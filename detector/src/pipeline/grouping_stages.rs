//! From a scan to all groups of points that may be objects.

use crate::describe::surroundings::ObjectRaster;
use crate::detector::{StageClock, StageTime};
use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::group::dense_gaps::DenseGaps;
use crate::group::grouping_tree::GroupingTree;
use crate::group::leaf_cuts::LeafCuts;
use crate::group::linkage::{Linkage, LinkedScan};
use crate::group::node_values::{DescribedNode, NodeDescriber, NodePlaces};
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::point_cloud::PointCloud;
use crate::segment::ground_points::ground_points;
use crate::segment::ground_segmentation::GroundSegmentation;
use crate::segment::hough_lines::Segment;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::stage;
use crate::surface_class::SurfaceClass;

/// Grid, terrain, candidates, tree and descriptions of one scan after another. Training and running walk the same trees: these.
///
/// What joins cells to groups is the gaps between them, or what a rival has in their place.
#[derive(Debug, Clone)]
pub struct GroupingStages<L = DenseGaps> {
    params: HierarchicalParams,
    grid: HierarchicalGrid,
    terrain: Terrain,
    ground: GroundSegmentation,
    walls: WallRefinement,
    classes: Vec<SurfaceClass>,
    candidates: Candidates,
    dense: DenseCells,
    linkage: L,
    tree: GroupingTree,
    cuts: LeafCuts,
    n_left_uncut: usize,
    raster: ObjectRaster,
    describer: NodeDescriber,
}

impl GroupingStages {
    /// Stages for a sensor `sensor_height_m` above the road.
    pub fn new(params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let weighting = DensityWeighting::new(&params.density_weighting);
        let gaps = DenseGaps::new(params.grouping.gaps.clone(), &params.grid, &weighting);
        Self::over(gaps, params, sensor_height_m)
    }
}

impl<L: Linkage> GroupingStages<L> {
    /// The same, with groups that `linkage` joins.
    pub fn over(linkage: L, params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let grid = HierarchicalGrid::new(params.grid.clone());
        let weighting = DensityWeighting::new(&params.density_weighting);
        Self {
            terrain: Terrain::new(params.terrain.clone(), &grid, sensor_height_m),
            ground: GroundSegmentation::new(params.ground.clone(), &params.grid, &weighting),
            walls: WallRefinement::new(params.walls.clone(), &grid),
            classes: Vec::new(),
            candidates: Candidates::new(
                params.grouping.candidates.clone(),
                params.foreground.clone(),
                params.ground.tall_height_m,
            ),
            dense: DenseCells::default(),
            linkage,
            tree: GroupingTree::default(),
            cuts: LeafCuts::default(),
            n_left_uncut: 0,
            raster: ObjectRaster::new(params.grid.extent_m),
            describer: NodeDescriber::default(),
            grid,
            params,
        }
    }

    /// Runs the stages on `cloud`.
    pub fn run(&mut self, cloud: &PointCloud, clock: &mut StageClock, stage_times: &mut Vec<StageTime>) {
        let Self { params, grid, terrain, candidates, dense, tree, .. } = self;
        grid.fill(cloud);
        clock.lap(stage::GRID, stage_times);
        terrain.estimate(grid);
        self.ground.segment(grid, terrain, &mut self.classes);
        candidates.find_hanging(cloud, grid, terrain, &mut self.classes);
        clock.lap(stage::GROUND, stage_times);
        self.walls.refine_on_walls(grid, terrain, |it| candidates.hangs(it), &mut self.classes);
        clock.lap(stage::WALLS, stage_times);
        candidates.find(cloud, grid, &self.classes, &self.walls);
        clock.lap(stage::FOREGROUND, stage_times);
        let scan = LinkedScan { cloud, grid, terrain, candidates };
        self.linkage.fill(&scan, dense);
        clock.lap(L::STAGES[0], stage_times);
        self.linkage.link(&scan, dense);
        clock.lap(L::STAGES[1], stage_times);
        tree.build(dense, &self.linkage);
        clock.lap(stage::GROUPING, stage_times);
        self.n_left_uncut = self.cuts.cut(tree, dense, &params.grouping.cuts);
        clock.lap(stage::CUTS, stage_times);
        let GridParams { cell_size_m, xi, extent_m } = params.grid;
        if self.raster.has_cells(cell_size_m / xi as f32, extent_m) {
            let occupied = dense.heaps().iter().filter(|it| it.n_points > 0);
            self.raster.fill_by_cell(occupied.map(|it| (it.middle_m(), it.n_points)));
        } else {
            self.raster.fill(candidates.point_indices().iter().map(|&it| cloud.position_m(it as usize)));
        }
        let places = NodePlaces {
            grid,
            terrain,
            candidates,
            dense,
            raster: params.grouping.surroundings.then_some(&self.raster),
            classes: &self.classes,
            walls: &self.walls,
            n_points: cloud.len(),
        };
        let min_points = params.cluster.min_vehicle_points;
        self.describer.describe(tree, &places, (&params.grouping.bounds, min_points));
        clock.lap(stage::DESCRIPTION, stage_times);
    }

    /// The parameters.
    pub fn params(&self) -> &HierarchicalParams {
        &self.params
    }

    /// The grid of the latest scan.
    pub fn grid(&self) -> &HierarchicalGrid {
        &self.grid
    }

    /// The ground under the latest scan.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// The walls of the latest scan.
    pub fn walls(&self) -> &[Segment] {
        self.walls.walls()
    }

    /// The class of every cell of the latest scan.
    pub fn cell_classes(&self) -> &[SurfaceClass] {
        &self.classes
    }

    /// Whether each point of the latest scan, which is `cloud`, is ground.
    pub fn ground_points(&self, cloud: &PointCloud) -> Vec<bool> {
        ground_points(cloud, &self.grid, &self.classes, &self.terrain, &self.params.foreground)
    }

    /// The points that may belong to objects.
    pub fn candidates(&self) -> &Candidates {
        &self.candidates
    }

    /// Their cells.
    pub fn dense(&self) -> &DenseCells {
        &self.dense
    }

    /// Whether there are groups within groups.
    pub fn is_nested(&self) -> bool {
        self.linkage.is_nested()
    }

    /// All groupings.
    pub fn tree(&self) -> &GroupingTree {
        &self.tree
    }

    /// How many groups of the latest scan were not cut since there were too many.
    pub fn n_left_uncut(&self) -> usize {
        self.n_left_uncut
    }

    /// The groups that may be objects, ascending.
    pub fn described(&self) -> &[DescribedNode] {
        self.describer.described()
    }

    /// Elevation of the ground below the middle of a box in the latest scan, in metres.
    pub fn ground_below_m(&self, bounding_box: &OrientedBox) -> f32 {
        let [x_m, y_m, _] = bounding_box.center_m;
        self.terrain.elevation_m(self.grid.nearest_column_and_row([x_m, y_m]))
    }
}
