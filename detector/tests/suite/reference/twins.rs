//! Holding the detector against the reference.

use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::pipeline::hierarchical_detector::HierarchicalDetector;
use detector::pipeline::paper_detector::PaperDetector;
use detector::stage_product::{Shape, StageProduct};
use detector::surface_class::SurfaceClass;
use detector::{Detector, DetectorOutput, PointCloud};

use super::{Found, FoundObject};

/// A detector and the reference with the same parameters.
pub struct Twins {
    params: HierarchicalParams,
    sensor_height_m: f32,
    detector: Box<dyn Detector>,
    output: DetectorOutput,
}

impl Twins {
    pub fn new(params: HierarchicalParams, sensor_height_m: f32) -> Self {
        let detector = HierarchicalDetector::new(params.clone(), sensor_height_m);
        Self { params, sensor_height_m, detector: Box::new(detector), output: DetectorOutput::default() }
    }

    /// The detector of the papers, and the reference with its readings.
    pub fn of_papers(sensor_height_m: f32) -> Self {
        let (params, of_sensor) = (PaperParams::shipped(), HierarchicalParams::shipped());
        let detector = PaperDetector::new(&params, &of_sensor, sensor_height_m);
        let params = params.stages(&of_sensor);
        Self { params, sensor_height_m, detector: Box::new(detector), output: DetectorOutput::default() }
    }

    /// Checks that both find the same in `cloud`; the detector has its buffers from the clouds before. Returns the number of objects.
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
            expected.clusters.iter().map(Vec::len).filter(|&n| n < self.params.cluster.min_points);
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

fn shape<'a>(products: &'a [StageProduct], name: &str) -> &'a Shape {
    &products.iter().find(|product| product.name == name).expect("the product").shape
}

fn labels(products: &[StageProduct], name: &str) -> Vec<SurfaceClass> {
    let Shape::LabeledPoints(classes) = shape(products, name) else { panic!("{name} are no labels") };
    classes.clone()
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
