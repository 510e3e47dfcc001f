//! The rival of the hierarchical grid: components of points over a kd-tree.

use std::ops::RangeInclusive;

use detector::detector::{DetectorOutput, DropReason};
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::{fill_grid, foreground_stages, ground};
use detector::pipeline::frame::{Frame, PointClusters};
use detector::pipeline::object_stages::{ObjectModels, least_points, object_stages};
use detector::pipeline::stage_list::{Pipeline, Stage, Stages};
use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::{OrientedBox, PointCloud, StageProduct, stage};

use crate::COMPONENTS;
use crate::cluster_boxes::{ClusterBoxes, ClusterFit};
use crate::kd_tree_components::{KdTreeScratch, kd_tree_components};
use crate::nested_components::NestedComponents;
use crate::params::{ForegroundChoice, KdTreeParams, NeighborSearch};

/// Objects as Euclidean components of points, for a sensor `sensor_height_m` above the road.
///
/// Foreground, boxes and classes are those of the hierarchical detector, whose parameters are `shared`, so that a comparison
/// of the two is about the clusters. All buffers but the tree are used again for the next scan. The models are for
/// [`object_stages`].
///
/// Paper: HG section 5, the method it compares with; boxes as VM section 4.
pub fn kd_tree(
    params: &KdTreeParams,
    shared: &HierarchicalParams,
    models: ObjectModels,
    sensor_height_m: f32,
) -> Pipeline<PointClusters> {
    let mut shared = shared.clone();
    shared.walls.enabled &= params.foreground == ForegroundChoice::Refined;
    // The grid does not hold the whole scan, so that clusters cannot be completed from it.
    shared.completion.enabled &= params.foreground != ForegroundChoice::All;
    shared.cluster.min_points = params.min_points;
    let n_points = least_points(&shared.cluster, models.vehicles.as_ref())..=params.max_points;
    let front_end = shared.front_end();
    let foreground = match params.foreground {
        ForegroundChoice::Short | ForegroundChoice::Refined => foreground_stages(&front_end),
        ForegroundChoice::Standing => Stages::default()
            .then(stage::GRID, fill_grid)
            .then(stage::GROUND, ground(&front_end))
            .then(stage::FOREGROUND, StandingPoints::default()),
        ForegroundChoice::All => Stages::default().then(stage::FOREGROUND, FinitePoints),
    };
    let stages = foreground
        .then(COMPONENTS, Components::new(params))
        .then(stage::BOXES, ClusterBoxes::new(HullFit { n_points, box_fit: ConvexHullBox::default() }))
        .and(object_stages(&shared, models));
    let frame = Frame::new(PointClusters::new(&front_end), &front_end, sensor_height_m);
    Pipeline { name: "kd-tree", frame, stages }
}

/// The detector `kd-tree-same-walls`: like for like with the hierarchical one, it looks for walls before it clusters,
/// whatever `params` say about the foreground.
pub fn kd_tree_same_walls(
    params: &KdTreeParams,
    shared: &HierarchicalParams,
    models: ObjectModels,
    sensor_height_m: f32,
) -> Pipeline<PointClusters> {
    let params = KdTreeParams { foreground: ForegroundChoice::Refined, ..params.clone() };
    Pipeline { name: "kd-tree-same-walls", ..kd_tree(&params, shared, models, sensor_height_m) }
}

/// Takes the points of short and tall cells that stand clear of the ground.
#[derive(Default)]
struct StandingPoints {
    point_indices: Vec<u32>,
}

impl Stage<PointClusters> for StandingPoints {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput) {
        let Frame { grid, terrain, classes, foreground_params, clustering, .. } = frame;
        let stands = |&(cell_idx, z_m): &(u32, f32)| {
            let class = classes.get(cell_idx as usize);
            matches!(class, Some(SurfaceClass::Short | SurfaceClass::Tall))
                && z_m > foreground_params.ground_top_m(grid, terrain, cell_idx)
        };
        let points = grid.cell_of_point().iter().copied().zip(cloud.z_m().iter().copied());
        let standing = (0..).zip(points).filter(|(_, point)| stands(point)).map(|(point_idx, _)| point_idx);
        self.point_indices.clear();
        self.point_indices.extend(standing);
        clustering.foreground.set_points(self.point_indices.iter().copied());
    }

    fn products(&self, _: &PointCloud, frame: &Frame<PointClusters>) -> Vec<StageProduct> {
        let shape = Shape::LabeledPoints(frame.point_classes());
        vec![StageProduct { stage: stage::FOREGROUND, name: "points", shape }]
    }
}

/// Takes all points with finite coordinates.
struct FinitePoints;

impl Stage<PointClusters> for FinitePoints {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput) {
        let positions_m = (0..).zip(cloud.positions_m());
        let finite = positions_m.filter(|(_, position_m)| position_m.iter().all(|it| it.is_finite()));
        frame.clustering.foreground.set_points(finite.map(|(point_idx, _)| point_idx));
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<PointClusters>) -> Vec<StageProduct> {
        let mut classes = vec![SurfaceClass::Unseen; cloud.len()];
        for &point_idx in frame.clustering.foreground.point_indices() {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        vec![StageProduct { stage: stage::FOREGROUND, name: "points", shape: Shape::LabeledPoints(classes) }]
    }
}

/// Clusters the foreground.
struct Components {
    neighbors: NeighborSearch,
    tolerance_m: f32,
    positions_m: Vec<[f32; 3]>,
    // The smallest index of a point of the component, for every point.
    labels: Vec<u32>,
    in_tree: KdTreeScratch,
    in_cells: NestedComponents,
}

impl Components {
    fn new(params: &KdTreeParams) -> Self {
        Self {
            neighbors: params.neighbors,
            tolerance_m: params.tolerance_m,
            positions_m: Vec::new(),
            labels: Vec::new(),
            in_tree: KdTreeScratch::default(),
            in_cells: NestedComponents::default(),
        }
    }
}

impl Stage<PointClusters> for Components {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput) {
        let Self { positions_m, labels, in_tree, in_cells, .. } = self;
        let point_indices = frame.clustering.foreground.point_indices().iter();
        positions_m.clear();
        positions_m.extend(point_indices.map(|&point_idx| cloud.position_m(point_idx as usize)));
        match self.neighbors {
            NeighborSearch::Cells if NestedComponents::are_exact(positions_m, self.tolerance_m) => {
                in_cells.reset(positions_m.len());
                in_cells.join(positions_m, self.tolerance_m, |_, _| ());
                in_cells.write_labels(positions_m.len(), labels);
            }
            NeighborSearch::Cells | NeighborSearch::Tree => {
                kd_tree_components(positions_m, self.tolerance_m, in_tree, labels);
            }
        }
        frame.clustering.clusters.group(labels.iter().copied(), labels.len());
    }
}

/// Boxes close to the corners of the convex hull, around clusters whose number of points is within `n_points`.
struct HullFit {
    n_points: RangeInclusive<usize>,
    box_fit: ConvexHullBox,
}

impl ClusterFit for HullFit {
    fn fit(&mut self, positions_m: &[[f32; 3]]) -> Result<OrientedBox, DropReason> {
        if positions_m.len() < *self.n_points.start() {
            return Err(DropReason::TooFewPoints);
        }
        // As in PCL, a cluster of too many points is no object: a façade that is left in the foreground, or the road.
        if positions_m.len() > *self.n_points.end() {
            return Err(DropReason::TooManyPoints);
        }
        let mut z_range_m = [f32::INFINITY, f32::NEG_INFINITY];
        for &[_, _, z_m] in positions_m {
            z_range_m = [z_range_m[0].min(z_m), z_range_m[1].max(z_m)];
        }
        let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
        Ok(self.box_fit.fit(outline_m, z_range_m).expect("no cluster is without points"))
    }

    fn hull_m(&self) -> Option<&[[f32; 2]]> {
        Some(self.box_fit.hull_m())
    }
}
