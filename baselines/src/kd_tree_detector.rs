//! The rival of the hierarchical grid: components of points over a kd-tree.

use std::ops::RangeInclusive;
use std::sync::Arc;

use detector::classify::vehicle_model::VehicleModel;
use detector::detector::{DetectorOutput, DropReason, DroppedCluster, StageClock, StageTime};
use detector::drawn::point_clusters::point_clusters;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use detector::pipeline::object_stages::ObjectStages;
use detector::segment::clusters::Clusters;
use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::whole::box_model::BoxModel;
use detector::{Detector, PointCloud, Rule, StageProduct, stage};

use crate::COMPONENTS;
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
    name: &'static str,
    params: KdTreeParams,
    short_objects: ForegroundStages,
    finite_points: Vec<u32>,
    positions_m: Vec<[f32; 3]>,
    scratch: KdTreeScratch,
    labels: Vec<u32>,
    clusters: Clusters,
    kept: Vec<usize>,
    dropped: Vec<usize>,
    box_fit: ConvexHullBox,
    objects: ObjectStages,
}

impl KdTreeDetector {
    /// A detector for a sensor `sensor_height_m` above the road; `shared` are the parameters of the stages that it has
    /// in common with the hierarchical detector.
    pub fn new(params: KdTreeParams, mut shared: HierarchicalParams, sensor_height_m: f32) -> Self {
        shared.walls.enabled &= params.foreground == ForegroundChoice::Refined;
        // Of the whole scan there is no grid to complete clusters from.
        shared.completion.enabled &= params.foreground != ForegroundChoice::All;
        let objects = ObjectStages::new(&shared, params.min_points);
        Self {
            name: "kd-tree",
            params,
            short_objects: ForegroundStages::new(shared, sensor_height_m),
            finite_points: Vec::new(),
            positions_m: Vec::new(),
            scratch: KdTreeScratch::default(),
            labels: Vec::new(),
            clusters: Clusters::default(),
            kept: Vec::new(),
            dropped: Vec::new(),
            box_fit: ConvexHullBox::default(),
            objects,
        }
    }

    /// The detector `kd-tree-same-walls`: like for like with the hierarchical one, it looks for walls before it clusters,
    /// whatever `params` say about the foreground.
    pub fn with_same_walls(
        mut params: KdTreeParams,
        shared: HierarchicalParams,
        sensor_height_m: f32,
    ) -> Self {
        params.foreground = ForegroundChoice::Refined;
        Self { name: "kd-tree-same-walls", ..Self::new(params, shared, sensor_height_m) }
    }

    /// The same detector, with the boxes of whole vehicles by `model`, if there is one.
    pub fn with_box_model(mut self, model: Option<Arc<BoxModel>>) -> Self {
        self.objects = self.objects.with_box_model(model);
        self
    }

    /// The same detector, which tells vehicles by `model` instead of by their size.
    pub fn with_vehicle_model(mut self, model: VehicleModel) -> Self {
        self.objects = self.objects.with_vehicle_model(model);
        self
    }
}

impl Detector for KdTreeDetector {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.find_foreground(cloud, &mut clock, &mut output.stage_times);
        self.find_components(cloud);
        clock.lap(COMPONENTS, &mut output.stage_times);
        self.fit_boxes(output);
        clock.lap(stage::BOXES, &mut output.stage_times);
        self.objects.finish(cloud, &self.short_objects, &mut clock, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut products = match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => self.short_objects.stage_products(),
            ForegroundChoice::All => vec![StageProduct {
                stage: stage::FOREGROUND,
                name: "points",
                shape: Shape::LabeledPoints(self.finite_point_classes(cloud.len())),
            }],
        };
        let point_indices = self.foreground_points();
        let of_points = |clusters: &[usize]| {
            let members = clusters.iter().map(|&cluster_idx| self.clusters.members(cluster_idx));
            let clusters = members.map(|it| it.iter().map(|&place| point_indices[place as usize]));
            point_clusters(cloud.len(), clusters)
        };
        products.extend([
            StageProduct { stage: COMPONENTS, name: "dropped_clusters", shape: of_points(&self.dropped) },
            StageProduct { stage: COMPONENTS, name: "clusters", shape: of_points(&self.kept) },
        ]);
        products.extend(self.objects.stage_products(cloud.len()));
        products
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => {
                Some(self.short_objects.ground_points(cloud))
            }
            ForegroundChoice::All => None,
        }
    }

    fn rules(&self) -> Vec<Rule> {
        let of_foreground = match self.params.foreground {
            ForegroundChoice::Short | ForegroundChoice::Refined => self.short_objects.rules(),
            ForegroundChoice::All => Vec::new(),
        };
        [of_foreground, self.objects.rules()].concat()
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
                clock.lap(stage::FOREGROUND, stage_times);
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
        self.kept.clear();
        self.dropped.clear();
        self.objects.clear();
        for (cluster_idx, members) in self.clusters.iter().enumerate() {
            let n_points = members.len();
            // As in PCL, a cluster of too many points is no object: a façade that is left in the foreground, or the road.
            if let Some(reason) = reason_to_drop(n_points, self.objects.min_points()..=self.params.max_points)
            {
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
            self.kept.push(cluster_idx);
            let foreground_points = match self.params.foreground {
                ForegroundChoice::Short | ForegroundChoice::Refined => self.short_objects.point_indices(),
                ForegroundChoice::All => &self.finite_points,
            };
            let points = members
                .iter()
                .map(|&place| (foreground_points[place as usize], self.positions_m[place as usize]));
            self.objects.add(points, bounding_box, self.box_fit.hull_m());
        }
    }

    fn finite_point_classes(&self, n_points: usize) -> Vec<SurfaceClass> {
        let mut classes = vec![SurfaceClass::Unseen; n_points];
        for &point_idx in &self.finite_points {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        classes
    }
}

fn reason_to_drop(n_points: usize, kept: RangeInclusive<usize>) -> Option<DropReason> {
    if n_points < *kept.start() {
        Some(DropReason::TooFewPoints)
    } else if n_points > *kept.end() {
        Some(DropReason::TooManyPoints)
    } else {
        None
    }
}
