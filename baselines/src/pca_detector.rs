//! The rival of the vehicle model: an occupancy grid, and boxes along principal axes.

use detector::classify::paper_model::NO_VEHICLE;
use detector::detector::{DetectorOutput, DropReason};
use detector::drawn::surfaces::{class_by_cell, surface_cells};
use detector::fit::fitted_objects::FittedObjects;
use detector::fit::principal_axes_box::principal_axes_box;
use detector::grid::hierarchical_grid::GridParams;
use detector::params::HierarchicalParams;
use detector::params::front_end::FrontEndParams;
use detector::pipeline::foreground_stages::fill_grid;
use detector::pipeline::frame::{Frame, PointClusters};
use detector::pipeline::object_stages::classification;
use detector::pipeline::stage_list::{Pipeline, Stage, Stages};
use detector::road_user::RoadUserOdds;
use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::{OrientedBox, PointCloud, StageProduct, stage};

use crate::COMPONENTS;
use crate::cluster_boxes::{ClusterBoxes, ClusterFit};
use crate::occupancy_grid_components::{OccupancyGridComponents, OccupancyParams, occupied_cells};
use crate::params::{ClusterExtentParams, PcaParams};
use crate::pca_vehicle_model::PcaVehicleModel;

/// Objects as components of occupied cells, with boxes along their principal axes, for a sensor `sensor_height_m` above the
/// road.
///
/// The grid takes everything that stands on the street, façades included. Objects longer than a vehicle can be are dropped
/// and reported. `model` classifies vehicles by the shapes of the neighbourhoods of their points; without a model, the size
/// gate of `shared` classifies them, as for all detectors.
///
/// Paper: VM sections 1 and 6, the method it compares with.
pub fn pca(
    params: &PcaParams,
    shared: &HierarchicalParams,
    model: Option<PcaVehicleModel>,
    sensor_height_m: f32,
) -> Pipeline<PointClusters> {
    // Only the coarse level of the grid is used.
    let grid = GridParams { cell_size_m: params.grid.cell_size_m, xi: 1, extent_m: params.grid.extent_m };
    let front_end = FrontEndParams { grid, ..shared.front_end() };
    let sizes = shared.vehicle_size.clone();
    let mut stages = Stages::default()
        .then(stage::GRID, fill_grid)
        .then(stage::FOREGROUND, OccupiedCells(params.occupancy.clone()))
        .then(COMPONENTS, components())
        .then(stage::BOXES, ClusterBoxes::new(params.cluster.clone()));
    if let Some(model) = model.clone() {
        stages = stages.then(stage::FEATURES, features(model));
    }
    let least_points = sizes.min_points;
    // Paper: VM section 6.
    let decide = move |fitted: &mut FittedObjects| {
        if let Some(model) = &model {
            fitted.decide(|_, values| {
                let decision = values.map_or(NO_VEHICLE, |it| model.decision_on(it));
                RoadUserOdds::of_vehicle(decision)
            });
        }
    };
    stages = stages.then(stage::CLASSIFICATION, classification(sizes, least_points, decide));
    let frame = Frame::new(PointClusters::new(&front_end), &front_end, sensor_height_m);
    Pipeline { name: "pca", frame, stages }
}

/// Finds the occupied cells.
struct OccupiedCells(OccupancyParams);

impl Stage<PointClusters> for OccupiedCells {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput) {
        frame.clustering.foreground.set_cells(occupied_cells(&frame.grid, &self.0));
    }

    fn products(&self, _: &PointCloud, frame: &Frame<PointClusters>) -> Vec<StageProduct> {
        // Occupied cells are drawn like short objects, since this grid knows no other class.
        let class_of = |cell_idx| match frame.clustering.foreground.cells().binary_search(&cell_idx) {
            Ok(_) => SurfaceClass::Short,
            Err(_) => SurfaceClass::Ground,
        };
        let product = |name, shape| StageProduct { stage: stage::FOREGROUND, name, shape };
        vec![
            product("cells", surface_cells(&frame.grid, class_of)),
            product("points", Shape::LabeledPoints(class_by_cell(&frame.grid, class_of))),
        ]
    }
}

/// Connects these cells, and gathers the points over them.
fn components() -> impl Stage<PointClusters> {
    let mut components = OccupancyGridComponents::default();
    move |_: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput| {
        let Frame { grid, clustering: PointClusters { foreground, clusters }, .. } = frame;
        components.connect(grid, foreground.cells());
        foreground.set_points(components.point_indices().iter().copied());
        let labels = components.component_of_point().iter().copied();
        clusters.group(labels, foreground.cells().len());
    }
}

/// Computes the values that `model` looks at.
fn features(mut model: PcaVehicleModel) -> impl Stage<PointClusters> {
    move |_: &PointCloud, frame: &mut Frame<PointClusters>, _: &mut DetectorOutput| {
        frame
            .fitted
            .describe(|object, positions_m| model.values(&object.bounding_box, positions_m.iter().copied()));
    }
}

impl ClusterFit for ClusterExtentParams {
    fn fit(&mut self, positions_m: &[[f32; 3]]) -> Result<OrientedBox, DropReason> {
        let bounding_box =
            principal_axes_box(positions_m.iter().copied()).expect("no cluster is without points");
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        if positions_m.len() < self.min_points {
            Err(DropReason::TooFewPoints)
        } else if length_m.max(width_m) > self.max_extent_m {
            Err(DropReason::TooLarge)
        } else {
            Ok(bounding_box)
        }
    }

    fn hull_m(&self) -> Option<&[[f32; 2]]> {
        None
    }
}
