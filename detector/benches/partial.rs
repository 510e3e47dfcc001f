//! Time of the bag of graphs for clouds of more and more points, one thread: bag and decision.
//!
//! `cargo bench -p detector --bench partial`. The clouds are drawn trees, the model is trained on drawn trees and boards.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::sync::Arc;
use std::time::Instant;

use detector::describe::trained_file::Provenance;
use detector::partial::partial_classifier::PartialClassifier;
use detector::partial::partial_params::PartialParams;
use detector::partial::training::{TrainingCloud, TrainingError, train};

const N_ROUNDS: usize = 41;
const NUMBERS_OF_POINTS: [usize; 6] = [500, 1_000, 2_000, 5_000, 20_000, 50_000];

fn main() -> Result<(), TrainingError> {
    for (name, params) in [("shipped", PartialParams::shipped()), ("paper", PartialParams::of_paper())] {
        let mut classifier = trained(&params)?;
        println!("{name:<8} {:>8} {:>10} {:>12}", "points", "p50 ms", "us a point");
        for n_points in NUMBERS_OF_POINTS {
            // To the letter of the paper a neighbourhood may be the whole cloud.
            if name == "paper" && n_points > 5_000 {
                continue;
            }
            let p50_ms = p50_ms(&mut classifier, &tree(n_points, 1));
            println!("{:<8} {n_points:>8} {p50_ms:>10.3} {:>12.3}", "", 1e3 * p50_ms / n_points as f64);
        }
    }
    Ok(())
}

fn p50_ms(classifier: &mut PartialClassifier, positions_m: &[[f32; 3]]) -> f64 {
    let mut times_ms: Vec<f64> = (0..N_ROUNDS)
        .map(|_| {
            let started = Instant::now();
            let judgement = classifier.classify(positions_m.iter().copied());
            assert!(judgement.distances.iter().all(|it| it.is_finite()), "or nothing need be computed");
            started.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times_ms.sort_by(f64::total_cmp);
    times_ms[N_ROUNDS / 2]
}

fn trained(params: &PartialParams) -> Result<PartialClassifier, TrainingError> {
    let clouds: Vec<TrainingCloud> = (0..12)
        .map(|object_idx| {
            let positions_m =
                if object_idx % 2 == 0 { tree(600, object_idx) } else { board(600, object_idx) };
            TrainingCloud::described(positions_m.into_iter(), object_idx % 2, object_idx, 0, params)
        })
        .collect();
    let made = Provenance { command: "a benchmark".into(), data: Vec::new(), seed: 0, split: "none".into() };
    let classes = ["tree".to_owned(), "board".to_owned()];
    Ok(PartialClassifier::new(Arc::new(train(&classes, &clouds, params, made)?)))
}

/// A trunk of 2 m, and above it points all over a ball of 2 m radius.
fn tree(n_points: usize, seed: usize) -> Vec<[f32; 3]> {
    let mut draws = draws(seed);
    let mut position = || loop {
        let [x, y, z] = [draws(), draws(), draws()].map(|it| 2.0 * it - 1.0);
        if x * x + y * y + z * z < 1.0 {
            let is_trunk = x.abs() < 0.1 && y.abs() < 0.1;
            break if is_trunk { [x, y, 1.0 + z] } else { [2.0 * x, 2.0 * y, 4.0 + 2.0 * z] };
        }
    };
    (0..n_points).map(|_| position()).collect()
}

/// A rough upright board.
fn board(n_points: usize, seed: usize) -> Vec<[f32; 3]> {
    let mut draws = draws(seed);
    (0..n_points).map(|_| [4.0 * draws(), 0.05 * draws(), 2.0 * draws()]).collect()
}

/// Numbers in 0 to 1.
fn draws(seed: usize) -> impl FnMut() -> f32 {
    let mut state = seed as u64 + 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u64 << 24) as f32
    }
}
