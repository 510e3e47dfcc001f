//! How long KITTI's protocol takes for a data set of the size of its validation split: 3,769 made-up scans with 100
//! annotations and 100 detections each. One core, from boxes to all numbers, without intervals.
//!
//! `cargo bench -p evaluation --bench kitti_object` prints seconds and fails if it takes more than 2. With `-- FOLDER` it
//! writes the first hundredth of the scans there as KITTI's files instead, `label_2` and `data`, for other programs.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use evaluation::protocols::kitti_object::scan_facts::scan_facts;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::protocols::kitti_object::numbers::KittiMatches;
use reports::protocols::kitti_object::scan::{KittiAnnotation, KittiDetection, KittiScan};
use reports::rows::kitti_object_row::KittiBox;
use reports::vocabulary::class::AnnotationClass;

const N_SCANS: u32 = 3_769;
const N_BOXES: usize = 100;
const N_PASSES: usize = 3;
const MOST_S: f64 = 2.0;

/// What stands there, and what was found.
type Scene = (Vec<KittiAnnotation>, Vec<KittiDetection>);

fn main() -> ExitCode {
    let folder = std::env::args().skip(1).find(|it| !it.starts_with('-'));
    if let Some(folder) = folder {
        let written = (0..N_SCANS / 100).try_for_each(|scan| write_files(Path::new(&folder), scan));
        return written.map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS);
    }
    let scenes: Vec<Scene> = (0..N_SCANS).map(scene).collect();
    let mut least_s = f64::INFINITY;
    for _ in 0..N_PASSES {
        let start = Instant::now();
        let values = values_of(&scenes);
        let took_s = start.elapsed().as_secs_f64();
        least_s = least_s.min(took_s);
        let sum: f64 = values.iter().flatten().sum();
        println!(
            "{N_SCANS} scans of {N_BOXES} boxes: {took_s:.2} s, {} numbers of mean {:.3}",
            values.len(),
            sum / values.len() as f64
        );
    }
    if least_s <= MOST_S { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn values_of(scenes: &[Scene]) -> Vec<Option<f64>> {
    let scan = |(annotations, detections): &Scene| {
        KittiScan::of(scan_facts(annotations, &[], detections)).expect("indices are there once")
    };
    let scans: Vec<KittiScan> = scenes.iter().map(scan).collect();
    let placed: Vec<(u32, &KittiScan)> = (0..).zip(&scans).collect();
    KittiMatches::of(&placed).values(&vec![1; scans.len()])
}

fn scene(scan: u32) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(scan.into());
    let mut annotations = Vec::with_capacity(N_BOXES);
    let mut detections = Vec::with_capacity(N_BOXES);
    for index in 0..N_BOXES {
        let object = drawn_box(&mut rng);
        let occlusion = rng.random_range(0..4);
        annotations.push(KittiAnnotation { object, occlusion, truncation: rng.random_range(0.0..0.4) });
        // Four of five are found, the fifth is false.
        let mut found = if index % 5 == 4 { drawn_box(&mut rng) } else { object };
        found.bottom_center_m[0] += rng.random_range(-0.2..0.2);
        found.bottom_center_m[2] += rng.random_range(-0.2..0.2);
        found.rotation_y_rad += rng.random_range(-0.1..0.1);
        detections.push(KittiDetection { object: found, score: rng.random_range(0.0..1.0) });
    }
    (annotations, detections)
}

fn drawn_box(rng: &mut ChaCha8Rng) -> KittiBox {
    let (class, height_width_length_m) = match rng.random_range(0..3) {
        0 => (AnnotationClass::Car, [1.5, 1.6, 3.9]),
        1 => (AnnotationClass::Pedestrian, [1.7, 0.7, 0.8]),
        _ => (AnnotationClass::Cyclist, [1.7, 0.6, 1.8]),
    };
    let bottom_center_m = [rng.random_range(-30.0..30.0), 1.7, rng.random_range(5.0..65.0)];
    // As high in the image as it is near.
    let height_px = 720.0 * height_width_length_m[0] / bottom_center_m[2];
    let left_px = 620.0 + 720.0 * bottom_center_m[0] / bottom_center_m[2];
    KittiBox {
        class,
        left_top_right_bottom_px: [left_px, 180.0, left_px + height_px, 180.0 + height_px],
        alpha_rad: rng.random_range(-3.0..3.0),
        bottom_center_m,
        height_width_length_m,
        rotation_y_rad: rng.random_range(-3.0..3.0),
    }
}

fn write_files(folder: &Path, scan: u32) -> std::io::Result<()> {
    let (annotations, detections) = scene(scan);
    let (mut labels, mut results) = (String::new(), String::new());
    for KittiAnnotation { object, occlusion, truncation } in &annotations {
        let _ = writeln!(labels, "{} {truncation} {occlusion} {}", name_of(object), numbers_of(object));
    }
    for KittiDetection { object, score } in &detections {
        let _ = writeln!(results, "{} -1 -1 {} {score}", name_of(object), numbers_of(object));
    }
    for (name, text) in [("label_2", labels), ("data", results)] {
        std::fs::create_dir_all(folder.join(name))?;
        std::fs::write(folder.join(name).join(format!("{scan:06}.txt")), text)?;
    }
    Ok(())
}

fn name_of(object: &KittiBox) -> &'static str {
    match object.class {
        AnnotationClass::Car => "Car",
        AnnotationClass::Pedestrian => "Pedestrian",
        _ => "Cyclist",
    }
}

fn numbers_of(it: &KittiBox) -> String {
    let numbers = std::iter::once(it.alpha_rad).chain(it.left_top_right_bottom_px);
    let numbers = numbers.chain(it.height_width_length_m).chain(it.bottom_center_m);
    let words: Vec<String> = numbers.chain([it.rotation_y_rad]).map(|it| it.to_string()).collect();
    words.join(" ")
}
