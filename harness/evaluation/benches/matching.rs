//! How long it takes to judge a scan with very many detections: 10,000 boxes of low score against 200 annotations, by every
//! criterion, in the task that takes longer. One core, drawn scenes.
//!
//! `cargo bench -p evaluation --bench matching` prints the least and the median of several passes for each scene and
//! criterion, in milliseconds a scan, and fails if the criterion *centre* takes more than 100 ms in the median.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::process::ExitCode;
use std::time::{Duration, Instant};

use detector::{DetectedClass, Detection, Detections, OrientedBox, PointCloud};
use evaluation::matching::assign::{MatchingParams, assign};
use evaluation::matching::criterion::Criterion;
use evaluation::matching::eligibility::EligibilityParams;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::task::Task;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::dataset::AnnotatedClasses;

const N_ANNOTATIONS: usize = 200;
const N_DETECTIONS: usize = 10_000;
const N_GROUND_POINTS: usize = 100_000;
const N_PASSES: usize = 15;
const MOST_MS_BY_CENTRE: f64 = 100.0;
/// Half the side of the square that things stand on, in metres.
const HALF_M: f32 = 55.0;

/// Where annotations stand, and detections about them.
#[derive(Clone, Copy)]
enum Scene {
    /// Both scattered everywhere.
    Scattered,
    /// Detections in stacks of fifty on the annotations, as an insecure detector makes them.
    Heaped,
    /// Annotations a metre apart, so that everything competes with everything.
    Crowded,
}

fn main() -> ExitCode {
    println!("{N_DETECTIONS} boxes against {N_ANNOTATIONS} annotations; {N_PASSES} passes");
    println!("{:<12}{:<12}{:>12}{:>12}", "scene", "criterion", "least ms", "median ms");
    let mut is_fast = true;
    for (name, scene) in
        [("scattered", Scene::Scattered), ("heaped", Scene::Heaped), ("crowded", Scene::Crowded)]
    {
        let (scan, detections) = drawn(scene);
        for criterion in Criterion::ALL {
            let mut times: Vec<Duration> =
                (0..N_PASSES).map(|_| time(&scan, &detections, criterion)).collect();
            times.sort_unstable();
            let [least_ms, median_ms] = [0, N_PASSES / 2].map(|it| 1e3 * times[it].as_secs_f64());
            println!("{name:<12}{:<12}{least_ms:>12.2}{median_ms:>12.2}", criterion.name());
            is_fast &= criterion != Criterion::CENTRE || median_ms <= MOST_MS_BY_CENTRE;
        }
    }
    if is_fast {
        return ExitCode::SUCCESS;
    }
    println!("FAILED: more than {MOST_MS_BY_CENTRE} ms a scan by centre");
    ExitCode::FAILURE
}

/// The longer of the two tasks.
fn time(scan: &LabeledScan, detections: &Detections, criterion: Criterion) -> Duration {
    let params = MatchingParams { criterion, eligibility: EligibilityParams::STANDARD };
    let of_task = |task: &Task| {
        let started = Instant::now();
        std::hint::black_box(assign(scan, detections, *task, &AnnotatedClasses::EveryObject, &params));
        started.elapsed()
    };
    Task::ALL.iter().map(of_task).max().unwrap_or_default()
}

fn drawn(scene: Scene) -> (LabeledScan, Detections) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let boxed = |[x_m, y_m]: [f32; 2], yaw_rad: f32| OrientedBox {
        center_m: [x_m, y_m, -0.9],
        length_width_height_m: [4.0, 1.8, 1.6],
        yaw_rad,
    };
    let mut anywhere = || [0, 1].map(|_| rng.random_range(-HALF_M..HALF_M));
    let position = |number: usize| match scene {
        Scene::Crowded => [(number % 20) as f32 - 10.0, (number / 20) as f32 - 5.0],
        Scene::Scattered | Scene::Heaped => anywhere(),
    };
    let positions: Vec<[f32; 2]> = (0..N_ANNOTATIONS).map(position).collect();
    let mut cloud = PointCloud::default();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let annotations: Vec<Annotation> = positions
        .iter()
        .map(|&at_m| {
            let bounding_box = boxed(at_m, rng.random_range(-3.0..3.0));
            let first = cloud.len() as u32;
            for _ in 0..60 {
                let [dx_m, dy_m] = [0, 1].map(|_| rng.random_range(-0.6_f32..0.6));
                cloud.push([at_m[0] + dx_m, at_m[1] + dy_m, rng.random_range(-1.6..-0.2)], 0.0);
            }
            let (bounding_box, point_indices) = (Some(bounding_box), (first..first + 60).collect());
            Annotation { bounding_box, point_indices, ..Annotation::of(AnnotationClass::Car) }
        })
        .collect();
    let n_object_points = cloud.len();
    for _ in 0..N_GROUND_POINTS {
        let [x_m, y_m] = [0, 1].map(|_| rng.random_range(-HALF_M..HALF_M));
        cloud.push([x_m, y_m, -1.73], 0.0);
    }
    let mut detections = Detections::default();
    for number in 0..N_DETECTIONS {
        let at_m = match scene {
            Scene::Scattered => [0, 1].map(|_| rng.random_range(-HALF_M..HALF_M)),
            Scene::Heaped | Scene::Crowded => {
                positions[number % N_ANNOTATIONS].map(|it| it + rng.random_range(-1.5..1.5))
            }
        };
        let bounding_box = boxed(at_m, rng.random_range(-3.0..3.0));
        let is_inside = |it: &u32| bounding_box.contains(cloud.position_m(*it as usize));
        let point_indices: Vec<u32> = (0..n_object_points as u32).filter(is_inside).collect();
        let (class, score) = (DetectedClass::Vehicle, Some(rng.random_range(0.0..0.1)));
        detections.push(Detection::new(&point_indices, bounding_box, class, score));
    }
    let id = ScanId { sequence: "drawn".to_owned(), index: 0 };
    (LabeledScan::everywhere(id, cloud, annotations), detections)
}
