//! The rival of the vehicle model: an occupancy grid, and boxes along principal axes.

use detector::classify::paper_model::NO_VEHICLE;
use detector::classify::size_gate::{SizeGateParams, size_gate};
use detector::classify::vehicle_model::class_by_decision;
use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock};
use detector::drawn::point_clusters::point_clusters;
use detector::drawn::surfaces::{class_by_cell, surface_cells};
use detector::fit::principal_axes_box::principal_axes_box;
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use detector::segment::clusters::Clusters;
use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::{Detection, Detector, OrientedBox, PointCloud, StageProduct, stage};

use crate::COMPONENTS;
use crate::occupancy_grid_components::OccupancyGridComponents;
use crate::params::{ClusterExtentParams, PcaParams};
use crate::pca_features::N_PCA_FEATURES;
use crate::pca_vehicle_model::PcaVehicleModel;

/// Objects as components of occupied cells, with boxes along their principal axes.
///
/// The grid takes all that stands on the street, façades included; what is longer than a vehicle can be is dropped and
/// reported. Vehicles are told by how their points lie in their neighbourhoods, or by the size gate that all detectors
/// share.
///
/// Paper: VM sections 1 and 6, the method it compares with.
#[derive(Debug, Clone)]
pub struct PcaDetector {
    params: PcaParams,
    vehicle_size: SizeGateParams,
    grid: HierarchicalGrid,
    components: OccupancyGridComponents,
    clusters: Clusters,
    dropped: Vec<usize>,
    objects: Vec<FittedObject>,
    object_points: Vec<u32>,
    vehicle_model: Option<PcaVehicleModel>,
    values: Vec<Option<[f32; N_PCA_FEATURES]>>,
}

/// A cluster whose size is right, with its box.
#[derive(Debug, Clone)]
struct FittedObject {
    cluster_idx: usize,
    bounding_box: OrientedBox,
}

impl PcaDetector {
    /// A detector that calls vehicles what has the size of one by `vehicle_size`.
    pub fn new(params: PcaParams, vehicle_size: SizeGateParams) -> Self {
        // Only the coarse level of the grid is used.
        let grid = GridParams { cell_size_m: params.grid.cell_size_m, xi: 1, extent_m: params.grid.extent_m };
        Self {
            params,
            vehicle_size,
            grid: HierarchicalGrid::new(grid),
            components: OccupancyGridComponents::default(),
            clusters: Clusters::default(),
            dropped: Vec::new(),
            objects: Vec::new(),
            object_points: Vec::new(),
            vehicle_model: None,
            values: Vec::new(),
        }
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: PcaVehicleModel) -> Self {
        self.vehicle_model = Some(model);
        self
    }
}

impl Detector for PcaDetector {
    fn name(&self) -> &'static str {
        "pca"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.grid.fill(cloud);
        clock.lap(stage::GRID, &mut output.stage_times);
        self.components.find_occupied(&self.grid, &self.params.occupancy);
        clock.lap(stage::FOREGROUND, &mut output.stage_times);
        self.components.connect(&self.grid);
        let labels = self.components.component_of_point().iter().copied();
        self.clusters.group(labels, self.components.occupied().len());
        clock.lap(COMPONENTS, &mut output.stage_times);
        self.fit_boxes(cloud, output);
        clock.lap(stage::BOXES, &mut output.stage_times);
        if self.vehicle_model.is_some() {
            self.describe(cloud);
            clock.lap(stage::FEATURES, &mut output.stage_times);
        }
        self.classify(output);
        clock.lap(stage::CLASSIFICATION, &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let class_of = |cell_idx| self.class_of_cell(cell_idx);
        let cells = surface_cells(&self.grid, class_of);
        let points = Shape::LabeledPoints(class_by_cell(&self.grid, class_of));
        let points_of = |cluster_idx| self.point_indices_of(cluster_idx);
        let kept = self.objects.iter().map(|object| points_of(object.cluster_idx));
        let clusters = point_clusters(cloud.len(), kept);
        let dropped = point_clusters(cloud.len(), self.dropped.iter().copied().map(points_of));
        let boxes = Shape::Boxes(self.objects.iter().map(|object| object.bounding_box).collect());
        let rectangles = self.objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        vec![
            StageProduct { stage: stage::FOREGROUND, name: "cells", shape: cells },
            StageProduct { stage: stage::FOREGROUND, name: "points", shape: points },
            StageProduct { stage: COMPONENTS, name: "dropped_clusters", shape: dropped },
            StageProduct { stage: COMPONENTS, name: "clusters", shape: clusters },
            StageProduct { stage: stage::BOXES, name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: stage::BOXES, name: "boxes", shape: boxes },
        ]
    }
}

impl PcaDetector {
    fn fit_boxes(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        self.dropped.clear();
        self.objects.clear();
        let point_indices = self.components.point_indices();
        for (cluster_idx, members) in self.clusters.iter().enumerate() {
            let n_points = members.len();
            let positions_m =
                members.iter().map(|&place| cloud.position_m(point_indices[place as usize] as usize));
            let bounding_box = principal_axes_box(positions_m).expect("no cluster is without points");
            match self.params.cluster.reason_to_drop(n_points, &bounding_box) {
                None => self.objects.push(FittedObject { cluster_idx, bounding_box }),
                Some(reason) => {
                    output.dropped_clusters.push(DroppedCluster { n_points, reason });
                    self.dropped.push(cluster_idx);
                }
            }
        }
    }

    /// Computes what the model looks at, object by object.
    fn describe(&mut self, cloud: &PointCloud) {
        let Self { components, clusters, objects, values, vehicle_model: Some(model), .. } = self else {
            return;
        };
        let point_indices = components.point_indices();
        values.clear();
        values.extend(objects.iter().map(|FittedObject { cluster_idx, bounding_box }| {
            let members = clusters.members(*cluster_idx).iter();
            let positions_m = members.map(|&place| cloud.position_m(point_indices[place as usize] as usize));
            model.values(bounding_box, positions_m)
        }));
    }

    /// By the model (VM section 6) if there is one, else by size.
    fn classify(&mut self, output: &mut DetectorOutput) {
        let point_indices = self.components.point_indices();
        for (object_idx, FittedObject { cluster_idx, bounding_box }) in self.objects.iter().enumerate() {
            let members = self.clusters.members(*cluster_idx);
            let (n_points, sizes) = (members.len(), &self.vehicle_size);
            let (class, score) = match &self.vehicle_model {
                Some(model) => {
                    let decision = self.values[object_idx].map(|it| model.decision_on(&it));
                    (class_by_decision(decision, n_points, sizes.min_points), decision)
                }
                None => (size_gate(n_points, bounding_box, sizes), None),
            };
            self.object_points.clear();
            self.object_points.extend(members.iter().map(|&place| point_indices[place as usize]));
            let (point_indices, bounding_box) = (&self.object_points[..], *bounding_box);
            let detection = Detection::new(point_indices, bounding_box, class, score);
            output.push_ranked(detection, NO_VEHICLE);
        }
    }

    /// The points of a cluster in the scan, ascending.
    fn point_indices_of(&self, cluster_idx: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        let point_indices = self.components.point_indices();
        self.clusters.members(cluster_idx).iter().map(|&place| point_indices[place as usize])
    }

    /// What stands is drawn like short objects, since this grid knows no other class.
    fn class_of_cell(&self, cell_idx: u32) -> SurfaceClass {
        if self.components.is_occupied(cell_idx) { SurfaceClass::Short } else { SurfaceClass::Ground }
    }
}

impl ClusterExtentParams {
    fn reason_to_drop(&self, n_points: usize, bounding_box: &OrientedBox) -> Option<DropReason> {
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        if n_points < self.min_points {
            Some(DropReason::TooFewPoints)
        } else if length_m.max(width_m) > self.max_extent_m {
            Some(DropReason::TooLarge)
        } else {
            None
        }
    }
}
