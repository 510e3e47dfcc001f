//! The detector of the paper.

use crate::detection::Detection;
use crate::detector::{Detector, DetectorOutput, DropReason, DroppedCluster, StageClock};
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::outline::Outline;
use crate::grid::dense_level::DenseLevel;
use crate::grid::density_weighting::DensityWeighting;
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::pipeline::foreground_stages::ForegroundStages;
use crate::pipeline::vehicle_model::{VehicleModel, classify_object};
use crate::point_cloud::PointCloud;
use crate::segment::connected_components::connected_components;
use crate::segment::dense_separation::DenseSeparation;
use crate::segment::merge_graph::merge_graph;
use crate::segment::object_cells::object_cells;
use crate::segment::object_points::ObjectPoints;
use crate::stage_product::{Shape, StageProduct};

/// Objects from a hierarchical grid.
///
/// Paper: HG sections 3 to 3.2; boxes as VM section 4.
#[derive(Debug, Clone)]
pub struct HierarchicalDetector {
    foreground: ForegroundStages,
    dense: DenseLevel,
    links: Vec<[u32; 2]>,
    separation: DenseSeparation,
    clusters: ObjectPoints,
    outline: Outline,
    box_fit: ConvexHullBox,
    objects: Vec<FittedObject>,
    hulls_m: Vec<[f32; 2]>,
    vehicle_model: Option<VehicleModel>,
}

/// A cluster that is large enough, with its box.
#[derive(Debug, Clone)]
struct FittedObject {
    cluster_idx: usize,
    bounding_box: OrientedBox,
    /// Its hull within `hulls_m`.
    hull: std::ops::Range<usize>,
}

impl HierarchicalDetector {
    /// A detector for a sensor `sensor_height_m` above the road.
    pub fn new(params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let weighting = DensityWeighting::new(&params.density_weighting);
        let separation = DenseSeparation::new(params.separation.clone(), &params.grid, &weighting);
        let outline = Outline::new(params.grid.xi);
        Self {
            foreground: ForegroundStages::new(params, sensor_height_m),
            dense: DenseLevel::default(),
            links: Vec::new(),
            separation,
            clusters: ObjectPoints::default(),
            outline,
            box_fit: ConvexHullBox::default(),
            objects: Vec::new(),
            hulls_m: Vec::new(),
            vehicle_model: None,
        }
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: VehicleModel) -> Self {
        self.vehicle_model = Some(model);
        self
    }
}

impl Detector for HierarchicalDetector {
    fn name(&self) -> &'static str {
        "hierarchical"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.foreground.run(cloud, &mut clock, &mut output.stage_times);
        let grid = self.foreground.grid();
        let params = self.foreground.params();
        self.dense.fill(grid, self.foreground.foreground_cells(), self.foreground.point_indices());
        clock.lap("dense_level", &mut output.stage_times);
        connected_components(grid, &self.dense, &params.merge, &mut self.links);
        clock.lap("merge", &mut output.stage_times);
        self.separation.separate(grid, &self.dense, &self.links);
        self.clusters.fill(cloud, self.foreground.point_indices(), &self.dense, &self.separation);
        clock.lap("separation", &mut output.stage_times);
        self.outline.mark(grid, &self.dense, self.separation.object_of_dense());
        self.fit_boxes(output);
        clock.lap("boxes", &mut output.stage_times);
        self.classify(output);
        clock.lap("classify", &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = self.foreground.stage_products();
        let cuts = self.separation.cut_links().iter().map(|&blocks| self.cut(blocks)).collect();
        let hulls = self.objects.iter().map(|object| self.hull(object)).collect();
        let rectangles = self.objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        let boxes = self.objects.iter().map(|object| object.bounding_box).collect();
        let grid = self.foreground.grid();
        products.extend([
            StageProduct {
                stage: "merge",
                name: "links",
                shape: merge_graph(grid, &self.dense, &self.links, self.separation.cut_links()),
            },
            StageProduct {
                stage: "separation",
                name: "dense_cells",
                shape: object_cells(grid, &self.dense, &self.clusters),
            },
            StageProduct { stage: "separation", name: "cuts", shape: Shape::Segments(cuts) },
            StageProduct {
                stage: "separation",
                name: "clusters",
                shape: Shape::Clusters(self.cluster_of_point(cloud.len())),
            },
            StageProduct { stage: "boxes", name: "hulls", shape: Shape::Contours(hulls) },
            StageProduct { stage: "boxes", name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: "boxes", name: "boxes", shape: Shape::Boxes(boxes) },
        ]);
        if let Some(model) = &self.vehicle_model {
            let positions_m = |object: &FittedObject| {
                self.clusters.points(object.cluster_idx).iter().map(|it| it.position_m)
            };
            let objects = self.objects.iter().map(|object| (object.bounding_box, positions_m(object)));
            products.extend(model.stage_products(objects));
        }
        products
    }
}

impl HierarchicalDetector {
    fn fit_boxes(&mut self, output: &mut DetectorOutput) {
        self.objects.clear();
        self.hulls_m.clear();
        for cluster_idx in 0..self.clusters.n_objects() {
            let points = self.clusters.points(cluster_idx);
            if points.len() < self.foreground.params().cluster.min_points {
                let reason = DropReason::TooFewPoints;
                output.dropped_clusters.push(DroppedCluster { n_points: points.len(), reason });
                continue;
            }
            let z_range_m = self.outline.gather(points);
            let outline_m = self.outline.points_m().iter().copied();
            let bounding_box =
                self.box_fit.fit(outline_m, z_range_m).expect("every object has cells on its outline");
            let hull_start = self.hulls_m.len();
            self.hulls_m.extend_from_slice(self.box_fit.hull_m());
            self.objects.push(FittedObject {
                cluster_idx,
                bounding_box,
                hull: hull_start..self.hulls_m.len(),
            });
        }
    }

    /// By the vehicle model (VM sections 4 and 5) if there is one, else by size.
    fn classify(&mut self, output: &mut DetectorOutput) {
        for object in &self.objects {
            let point_indices = self.clusters.point_indices(object.cluster_idx);
            let bounding_box = object.bounding_box;
            let positions_m = self.clusters.points(object.cluster_idx).iter().map(|it| it.position_m);
            let sizes = &self.foreground.params().vehicle_size;
            let object_box = (&bounding_box, self.foreground.ground_below_m(&bounding_box));
            let (class, score) = classify_object(self.vehicle_model.as_mut(), object_box, positions_m, sizes);
            output.detections.push(Detection { point_indices, bounding_box, class, score });
        }
    }

    /// The border between two neighbouring cells whose link was cut, drawn at the height of the lower one's top.
    fn cut(&self, blocks: [u32; 2]) -> [[f32; 3]; 2] {
        let grid = self.foreground.grid();
        let [a, b] = blocks.map(|block_idx| grid.center_m(self.dense.cell_of_block()[block_idx as usize]));
        let [top_a_m, top_b_m] = blocks.map(|block_idx| self.dense.z_max_m(block_idx));
        let top_m = top_a_m.min(top_b_m);
        let middle_m = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        // A quarter turn from the line between the centres, half as long to either side.
        let half_m = [0.5 * (a[1] - b[1]), 0.5 * (b[0] - a[0])];
        [1.0, -1.0].map(|side| [middle_m[0] + side * half_m[0], middle_m[1] + side * half_m[1], top_m])
    }

    fn hull(&self, object: &FittedObject) -> Vec<[f32; 3]> {
        let [_, _, center_z_m] = object.bounding_box.center_m;
        let bottom_m = center_z_m - object.bounding_box.length_width_height_m[2] / 2.0;
        self.hulls_m[object.hull.clone()].iter().map(|&[x, y]| [x, y, bottom_m]).collect()
    }

    fn cluster_of_point(&self, n_points: usize) -> Vec<Option<u32>> {
        let mut cluster_of_point = vec![None; n_points];
        for cluster_idx in 0..self.clusters.n_objects() {
            for &point_idx in self.clusters.point_indices(cluster_idx) {
                cluster_of_point[point_idx as usize] = Some(cluster_idx as u32);
            }
        }
        cluster_of_point
    }
}
