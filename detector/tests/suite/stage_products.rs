//! What each stage of the detector of the papers makes of a drawn street.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use detector::params::HierarchicalParams;
use detector::pipeline::paper_detector::paper;
use detector::stage_product::Shape;
use detector::{Detector, DetectorOutput, OrientedBox, PointCloud};

use crate::drawn_street::{SENSOR_HEIGHT_M, main_road};
use crate::same_as_reference::beyond_papers;

/// Stage products and detections of `cloud` in words, lengths and angles with two decimals.
fn described(cloud: &PointCloud) -> String {
    let mut detector = paper(&beyond_papers(), &HierarchicalParams::shipped(), None, SENSOR_HEIGHT_M);
    let mut output = DetectorOutput::default();
    detector.detect(cloud, &mut output);
    let mut text = String::new();
    for product in detector.stage_products(cloud) {
        let _ = writeln!(text, "{}/{}: {}", product.stage, product.name, shape_in_words(&product.shape));
    }
    for detection in output.detections.iter() {
        let (n_points, class) = (detection.point_indices.len(), detection.class.name());
        let _ = writeln!(text, "{class} of {n_points} points, {}", box_in_words(&detection.bounding_box));
    }
    let _ = writeln!(text, "dropped clusters: {}", output.dropped_clusters.len());
    text
}

fn shape_in_words(shape: &Shape) -> String {
    match shape {
        Shape::LabeledPoints(classes) => counts_in_words(classes.iter().map(|class| class.name())),
        Shape::Cells { cells, .. } => counts_in_words(cells.iter().map(|cell| cell.class.name())),
        Shape::Clusters(cluster_of_point) => {
            let mut n_points: BTreeMap<u32, usize> = BTreeMap::new();
            for cluster_idx in cluster_of_point.iter().flatten() {
                *n_points.entry(*cluster_idx).or_default() += 1;
            }
            let sizes: Vec<String> = n_points.values().map(usize::to_string).collect();
            format!("{} of {} points", sizes.len(), sizes.join(", "))
        }
        Shape::Segments(segments) => format!("{} segments", segments.len()),
        Shape::Boxes(boxes) => format!("{} boxes", boxes.len()),
        Shape::Spheres(spheres) => {
            let radii_m: Vec<String> = spheres.iter().map(|it| rounded(it.radius_m)).collect();
            format!("{} with radii {}", spheres.len(), radii_m.join(", "))
        }
        Shape::Links(links) => counts_in_words(links.iter().map(|link| link.fate.name())),
        Shape::ObjectCells { cell_size_m, cells } => {
            let objects: BTreeSet<u32> = cells.iter().map(|cell| cell.object).collect();
            format!("{} of {} m and {} objects", cells.len(), rounded(*cell_size_m), objects.len())
        }
        Shape::Contours(contours) => {
            let n_corners: Vec<String> = contours.iter().map(|it| it.len().to_string()).collect();
            format!("{} of {} corners", contours.len(), n_corners.join(", "))
        }
    }
}

fn counts_in_words(names: impl Iterator<Item = &'static str>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    counts.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
}

fn box_in_words(bounding_box: &OrientedBox) -> String {
    let [x, y, z] = bounding_box.center_m.map(rounded);
    let [length, width, height] = bounding_box.length_width_height_m.map(rounded);
    let yaw = rounded(bounding_box.yaw_rad.to_degrees());
    format!("centre {x} {y} {z} m, {length} x {width} x {height} m, yaw {yaw} degrees")
}

/// Two decimals, and no sign on a zero.
fn rounded(value: f32) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".to_owned() } else { text }
}

#[test]
fn a_main_road_comes_apart_into_cars_person_pole_and_facade() {
    insta::assert_snapshot!(described(&main_road()), @r"
    walls/cells: 84 clutter, 1406 ground, 117 short object, 83 tall, 44 wall
    walls/segments: 1 segments
    foreground/points: 249 clutter, 13608 ground, 5135 short object, 40905 tall, 396 wall
    merge/links: 11 link cut, 205 link kept
    separation/dense_cells: 463 of 0.20 m and 3 objects
    separation/cuts: 11 segments
    separation/clusters: 3 of 2492, 2287, 356 points
    boxes/hulls: 3 of 4, 4, 4 corners
    boxes/rectangles: 3 of 4, 4, 4 corners
    boxes/boxes: 3 boxes
    vehicle of 2492 points, centre 6.20 3.00 -0.88 m, 4.20 x 1.80 x 1.30 m, yaw 0.00 degrees
    vehicle of 2287 points, centre 10.70 3.10 -0.88 m, 4.00 x 1.80 x 1.30 m, yaw 0.00 degrees
    object of 356 points, centre 5.45 -4.10 -0.73 m, 0.50 x 0.40 x 1.60 m, yaw 0.00 degrees
    dropped clusters: 0
    ");
}
