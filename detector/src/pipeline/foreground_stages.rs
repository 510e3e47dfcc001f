//! Stages that find the points of a scan that may belong to objects.

use crate::detector::DetectorOutput;
use crate::drawn::surfaces::surface_cells;
use crate::drawn::walls::wall_segments;
use crate::grid::density_weighting::DensityWeighting;
use crate::params::front_end::FrontEndParams;
use crate::pipeline::frame::Frame;
use crate::pipeline::stage_list::{Pipeline, Stage, Stages};
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::segment::foreground::Foreground;
use crate::segment::ground_segmentation::GroundSegmentation;
use crate::stage;
use crate::stage_product::{Shape, StageProduct};

/// Grid, cell classes, walls and foreground. Detectors that cluster differently start from the same foreground.
///
/// Paper: HG section 3.1, and the first paragraph of section 3.2.
pub fn foreground_stages<C: AsRef<Foreground> + AsMut<Foreground> + 'static>(
    params: &FrontEndParams,
) -> Stages<C> {
    Stages::default()
        .then(stage::GRID, fill_grid)
        .then(stage::GROUND, ground(params))
        .then(stage::WALLS, Walls)
        .then(stage::FOREGROUND, ForegroundPoints)
}

/// These stages alone, for a sensor `sensor_height_m` above the road: their results are in the frame, and there are no
/// detections.
pub fn foreground(params: &FrontEndParams, sensor_height_m: f32) -> Pipeline<Foreground> {
    let frame = Frame::new(Foreground::new(params.foreground.clone()), params, sensor_height_m);
    Pipeline { name: "foreground", frame, stages: foreground_stages(params) }
}

/// Sorts the points into cells.
pub fn fill_grid<C>(cloud: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
    frame.grid.fill(cloud);
}

/// Separates cells from the ground by `params`.
pub fn ground(params: &FrontEndParams) -> GroundSegmentation {
    let weighting = DensityWeighting::new(&params.density_weighting);
    GroundSegmentation::new(params.ground.clone(), &params.grid, &weighting)
}

impl<C> Stage<C> for GroundSegmentation {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        let Frame { grid, terrain, classes, .. } = frame;
        terrain.estimate(grid);
        self.segment(grid, terrain, classes);
    }
}

/// Takes walls out of the short cells.
struct Walls;

impl<C> Stage<C> for Walls {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        // After the ground: a wall is one only if no ground is seen behind it.
        frame.walls.refine(&frame.grid, &frame.terrain, &mut frame.classes);
    }

    fn products(&self, _: &PointCloud, frame: &Frame<C>) -> Vec<StageProduct> {
        cells_and_walls(frame)
    }

    fn rules(&self, frame: &Frame<C>) -> Vec<Rule> {
        if frame.walls.params().enabled { vec![Rule::Walls] } else { Vec::new() }
    }
}

/// The cells with their classes, and the walls.
pub fn cells_and_walls<C>(frame: &Frame<C>) -> Vec<StageProduct> {
    let Frame { grid, terrain, walls, .. } = frame;
    let classes = frame.cell_classes();
    let cells = surface_cells(grid, |cell_idx| classes[cell_idx as usize]);
    let segments = wall_segments(grid, terrain, walls.walls(), walls.params().min_height_m);
    vec![
        StageProduct { stage: stage::WALLS, name: "cells", shape: cells },
        StageProduct { stage: stage::WALLS, name: "segments", shape: segments },
    ]
}

/// Gathers the points of short cells.
struct ForegroundPoints;

impl<C: AsRef<Foreground> + AsMut<Foreground>> Stage<C> for ForegroundPoints {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<C>, _: &mut DetectorOutput) {
        let Frame { grid, terrain, classes, clustering, .. } = frame;
        clustering.as_mut().extract(cloud, grid, classes, terrain);
    }

    fn products(&self, _: &PointCloud, frame: &Frame<C>) -> Vec<StageProduct> {
        let shape = Shape::LabeledPoints(frame.point_classes());
        vec![StageProduct { stage: stage::FOREGROUND, name: "points", shape }]
    }
}
