//! Holding the detectors against the reference.

use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::pipeline::frame::{Blobs, Groups};
use detector::pipeline::paper_detector::paper;
use detector::pipeline::stage_list::Pipeline;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use detector::stage_product::{Shape, StageProduct};
use detector::surface_class::SurfaceClass;
use detector::whole::reported_boxes::BoxParams;
use detector::{Detector, DetectorOutput, OrientedBox, PointCloud};

use super::{Found, FoundObject, Params};

/// The detector of the papers and the reference with the same parameters.
pub struct Twins {
    params: Params,
    sensor_height_m: f32,
    detector: Pipeline<Blobs>,
    output: DetectorOutput,
}

impl Twins {
    pub fn new(params: PaperParams, sensor_height_m: f32) -> Self {
        let of_sensor = HierarchicalParams::shipped();
        let detector = paper(&params, &of_sensor, None, sensor_height_m);
        let params = Params::new(params, &of_sensor);
        Self { params, sensor_height_m, detector, output: DetectorOutput::default() }
    }

    /// Checks that both find the same in `cloud`; the detector has its buffers from the clouds before. Returns the number of
    /// objects.
    #[track_caller]
    pub fn check(&mut self, cloud: &PointCloud, name: &str) -> usize {
        let expected = super::detect(cloud, &self.params, self.sensor_height_m);
        self.detector.detect(cloud, &mut self.output);
        let found = self.found(cloud);
        assert_eq!(found.point_classes, expected.point_classes, "classes of the points of {name}");
        assert_eq!(found.n_cuts, expected.n_cuts, "cuts in {name}");
        assert_eq!(found.clusters, expected.clusters, "clusters of {name}");
        assert_eq!(found.objects.len(), expected.objects.len(), "number of objects of {name}");
        for (found, expected) in found.objects.iter().zip(&expected.objects) {
            assert_eq!(found, expected, "an object of {name}");
        }
        let too_small =
            expected.clusters.iter().map(Vec::len).filter(|&n| n < self.params.of_papers.cluster.min_points);
        assert!(self.output.dropped_clusters.iter().map(|it| it.n_points).eq(too_small), "drops of {name}");
        found.objects.len()
    }

    fn found(&self, cloud: &PointCloud) -> Found {
        let products = self.detector.stage_products(cloud);
        let hulls_m = contours(&products, "hulls");
        let objects = self.output.detections.iter().zip(hulls_m).map(|(detection, hull_m)| FoundObject {
            point_indices: detection.point_indices.to_vec(),
            bounding_box: detection.bounding_box,
            hull_m: hull_m.iter().map(|&[x, y, _]| [x, y]).collect(),
            class: detection.class,
        });
        Found {
            point_classes: labels(&products, "points"),
            n_cuts: n_segments(&products, "cuts"),
            clusters: clusters(&products, "clusters"),
            objects: objects.collect(),
        }
    }
}

/// The completion of the best cut's objects, and the reference of it.
pub struct CompletionTwins {
    params: HierarchicalParams,
    sensor_height_m: f32,
    whole: Pipeline<Groups>,
    as_cut: Pipeline<Groups>,
}

impl CompletionTwins {
    pub fn new(mut params: HierarchicalParams, sensor_height_m: f32) -> Self {
        // Boxes as completion leaves them.
        params.boxes = BoxParams { outline: false, whole: false };
        let models = || GroupModels::shipped(VehiclesBy::Size);
        let detector = |params| hierarchical(params, models(), sensor_height_m);
        let mut without = params.clone();
        without.completion.enabled = false;
        Self { whole: detector(&params), as_cut: detector(&without), params, sensor_height_m }
    }

    /// Checks that both give the objects of `cloud` the same points. Returns how many they give.
    #[track_caller]
    pub fn check(&mut self, cloud: &PointCloud, name: &str) -> usize {
        let [completed, mut expected] = [&mut self.whole, &mut self.as_cut].map(|it| found_by(it, cloud));
        let n_points =
            |objects: &[(Vec<u32>, OrientedBox)]| objects.iter().map(|it| it.0.len()).sum::<usize>();
        let n_before = n_points(&expected);
        super::completion::complete(cloud, &self.params, self.sensor_height_m, &mut expected);
        assert_eq!(completed, expected, "objects of {name}");
        n_points(&completed) - n_before
    }
}

fn found_by(detector: &mut Pipeline<Groups>, cloud: &PointCloud) -> Vec<(Vec<u32>, OrientedBox)> {
    let mut output = DetectorOutput::default();
    detector.detect(cloud, &mut output);
    output.detections.iter().map(|it| (it.point_indices.to_vec(), it.bounding_box)).collect()
}

fn shape<'a>(products: &'a [StageProduct], name: &str) -> &'a Shape {
    &products.iter().find(|product| product.name == name).expect("the product").shape
}

fn labels(products: &[StageProduct], name: &str) -> Vec<SurfaceClass> {
    let Shape::LabeledPoints(classes) = shape(products, name) else { panic!("{name} are no labels") };
    // A wall is tall, wherever its class comes from.
    let tall_walls = |&class: &_| if class == SurfaceClass::Wall { SurfaceClass::Tall } else { class };
    classes.iter().map(tall_walls).collect()
}

fn n_segments(products: &[StageProduct], name: &str) -> usize {
    let Shape::Segments(segments) = shape(products, name) else { panic!("{name} are no segments") };
    segments.len()
}

fn contours<'a>(products: &'a [StageProduct], name: &str) -> &'a [Vec<[f32; 3]>] {
    let Shape::Contours(contours) = shape(products, name) else { panic!("{name} are no contours") };
    contours
}

fn clusters(products: &[StageProduct], name: &str) -> Vec<Vec<u32>> {
    let Shape::Clusters(cluster_of_point) = shape(products, name) else { panic!("{name} are no clusters") };
    let n_clusters = cluster_of_point.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut clusters = vec![Vec::new(); n_clusters];
    for (point_idx, cluster) in (0..).zip(cluster_of_point) {
        if let Some(cluster) = cluster {
            clusters[*cluster as usize].push(point_idx);
        }
    }
    clusters
}
