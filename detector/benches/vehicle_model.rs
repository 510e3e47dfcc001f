//! Time of the vehicle model over all candidates of a scan, one thread: features, decision, and both.
//!
//! `cargo bench -p detector --bench vehicle_model -- FOLDER`; FOLDER holds scans as KITTI has them (`.bin`), of which every
//! tenth is taken. The classifier is trained on noise until it has some three hundred support vectors, which is what
//! counts.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::path::Path;
use std::time::{Duration, Instant};

use detector::classify::nu_svc_solver::NuSvcParams;
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use detector::params::HierarchicalParams;
use detector::pipeline::hierarchical_detector::HierarchicalDetector;
use detector::pipeline::vehicle_model::N_FEATURES;
use detector::{Detector, DetectorOutput, OrientedBox, PointCloud};

const N_ROUNDS: usize = 20;
const SENSOR_HEIGHT_M: f32 = 1.73;

/// An object of a scan: its box and its points.
type Candidate = (OrientedBox, Vec<[f32; 3]>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo appends `--bench`.
    let Some(folder) = std::env::args().skip(1).find(|it| !it.starts_with("--")) else {
        println!("a folder of scans is needed: cargo bench -p detector --bench vehicle_model -- FOLDER");
        return Ok(());
    };
    // Cargo starts benchmarks in the folder of their package; paths are meant from the root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
    let scans = candidates_of_scans(Path::new(&folder))?;
    let model = model_of_noise()?;
    let n_candidates: usize = scans.iter().map(Vec::len).sum();
    let n_points: usize = scans.iter().flatten().map(|(_, points_m)| points_m.len()).sum();
    println!(
        "{folder}: {} scans, {} candidates and {} of their points a scan, {} support vectors, {N_ROUNDS} rounds",
        scans.len(),
        n_candidates / scans.len(),
        n_points / scans.len(),
        model.support_vectors.len()
    );
    measure(&scans, &model);
    Ok(())
}

fn measure(scans: &[Vec<Candidate>], model: &SvmModel<N_FEATURES>) {
    let mut describer = VehicleDescriber::new(PrototypeLibrary::drawn());
    let svm = NuSvm::new(model);
    let (mut features, mut decisions, mut vectors) = (Vec::new(), Vec::new(), Vec::new());
    let mut sum = 0.0;
    for round in 0..=N_ROUNDS {
        for scan in scans {
            vectors.clear();
            let started = Instant::now();
            for (bounding_box, points_m) in scan {
                vectors.extend(
                    describer
                        .describe(bounding_box, -SENSOR_HEIGHT_M, points_m.iter().copied())
                        .map(|it| it.values()),
                );
            }
            let described = Instant::now();
            sum += vectors.iter().map(|vector| svm.decision(vector)).sum::<f32>();
            let decided = described.elapsed();
            // The first round warms up.
            if round > 0 {
                features.push(described - started);
                decisions.push(decided);
            }
        }
    }
    let both = features.iter().zip(&decisions).map(|(a, b)| *a + *b).collect();
    println!("{:<10} {:>9} {:>9} {:>9} ms", "", "min", "p50", "p95");
    for (name, durations) in [("features", features), ("decision", decisions), ("both", both)] {
        print_row(name, durations);
    }
    // Or nothing need be computed.
    assert!(sum.is_finite());
}

fn print_row(name: &str, mut durations: Vec<Duration>) {
    durations.sort();
    let nearest_rank = |share: f64| durations[((share * durations.len() as f64).ceil() as usize).max(1) - 1];
    let [min, p50, p95] = [0.0, 0.5, 0.95].map(|share| nearest_rank(share).as_secs_f64() * 1e3);
    println!("{name:<10} {min:>9.3} {p50:>9.3} {p95:>9.3}");
}

fn candidates_of_scans(folder: &Path) -> std::io::Result<Vec<Vec<Candidate>>> {
    let mut paths: Vec<_> =
        std::fs::read_dir(folder)?.map(|it| Ok(it?.path())).collect::<std::io::Result<_>>()?;
    paths.retain(|path| path.extension().is_some_and(|it| it == "bin"));
    paths.sort();
    let mut detector = HierarchicalDetector::new(HierarchicalParams::paper(), SENSOR_HEIGHT_M);
    let mut output = DetectorOutput::default();
    let candidates_of = |path: &std::path::PathBuf| {
        let cloud = read_velodyne_bin(path)?;
        detector.detect(&cloud, &mut output);
        let candidate = |it: detector::Detection<'_>| {
            let positions_m = it.point_indices.iter().map(|&point_idx| cloud.position_m(point_idx as usize));
            (it.bounding_box, positions_m.collect())
        };
        Ok(output.detections.iter().map(candidate).collect())
    };
    paths.iter().step_by(10).map(candidates_of).collect()
}

fn read_velodyne_bin(path: &Path) -> std::io::Result<PointCloud> {
    let bytes = std::fs::read(path)?;
    let mut cloud = PointCloud::default();
    for point in bytes.as_chunks::<16>().0 {
        let (values, _) = point.as_chunks::<4>();
        let [x_m, y_m, z_m, intensity] = std::array::from_fn(|column| f32::from_le_bytes(values[column]));
        cloud.push([x_m, y_m, z_m], intensity);
    }
    Ok(cloud)
}

/// A classifier whose classes differ by their distance from a centre, and now and then not.
fn model_of_noise() -> Result<SvmModel<N_FEATURES>, Box<dyn std::error::Error>> {
    let mut state = 1_u64;
    let mut uniform = || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 40) as f32 / (1_u32 << 24) as f32
    };
    let vectors: Vec<[f32; N_FEATURES]> =
        (0..1200).map(|_| std::array::from_fn(|_| 2.0 * uniform() - 1.0)).collect();
    let is_first: Vec<bool> = vectors
        .iter()
        .map(|vector| vector.iter().take(3).map(|it| it * it).sum::<f32>() + 0.4 * uniform() < 1.2)
        .collect();
    let params = NuSvcParams { gamma: 0.1078, nu: 0.2, tolerance: 1e-3, max_steps: 1_000_000 };
    let made = Provenance {
        command: "cargo bench".to_owned(),
        data: vec!["noise".to_owned()],
        seed: 1,
        split: "nothing held out".to_owned(),
    };
    Ok(train_svm(&vectors, &is_first, (VehicleFeatures::NAMES, "noise".to_owned()), &params, made)?)
}
