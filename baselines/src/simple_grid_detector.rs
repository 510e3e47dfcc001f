//! The ablation of the hierarchical grid: the same detector without its dense level.

use std::ops::Range;

use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock};
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::fit::outline::Outline;
use detector::grid::dense_level::DenseLevel;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use detector::pipeline::vehicle_model::{VehicleModel, classify_object};
use detector::segment::clusters::Clusters;
use detector::segment::connected_components::connected_components;
use detector::segment::disjoint_sets::DisjointSets;
use detector::segment::merge_graph::merge_graph;
use detector::segment::object_points::ObjectPoint;
use detector::stage_product::Shape;
use detector::{Detection, Detector, OrientedBox, PointCloud, StageProduct};

/// Objects as connected components of coarse cells.
///
/// Terrain, cell classes, foreground, merging of cells, boxes and classes are those of the hierarchical detector with the
/// same parameters; what a blob joins stays joined. A grid of one level is one whose coarse cells each hold a single
/// dense cell, so ξ is 1 whatever the parameters say.
///
/// Paper: HG section 3.2 and Fig. 7, the *Simple Grid Model*; boxes as VM section 4.
#[derive(Debug, Clone)]
pub struct SimpleGridDetector {
    foreground: ForegroundStages,
    cells: DenseLevel,
    links: Vec<[u32; 2]>,
    blobs: DisjointSets,
    blob_of_cell: Vec<u32>,
    clusters: Clusters,
    outline: Outline,
    members: Vec<ObjectPoint>,
    box_fit: ConvexHullBox,
    objects: Vec<FittedObject>,
    hulls_m: Vec<[f32; 2]>,
    object_points: Vec<u32>,
    vehicle_model: Option<VehicleModel>,
}

/// A cluster that is large enough, with its box.
#[derive(Debug, Clone)]
struct FittedObject {
    cluster_idx: usize,
    bounding_box: OrientedBox,
    /// Its hull within `hulls_m`.
    hull: Range<usize>,
}

impl SimpleGridDetector {
    /// A detector for a sensor `sensor_height_m` above the road; `shared` are the parameters of the hierarchical detector.
    pub fn new(mut shared: HierarchicalParams, sensor_height_m: f32) -> Self {
        shared.grid.xi = 1;
        Self {
            foreground: ForegroundStages::new(shared, sensor_height_m),
            cells: DenseLevel::default(),
            links: Vec::new(),
            blobs: DisjointSets::default(),
            blob_of_cell: Vec::new(),
            clusters: Clusters::default(),
            outline: Outline::new(1),
            members: Vec::new(),
            box_fit: ConvexHullBox::default(),
            objects: Vec::new(),
            hulls_m: Vec::new(),
            object_points: Vec::new(),
            vehicle_model: None,
        }
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: VehicleModel) -> Self {
        self.vehicle_model = Some(model);
        self
    }
}

impl Detector for SimpleGridDetector {
    fn name(&self) -> &'static str {
        "simple-grid"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.foreground.run(cloud, &mut clock, &mut output.stage_times);
        self.merge_cells();
        clock.lap("merge", &mut output.stage_times);
        self.outline.mark(self.foreground.grid(), &self.cells, &self.blob_of_cell);
        self.fit_boxes(cloud, output);
        clock.lap("boxes", &mut output.stage_times);
        self.classify(cloud, output);
        clock.lap("classify", &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = self.foreground.stage_products();
        let hulls = self.objects.iter().map(|object| self.hull(object)).collect();
        let boxes = self.objects.iter().map(|object| object.bounding_box).collect();
        let rectangles = self.objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        let clusters = Shape::Clusters(self.cluster_of_point(cloud.len()));
        let links = merge_graph(self.foreground.grid(), &self.cells, &self.links, &[]);
        products.extend([
            StageProduct { stage: "merge", name: "links", shape: links },
            StageProduct { stage: "merge", name: "clusters", shape: clusters },
            StageProduct { stage: "boxes", name: "hulls", shape: Shape::Contours(hulls) },
            StageProduct { stage: "boxes", name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: "boxes", name: "boxes", shape: Shape::Boxes(boxes) },
        ]);
        if let Some(model) = &self.vehicle_model {
            let point_indices = self.foreground.point_indices();
            let positions_m = |object: &FittedObject| {
                let members = self.clusters.members(object.cluster_idx).iter();
                members.map(|&place| cloud.position_m(point_indices[place as usize] as usize))
            };
            let objects = self.objects.iter().map(|object| (object.bounding_box, positions_m(object)));
            products.extend(model.stage_products(objects));
        }
        products
    }
}

impl SimpleGridDetector {
    fn merge_cells(&mut self) {
        let grid = self.foreground.grid();
        self.cells.fill(grid, self.foreground.foreground_cells(), self.foreground.point_indices());
        connected_components(grid, &self.cells, &self.foreground.params().merge, &mut self.links);
        let n_cells = self.cells.n_blocks();
        self.blobs.reset(n_cells);
        for &[cell, neighbor] in &self.links {
            self.blobs.join(cell, neighbor);
        }
        self.blob_of_cell.clear();
        self.blob_of_cell.extend((0..n_cells as u32).map(|cell| self.blobs.representative(cell)));
        let labels = self.cells.dense_of_point().iter().map(|&cell| self.blob_of_cell[cell as usize]);
        self.clusters.group(labels, n_cells);
    }

    fn fit_boxes(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        self.objects.clear();
        self.hulls_m.clear();
        let point_indices = self.foreground.point_indices();
        let cell_of_point = self.cells.dense_of_point();
        for (cluster_idx, members) in self.clusters.iter().enumerate() {
            let n_points = members.len();
            if n_points < self.foreground.params().cluster.min_points {
                output.dropped_clusters.push(DroppedCluster { n_points, reason: DropReason::TooFewPoints });
                continue;
            }
            self.members.clear();
            self.members.extend(members.iter().map(|&place| ObjectPoint {
                position_m: cloud.position_m(point_indices[place as usize] as usize),
                dense_idx: cell_of_point[place as usize],
            }));
            let z_range_m = self.outline.gather(&self.members);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let hull_start = self.hulls_m.len();
            self.hulls_m.extend_from_slice(self.box_fit.hull_m());
            let hull = hull_start..self.hulls_m.len();
            self.objects.push(FittedObject { cluster_idx, bounding_box, hull });
        }
    }

    fn classify(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        let point_indices = self.foreground.point_indices();
        for FittedObject { cluster_idx, bounding_box, .. } in &self.objects {
            let members = self.clusters.members(*cluster_idx);
            self.object_points.clear();
            self.object_points.extend(members.iter().map(|&place| point_indices[place as usize]));
            let positions_m = self.object_points.iter().map(|&it| cloud.position_m(it as usize));
            let sizes = &self.foreground.params().vehicle_size;
            let object_box = (bounding_box, self.foreground.ground_below_m(bounding_box));
            let (class, score) = classify_object(self.vehicle_model.as_mut(), object_box, positions_m, sizes);
            output.detections.push(Detection {
                point_indices: &self.object_points,
                bounding_box: *bounding_box,
                class,
                score,
            });
        }
    }

    fn hull(&self, object: &FittedObject) -> Vec<[f32; 3]> {
        let [_, _, height_m] = object.bounding_box.length_width_height_m;
        let bottom_m = object.bounding_box.center_m[2] - height_m / 2.0;
        self.hulls_m[object.hull.clone()].iter().map(|&[x_m, y_m]| [x_m, y_m, bottom_m]).collect()
    }

    /// For every point of the scan, the number of its object.
    fn cluster_of_point(&self, n_points: usize) -> Vec<Option<u32>> {
        let mut cluster_of_point = vec![None; n_points];
        for (object, number) in self.objects.iter().zip(0..) {
            for &place in self.clusters.members(object.cluster_idx) {
                cluster_of_point[self.foreground.point_indices()[place as usize] as usize] = Some(number);
            }
        }
        cluster_of_point
    }
}
