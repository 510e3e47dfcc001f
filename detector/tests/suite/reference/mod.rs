//! The method once more, written to be read: point by point, in sorted maps, with nothing kept from scan to scan.
//!
//! The detector has to find the same, to the bit. Each stage is a file, and a criterion stands in one file.

mod cells;
mod density;
mod terrain;
mod classes;
mod walls;
mod foreground;
mod merge;
mod separation;
mod boxes;
pub mod completion;
pub mod twins;

use detector::classify::size_gate::{SizeGateParams, size_gate};
use detector::params::HierarchicalParams;
use detector::params::front_end::FrontEndParams;
use detector::params::paper::PaperParams;
use detector::surface_class::SurfaceClass;
use detector::{DetectedClass, OrientedBox, PointCloud};

/// The parameters of the detector of the papers.
pub struct Params {
    pub of_papers: PaperParams,
    pub front_end: FrontEndParams,
    pub vehicle_size: SizeGateParams,
}

impl Params {
    pub fn new(of_papers: PaperParams, of_sensor: &HierarchicalParams) -> Self {
        let (front_end, vehicle_size) = (of_papers.front_end(of_sensor), of_sensor.vehicle_size.clone());
        Self { of_papers, front_end, vehicle_size }
    }
}

/// What the reference finds in a scan.
#[derive(Debug, PartialEq)]
pub struct Found {
    /// The class of every point.
    pub point_classes: Vec<SurfaceClass>,
    /// Number of links between coarse cells that the separation cuts.
    pub n_cuts: usize,
    /// The points of every cluster, ascending; clusters in the order of their first point.
    pub clusters: Vec<Vec<u32>>,
    /// The clusters that are large enough, in order.
    pub objects: Vec<FoundObject>,
}

/// A cluster that is an object.
#[derive(Debug, PartialEq)]
pub struct FoundObject {
    pub point_indices: Vec<u32>,
    pub bounding_box: OrientedBox,
    /// Corners of its convex hull, counter-clockwise.
    pub hull_m: Vec<[f32; 2]>,
    pub class: DetectedClass,
}

/// Finds the objects of `cloud`.
pub fn detect(cloud: &PointCloud, all: &Params, sensor_height_m: f32) -> Found {
    let params = &all.front_end;
    let cells = cells::coarse_cells(cloud, &params.grid);
    let terrain = terrain::Terrain::grown(&cells, params, sensor_height_m);
    let classes = classes::cell_classes(&cells, &terrain, params, sensor_height_m);
    let classes = walls::refine(cloud, classes, params, sensor_height_m);
    let foreground = foreground::foreground(cloud, &cells, &classes, &terrain, &params.foreground);
    let links = merge::links(cloud, &foreground, &all.of_papers.merge);
    let separated = separation::separate(cloud, &foreground, &links, all);
    let large =
        separated.clusters.iter().filter(|cluster| cluster.points.len() >= all.of_papers.cluster.min_points);
    let objects = large.map(|cluster| {
        let point_indices = cluster.points.clone();
        let (bounding_box, hull_m) = boxes::bounding_box(cloud, cluster);
        let class = size_gate(point_indices.len(), &bounding_box, &all.vehicle_size);
        FoundObject { point_indices, bounding_box, hull_m, class }
    });
    Found {
        point_classes: foreground::point_classes(cloud.len(), &cells, &classes, &foreground),
        n_cuts: separated.n_cuts,
        objects: objects.collect(),
        clusters: separated.clusters.iter().map(|cluster| cluster.points.clone()).collect(),
    }
}
