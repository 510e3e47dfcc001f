//! From a scan to the points that may belong to objects. Shared with baselines that start from the same foreground.

use crate::detector::{StageClock, StageTime};
use crate::drawn::surfaces::{class_by_cell, surface_cells};
use crate::drawn::walls::wall_segments;
use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::segment::foreground::Foreground;
use crate::segment::ground_points::ground_points;
use crate::segment::ground_segmentation::GroundSegmentation;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::stage;
use crate::stage_product::{Shape, StageProduct};
use crate::surface_class::SurfaceClass;

/// Grid, terrain, cell classes and foreground of one scan after another.
#[derive(Debug, Clone)]
pub struct ForegroundStages {
    params: HierarchicalParams,
    grid: HierarchicalGrid,
    terrain: Terrain,
    ground: GroundSegmentation,
    walls: WallRefinement,
    classes: Vec<SurfaceClass>,
    foreground: Foreground,
}

impl ForegroundStages {
    /// Stages for a sensor `sensor_height_m` above the road.
    pub fn new(params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let grid = HierarchicalGrid::new(params.grid.clone());
        let terrain = Terrain::new(params.terrain.clone(), &grid, sensor_height_m);
        let weighting = DensityWeighting::new(&params.density_weighting);
        let ground = GroundSegmentation::new(params.ground.clone(), &params.grid, &weighting);
        let walls = WallRefinement::new(params.walls.clone(), &grid);
        let foreground = Foreground::new(params.foreground.clone());
        Self { params, grid, terrain, ground, walls, classes: Vec::new(), foreground }
    }

    /// Runs the stages on `cloud`.
    pub fn run(&mut self, cloud: &PointCloud, clock: &mut StageClock, stage_times: &mut Vec<StageTime>) {
        self.grid.fill(cloud);
        clock.lap(stage::GRID, stage_times);
        self.terrain.estimate(&self.grid);
        self.ground.segment(&self.grid, &self.terrain, &mut self.classes);
        clock.lap(stage::GROUND, stage_times);
        // After the ground: a wall is one only if no ground is seen behind it.
        self.walls.refine(&self.grid, &self.terrain, &mut self.classes);
        clock.lap(stage::WALLS, stage_times);
        self.foreground.extract(cloud, &self.grid, &self.classes, &self.terrain);
        clock.lap(stage::FOREGROUND, stage_times);
    }

    /// What the stages take out of the foreground.
    pub fn rules(&self) -> Vec<Rule> {
        if self.params.walls.enabled { vec![Rule::Walls] } else { Vec::new() }
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

    /// Elevation of the ground below the middle of a box in the latest scan, in metres.
    pub fn ground_below_m(&self, bounding_box: &OrientedBox) -> f32 {
        let [x_m, y_m, _] = bounding_box.center_m;
        self.terrain.elevation_m(self.grid.nearest_column_and_row([x_m, y_m]))
    }

    /// The class of every cell of [`Self::grid`]; empty cells are unseen.
    pub fn cell_classes(&self) -> &[SurfaceClass] {
        &self.classes
    }

    /// The cells that hold foreground points of the latest scan, ascending.
    pub fn foreground_cells(&self) -> &[u32] {
        self.foreground.cells()
    }

    /// Indices of the latest scan's foreground points, ascending.
    pub fn point_indices(&self) -> &[u32] {
        self.foreground.point_indices()
    }

    /// The classified cells and points of the latest scan.
    pub fn stage_products(&self) -> Vec<StageProduct> {
        let cells = surface_cells(&self.grid, |cell_idx| self.classes[cell_idx as usize]);
        let above_ground_m = self.params.walls.min_height_m;
        let walls = wall_segments(&self.grid, &self.terrain, self.walls.walls(), above_ground_m);
        let points = Shape::LabeledPoints(self.point_classes());
        vec![
            StageProduct { stage: stage::WALLS, name: "cells", shape: cells },
            StageProduct { stage: stage::WALLS, name: "segments", shape: walls },
            StageProduct { stage: stage::FOREGROUND, name: "points", shape: points },
        ]
    }

    /// Whether each point of the latest scan, which is `cloud`, is ground.
    pub fn ground_points(&self, cloud: &PointCloud) -> Vec<bool> {
        ground_points(cloud, &self.grid, &self.classes, &self.terrain, &self.params.foreground)
    }

    /// The class of every point of the latest scan: that of its cell, except that points of short cells that lie below
    /// the foreground are ground.
    pub fn point_classes(&self) -> Vec<SurfaceClass> {
        let mut classes = class_by_cell(&self.grid, |cell_idx| match self.classes[cell_idx as usize] {
            SurfaceClass::Short => SurfaceClass::Ground,
            class => class,
        });
        for &point_idx in self.point_indices() {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        classes
    }
}
