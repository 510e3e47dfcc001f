//! A scan small enough to count its points: a level road with a car and a post on it, and a façade and a scrap beside it.
//!
//! Everything but the road is one cell wide. Cells of the grid have their centres at multiples of 0.6 m from 0.7 m.

use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::foreground;
use detector::pipeline::frame::Frame;
use detector::segment::foreground::Foreground;
use detector::{Detector, DetectorOutput, OrientedBox, PointCloud};
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::LabeledScan;

use crate::matching::drawn_labels::{annotation, labeled};

const SENSOR_HEIGHT_M: f32 = 1.73;
const N_ROAD_CELLS: u64 = 40 * 20;
/// Four points a cell.
pub const N_ROAD: u64 = 4 * N_ROAD_CELLS;
/// Points of the car, those inside its box.
pub const N_CAR: u64 = 12;
const N_POST: u64 = 10;
const N_FACADE: u64 = 10;
const N_SCRAP: u64 = 2;
/// All points.
pub const N_POINTS: u64 = N_ROAD + N_CAR + N_POST + N_FACADE + N_SCRAP;
/// Occupied cells: car and post stand on the road, façade and scrap beside it.
pub const N_CELLS: u64 = N_ROAD_CELLS + 2;
/// How far ahead the box of the car is.
pub const CAR_RANGE_M: f64 = 10.0;

/// The scan, with the car annotated; the annotation claims ten points only.
pub fn scan() -> LabeledScan {
    let first_of_car = N_ROAD as u32;
    let bounding_box = OrientedBox {
        center_m: [CAR_RANGE_M as f32, 0.0, -0.75],
        length_width_height_m: [4.0, 1.8, 1.5],
        yaw_rad: 0.0,
    };
    let car = annotation(AnnotationClass::Car, Some(bounding_box), first_of_car..first_of_car + 10);
    labeled(cloud().positions_m(), [car])
}

/// Frame of the stages up to the foreground after the scan.
pub fn frame() -> Frame<Foreground> {
    let mut stages = foreground(&HierarchicalParams::shipped().front_end(), SENSOR_HEIGHT_M);
    stages.detect(&cloud(), &mut DetectorOutput::default());
    stages.frame
}

fn cloud() -> PointCloud {
    let center_m = |step: i32| 0.7 + 0.6 * step as f32;
    let mut cloud = PointCloud::default();
    for (along, across) in (-10..30).flat_map(|along| (-10..10).map(move |across| (along, across))) {
        for (dx_m, dy_m) in [(-0.15, -0.15), (-0.15, 0.15), (0.15, -0.15), (0.15, 0.15)] {
            cloud.push([center_m(along) + dx_m, center_m(across) + dy_m, -SENSOR_HEIGHT_M], 0.0);
        }
    }
    let mut column = |along: i32, across: i32, n_points: u64, [low_m, high_m]: [f32; 2]| {
        for step in 0..n_points {
            let z_m = low_m + (high_m - low_m) * step as f32 / (n_points - 1) as f32;
            cloud.push([center_m(along), center_m(across), z_m], 0.0);
        }
    };
    column(15, -1, N_CAR, [-1.3, -0.4]);
    column(20, 5, N_POST, [-1.4, 0.6]);
    column(5, 15, N_FACADE, [-0.5, 2.5]);
    column(5, -15, N_SCRAP, [-0.9, -0.8]);
    cloud
}
