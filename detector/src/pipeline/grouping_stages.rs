//! Stages that find all groups of points of a scan that may be objects.

use crate::describe::surroundings::ObjectRaster;
use crate::detector::DetectorOutput;
use crate::drawn::groups::{candidate_classes, smallest_groups};
use crate::grid::hierarchical_grid::GridParams;
use crate::group::leaf_cuts::{LeafCuts, LeafCutsParams};
use crate::group::linkage::LinkedScan;
use crate::group::node_shapes::NodeScene;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::{cells_and_walls, fill_grid, ground};
use crate::pipeline::frame::{Frame, Groups};
use crate::pipeline::stage_list::{Pipeline, Stage, Stages};
use crate::point_cloud::PointCloud;
use crate::segment::ground_segmentation::GroundSegmentation;
use crate::stage;
use crate::stage_product::{Shape, StageProduct};

/// Grid, terrain, candidates, tree and descriptions over `frame`, whose linkage joins cells to groups. There are no
/// detections: training and detection use the same trees.
pub fn grouping(frame: Frame<Groups>, params: &HierarchicalParams) -> Pipeline<Groups> {
    let [filling, linking] = frame.clustering.linkage.stages();
    let stages = Stages::default()
        .then(stage::GRID, fill_grid)
        .then(stage::GROUND, ground_and_hanging(ground(&params.front_end())))
        .then(stage::WALLS, StandingWalls)
        .then(stage::FOREGROUND, CandidatePoints)
        .then(filling, fill_cells)
        .then(linking, link_cells)
        .then(stage::GROUPING, Grouping)
        .then(stage::CUTS, cuts(params.grouping.cuts.clone()))
        .then(stage::DESCRIPTION, description(params));
    Pipeline { name: "grouping", frame, stages }
}

/// Finds the ground, and the things that hang over it.
fn ground_and_hanging(mut ground: GroundSegmentation) -> impl Stage<Groups> {
    move |cloud: &PointCloud, frame: &mut Frame<Groups>, output: &mut DetectorOutput| {
        ground.run(cloud, frame, output);
        let Frame { grid, terrain, classes, clustering: groups, .. } = frame;
        groups.candidates.find_hanging(cloud, grid, terrain, classes);
    }
}

/// Finds walls among the things that stand. They take nothing away.
struct StandingWalls;

impl Stage<Groups> for StandingWalls {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        let Frame { grid, terrain, classes, walls, clustering: groups, .. } = frame;
        walls.refine_on_walls(grid, terrain, &|it| groups.candidates.hangs(it), classes);
    }

    fn products(&self, _: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        cells_and_walls(frame)
    }
}

/// Gathers the points that may belong to objects, with the evidence against it.
struct CandidatePoints;

impl Stage<Groups> for CandidatePoints {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        frame.clustering.candidates.find(cloud, &frame.grid, &frame.classes, &frame.walls);
    }

    fn products(&self, _: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        let classes = candidate_classes(&frame.grid, &frame.classes, &frame.clustering.candidates);
        vec![StageProduct { stage: stage::FOREGROUND, name: "points", shape: Shape::LabeledPoints(classes) }]
    }
}

/// Sorts candidates into dense cells.
fn fill_cells(cloud: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
    let Frame { grid, terrain, clustering: Groups { candidates, linkage, dense, .. }, .. } = frame;
    linkage.fill(&LinkedScan { cloud, grid, terrain, candidates }, dense);
}

/// Finds the links between these.
fn link_cells(cloud: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
    let Frame { grid, terrain, clustering: Groups { candidates, linkage, dense, .. }, .. } = frame;
    linkage.link(&LinkedScan { cloud, grid, terrain, candidates }, dense);
}

/// Gathers dense cells to groups within groups.
struct Grouping;

impl Stage<Groups> for Grouping {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        let Groups { tree, dense, linkage, .. } = &mut frame.clustering;
        tree.build(dense, linkage.links());
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        let Groups { candidates, dense, tree, .. } = &frame.clustering;
        let shape = smallest_groups(cloud.len(), candidates, dense, tree);
        vec![StageProduct { stage: stage::GROUPING, name: "smallest_groups", shape }]
    }
}

/// Cuts groups where there is no gap.
fn cuts(params: LeafCutsParams) -> impl Stage<Groups> {
    let mut cuts = LeafCuts::default();
    move |_: &PointCloud, frame: &mut Frame<Groups>, output: &mut DetectorOutput| {
        output.n_left_uncut = cuts.cut(&mut frame.clustering.tree, &frame.clustering.dense, &params);
    }
}

/// Computes the values by which a group is judged to be an object.
fn description(params: &HierarchicalParams) -> impl Stage<Groups> + use<> {
    let GridParams { cell_size_m, xi, extent_m } = params.grid;
    let min_points = params.cluster.min_vehicle_points;
    let (bounds, surroundings) = (params.grouping.bounds.clone(), params.grouping.surroundings);
    let mut raster = ObjectRaster::new(extent_m);
    move |cloud: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput| {
        let Frame { grid, terrain, classes, walls, clustering: groups, .. } = frame;
        let Groups { candidates, dense, tree, describer, .. } = groups;
        if raster.has_cells(cell_size_m / xi as f32, extent_m) {
            let occupied = dense.statistics().iter().filter(|it| it.n_points > 0);
            raster.fill_by_cell(occupied.map(|it| (it.middle_m(), it.n_points)));
        } else {
            raster.fill(candidates.point_indices().iter().map(|&it| cloud.position_m(it as usize)));
        }
        let raster = surroundings.then_some(&raster);
        let n_points = cloud.len();
        let scene = NodeScene { grid, terrain, candidates, dense, raster, classes, walls, n_points };
        describer.describe(tree, &scene, &bounds, min_points);
    }
}
