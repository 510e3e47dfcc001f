//! The rival of the hierarchical grid: components of points over a kd-tree.

use std::ops::Range;

use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock, StageTime};
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use detector::pipeline::vehicle_model::{VehicleModel, classify_object};
use detector::segment::clusters::Clusters;
use detector::stage_product::{Shape, SurfaceClass};
use detector::{Detection, Detector, OrientedBox, PointCloud, StageProduct};

use crate::kd_tree_components::{KdTreeScratch, kd_tree_components};
use crate::params::{ForegroundChoice, KdTreeParams};

/// Objects as Euclidean components of points.
///
/// Foreground, boxes and classes are those of the hierarchical detector, so that a comparison of the two is about the
/// clusters. All buffers but the tree are used again for the next scan.
///
/// Paper: HG section 5, the method it compares with; boxes as VM section 4.
#[derive(Debug, Clone)]
pub struct KdTreeDetector {
    params: KdTreeParams,
    short_objects: ForegroundStages,
    finite_points: Vec<u32>,
    positions_m: Vec<[f32; 3]>,
    scratch: KdTreeScratch,
    labels: Vec<u32>,
    clusters: Clusters,
    dropped: Vec<usize>,
    box_fit: ConvexHullBox,
    objects: Vec<FittedObject>,
    hulls_m: Vec<[f32; 2]>,
    object_points: Vec<u32>,
    vehicle_model: Option<VehicleModel>,
}

/// A cluster whose size is right, with its box.
#[derive(Debug, Clone)]
struct FittedObject {
    cluster_idx: usize,
    bounding_box: OrientedBox,
    /// Its hull within `hulls_m`.
    hull: Range<usize>,
}

impl KdTreeDetector {
    /// A detector for a sensor `sensor_height_m` above the road; `shared` are the parameters of the stages that it has
    /// in common with the hierarchical detector.
    pub fn new(params: KdTreeParams, mut shared: HierarchicalParams, sensor_height_m: f32) -> Self {
        shared.walls.enabled &= params.foreground == ForegroundChoice::Refined;
        Self {
            params,
            short_objects: ForegroundStages::new(shared, sensor_height_m),
            finite_points: Vec::new(),
            positions_m: Vec::new(),
            scratch: KdTreeScratch::default(),
            labels: Vec::new(),
            clusters: Clusters::default(),
            dropped: Vec::new(),
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

impl Detector for KdTreeDetector {
    fn name(&self) -> &'static str {
        "kd-tree"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.find_foreground(cloud, &mut clock, &mut output.stage_times);
        self.find_components(cloud);
        clock.lap("components", &mut output.stage_times);
        self.fit_boxes(output);
        clock.lap("boxes", &mut output.stage_times);
        self.classify(output);
        clock.lap("classify", &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => self.short_objects.stage_products(),
            ForegroundChoice::All => vec![StageProduct {
                stage: "foreground",
                name: "points",
                shape: Shape::LabeledPoints(self.finite_point_classes(cloud.len())),
            }],
        };
        let kept = self.objects.iter().map(|object| object.cluster_idx);
        let clusters = Shape::Clusters(self.cluster_of_point(cloud.len(), kept));
        let dropped = Shape::Clusters(self.cluster_of_point(cloud.len(), self.dropped.iter().copied()));
        let hulls = Shape::Contours(self.objects.iter().map(|object| self.hull(object)).collect());
        let rectangles = self.objects.iter().map(|object| object.bounding_box.bottom_m().to_vec()).collect();
        let boxes = Shape::Boxes(self.objects.iter().map(|object| object.bounding_box).collect());
        products.extend([
            StageProduct { stage: "components", name: "dropped_clusters", shape: dropped },
            StageProduct { stage: "components", name: "clusters", shape: clusters },
            StageProduct { stage: "boxes", name: "hulls", shape: hulls },
            StageProduct { stage: "boxes", name: "rectangles", shape: Shape::Contours(rectangles) },
            StageProduct { stage: "boxes", name: "boxes", shape: boxes },
        ]);
        if let Some(model) = &self.vehicle_model {
            let positions_m = |object: &FittedObject| {
                let members = self.clusters.members(object.cluster_idx).iter();
                members.map(|&place| self.positions_m[place as usize])
            };
            let objects = self.objects.iter().map(|object| (object.bounding_box, positions_m(object)));
            products.extend(model.stage_products(objects));
        }
        products
    }
}

impl KdTreeDetector {
    fn find_foreground(
        &mut self,
        cloud: &PointCloud,
        clock: &mut StageClock,
        stage_times: &mut Vec<StageTime>,
    ) {
        match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => {
                self.short_objects.run(cloud, clock, stage_times);
            }
            ForegroundChoice::All => {
                self.finite_points.clear();
                let positions_m = (0..).zip(cloud.positions_m());
                let finite = positions_m.filter(|(_, position_m)| position_m.iter().all(|it| it.is_finite()));
                self.finite_points.extend(finite.map(|(point_idx, _)| point_idx));
                clock.lap("foreground", stage_times);
            }
        }
    }

    /// Indices of the foreground points in the latest scan, ascending.
    fn foreground_points(&self) -> &[u32] {
        match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => self.short_objects.point_indices(),
            ForegroundChoice::All => &self.finite_points,
        }
    }

    fn find_components(&mut self, cloud: &PointCloud) {
        let mut positions_m = std::mem::take(&mut self.positions_m);
        positions_m.clear();
        let points = self.foreground_points().iter();
        positions_m.extend(points.map(|&point_idx| cloud.position_m(point_idx as usize)));
        kd_tree_components(&positions_m, self.params.tolerance_m, &mut self.scratch, &mut self.labels);
        self.clusters.group(self.labels.iter().copied(), positions_m.len());
        self.positions_m = positions_m;
    }

    fn fit_boxes(&mut self, output: &mut DetectorOutput) {
        self.dropped.clear();
        self.objects.clear();
        self.hulls_m.clear();
        for (cluster_idx, members) in self.clusters.iter().enumerate() {
            let n_points = members.len();
            if let Some(reason) = self.params.reason_to_drop(n_points) {
                output.dropped_clusters.push(DroppedCluster { n_points, reason });
                self.dropped.push(cluster_idx);
                continue;
            }
            let positions_m = members.iter().map(|&place| self.positions_m[place as usize]);
            let mut z_range_m = [f32::INFINITY, f32::NEG_INFINITY];
            for [_, _, z_m] in positions_m.clone() {
                z_range_m = [z_range_m[0].min(z_m), z_range_m[1].max(z_m)];
            }
            let bounding_box = self
                .box_fit
                .fit(positions_m.map(|[x_m, y_m, _]| [x_m, y_m]), z_range_m)
                .expect("no cluster is without points");
            let hull_start = self.hulls_m.len();
            self.hulls_m.extend_from_slice(self.box_fit.hull_m());
            let hull = hull_start..self.hulls_m.len();
            self.objects.push(FittedObject { cluster_idx, bounding_box, hull });
        }
    }

    fn classify(&mut self, output: &mut DetectorOutput) {
        let mut object_points = std::mem::take(&mut self.object_points);
        let mut model = self.vehicle_model.take();
        for FittedObject { cluster_idx, bounding_box, .. } in &self.objects {
            let members = self.clusters.members(*cluster_idx);
            object_points.clear();
            object_points.extend(members.iter().map(|&place| self.foreground_points()[place as usize]));
            let positions_m = members.iter().map(|&place| self.positions_m[place as usize]);
            let sizes = &self.short_objects.params().vehicle_size;
            let object_box = (bounding_box, self.short_objects.ground_below_m(bounding_box));
            let (class, score) = classify_object(model.as_mut(), object_box, positions_m, sizes);
            output.detections.push(Detection {
                point_indices: &object_points,
                bounding_box: *bounding_box,
                class,
                score,
            });
        }
        self.object_points = object_points;
        self.vehicle_model = model;
    }

    fn finite_point_classes(&self, n_points: usize) -> Vec<SurfaceClass> {
        let mut classes = vec![SurfaceClass::Unseen; n_points];
        for &point_idx in &self.finite_points {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        classes
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
                cluster_of_point[self.foreground_points()[place as usize] as usize] = Some(number);
            }
        }
        cluster_of_point
    }

    fn hull(&self, object: &FittedObject) -> Vec<[f32; 3]> {
        let [_, _, height_m] = object.bounding_box.length_width_height_m;
        let bottom_m = object.bounding_box.center_m[2] - height_m / 2.0;
        self.hulls_m[object.hull.clone()].iter().map(|&[x_m, y_m]| [x_m, y_m, bottom_m]).collect()
    }
}

impl KdTreeParams {
    fn reason_to_drop(&self, n_points: usize) -> Option<DropReason> {
        if n_points < self.min_points {
            Some(DropReason::TooFewPoints)
        } else if n_points > self.max_points {
            Some(DropReason::TooManyPoints)
        } else {
            None
        }
    }
}
