//! The rival of the vehicle model: an occupancy grid, and boxes along principal axes.

use detector::classify::size_gate::{SizeGateParams, size_gate};
use detector::classify::vehicle_model::class_by_decision;
use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock};
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid, NO_CELL};
use detector::segment::clusters::Clusters;
use detector::stage_product::{ProductCell, Shape};
use detector::surface_class::SurfaceClass;
use detector::{Detection, Detector, OrientedBox, PointCloud, StageProduct};

use crate::occupancy_grid_components::OccupancyGridComponents;
use crate::params::{ClusterExtentParams, PcaParams};
use crate::pca_vehicle_model::PcaVehicleModel;
use crate::principal_axes_box::principal_axes_box;

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
        clock.lap("grid", &mut output.stage_times);
        self.components.find_occupied(&self.grid, &self.params.occupancy);
        clock.lap("foreground", &mut output.stage_times);
        self.components.connect(&self.grid);
        let labels = self.components.component_of_point().iter().copied();
        self.clusters.group(labels, self.components.occupied().len());
        clock.lap("components", &mut output.stage_times);
        self.fit_boxes(cloud, output);
        clock.lap("boxes", &mut output.stage_times);
        self.classify(cloud, output);
        clock.lap("classify", &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let kept = self.objects.iter().map(|object| object.cluster_idx);
        let clusters = Shape::Clusters(self.cluster_of_point(cloud.len(), kept));
        let dropped = Shape::Clusters(self.cluster_of_point(cloud.len(), self.dropped.iter().copied()));
        let boxes = Shape::Boxes(self.objects.iter().map(|object| object.bounding_box).collect());
        let rectangles = self.objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        vec![
            StageProduct { stage: "foreground", name: "cells", shape: self.cells() },
            StageProduct { stage: "foreground", name: "points", shape: self.labeled_points() },
            StageProduct { stage: "components", name: "dropped_clusters", shape: dropped },
            StageProduct { stage: "components", name: "clusters", shape: clusters },
            StageProduct { stage: "boxes", name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: "boxes", name: "boxes", shape: boxes },
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

    /// By the model (VM section 6) if there is one, else by size.
    fn classify(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        let point_indices = self.components.point_indices();
        for FittedObject { cluster_idx, bounding_box } in &self.objects {
            let members = self.clusters.members(*cluster_idx);
            self.object_points.clear();
            self.object_points.extend(members.iter().map(|&place| point_indices[place as usize]));
            let positions_m = self.object_points.iter().map(|&it| cloud.position_m(it as usize));
            let (n_points, sizes) = (members.len(), &self.vehicle_size);
            let (class, score) = match &mut self.vehicle_model {
                Some(model) => {
                    let decision = model.decision(bounding_box, positions_m);
                    (class_by_decision(decision, n_points, sizes.min_points), decision)
                }
                None => (size_gate(n_points, bounding_box, sizes), None),
            };
            output.detections.push(Detection {
                point_indices: &self.object_points,
                bounding_box: *bounding_box,
                class,
                score,
            });
        }
    }

    /// What stands is drawn like short objects, since this grid knows no other class.
    fn class_of_cell(&self, cell_idx: u32) -> SurfaceClass {
        if self.components.is_occupied(cell_idx) { SurfaceClass::Short } else { SurfaceClass::Ground }
    }

    fn cells(&self) -> Shape {
        let cells = self.grid.occupied().iter().map(|&cell_idx| {
            let cell = &self.grid.cells()[cell_idx as usize];
            ProductCell {
                center_m: self.grid.center_m(cell_idx),
                z_range_m: [cell.z_min_m, cell.z_max_m],
                class: self.class_of_cell(cell_idx),
            }
        });
        Shape::Cells { cell_size_m: self.grid.params().cell_size_m, cells: cells.collect() }
    }

    fn labeled_points(&self) -> Shape {
        let classes = self.grid.cell_of_point().iter().map(|&cell_idx| match cell_idx {
            NO_CELL => SurfaceClass::Unseen,
            _ => self.class_of_cell(cell_idx),
        });
        Shape::LabeledPoints(classes.collect())
    }

    /// For every point of the scan, its cluster among `cluster_indices`, numbered in their order.
    fn cluster_of_point(
        &self,
        n_points: usize,
        cluster_indices: impl Iterator<Item = usize>,
    ) -> Vec<Option<u32>> {
        let mut cluster_of_point = vec![None; n_points];
        for (number, cluster_idx) in (0..).zip(cluster_indices) {
            for &place in self.clusters.members(cluster_idx) {
                cluster_of_point[self.components.point_indices()[place as usize] as usize] = Some(number);
            }
        }
        cluster_of_point
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
