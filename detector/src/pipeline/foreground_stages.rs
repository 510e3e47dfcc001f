//! From a scan to the points that may belong to objects. Shared with baselines that start from the same foreground.

use crate::detector::{StageClock, StageTime};
use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{HierarchicalGrid, NO_CELL};
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::segment::foreground::Foreground;
use crate::segment::ground_segmentation::GroundSegmentation;
use crate::segment::hough_lines::Segment;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::stage_product::{ProductCell, Shape, StageProduct};
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
        clock.lap("grid", stage_times);
        self.terrain.estimate(&self.grid);
        self.ground.segment(&self.grid, &self.terrain, &mut self.classes);
        clock.lap("ground", stage_times);
        self.walls.refine(&self.grid, &self.terrain, &mut self.classes);
        clock.lap("walls", stage_times);
        self.foreground.extract(cloud, &self.grid, &self.classes, &self.terrain);
        clock.lap("foreground", stage_times);
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
        let cells = self.grid.occupied().iter().map(|&cell_idx| {
            let cell = &self.grid.cells()[cell_idx as usize];
            ProductCell {
                center_m: self.grid.center_m(cell_idx),
                z_range_m: [cell.z_min_m, cell.z_max_m],
                class: self.classes[cell_idx as usize],
            }
        });
        let cells = Shape::Cells { cell_size_m: self.grid.params().cell_size_m, cells: cells.collect() };
        let walls = Shape::Segments(self.walls.walls().iter().map(|&it| self.wall_m(it)).collect());
        vec![
            StageProduct { stage: "walls", name: "cells", shape: cells },
            StageProduct { stage: "walls", name: "segments", shape: walls },
            StageProduct {
                stage: "foreground",
                name: "points",
                shape: Shape::LabeledPoints(self.point_classes()),
            },
        ]
    }

    /// A wall from end to end, drawn where supporting cells begin.
    fn wall_m(&self, wall: Segment) -> [[f32; 3]; 2] {
        [wall.start, wall.end].map(|[column, row]| {
            let cell_idx = row as u32 * self.grid.n_columns() + column as u32;
            let [x, y] = self.grid.center_m(cell_idx);
            let ground_m = self.terrain.elevation_m(self.grid.column_and_row(cell_idx));
            [x, y, ground_m + self.params.walls.min_height_m]
        })
    }

    /// The class of every point of the latest scan: that of its cell, except that points of short cells that lie below
    /// the foreground are ground.
    pub fn point_classes(&self) -> Vec<SurfaceClass> {
        let class_of = |&cell_idx: &u32| match cell_idx {
            NO_CELL => SurfaceClass::Unseen,
            _ => match self.classes[cell_idx as usize] {
                SurfaceClass::Short => SurfaceClass::Ground,
                class => class,
            },
        };
        let mut classes: Vec<SurfaceClass> = self.grid.cell_of_point().iter().map(class_of).collect();
        for &point_idx in self.point_indices() {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        classes
    }
}
