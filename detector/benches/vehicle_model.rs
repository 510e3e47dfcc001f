//! Time of the vehicle model over all candidates of a scan, one thread: features, decision, and both.
//!
//! `cargo bench -p detector --bench vehicle_model -- FOLDER`; FOLDER holds scans as KITTI has them (`.bin`), of which every
//! tenth is taken. The model is the one that comes along.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::path::Path;
use std::time::{Duration, Instant};

use detector::classify::vehicle_model::VehicleModel;
use detector::describe::surroundings::ObjectRaster;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::pipeline::paper_detector::paper;
use detector::road_user::{MayBe, RoadUser};
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
    let n_candidates: usize = scans.iter().map(Vec::len).sum();
    let n_points: usize = scans.iter().flatten().map(|(_, points_m)| points_m.len()).sum();
    println!(
        "{folder}: {} scans, {} candidates and {} of their points a scan, {N_ROUNDS} rounds",
        scans.len(),
        n_candidates / scans.len(),
        n_points / scans.len()
    );
    measure(&scans);
    Ok(())
}

fn measure(scans: &[Vec<Candidate>]) {
    let mut model = VehicleModel::shipped();
    let mut raster = ObjectRaster::new(HierarchicalParams::shipped().grid.extent_m);
    let (mut features, mut decisions, mut vectors) = (Vec::new(), Vec::new(), Vec::new());
    let mut sum = 0.0_f32;
    for round in 0..=N_ROUNDS {
        for scan in scans {
            vectors.clear();
            let started = Instant::now();
            raster.fill(scan.iter().flat_map(|(_, points_m)| points_m).copied());
            for (bounding_box, points_m) in scan {
                let ground_m = -SENSOR_HEIGHT_M;
                let surroundings = raster.around(bounding_box, ground_m);
                vectors.push(model.values(bounding_box, &surroundings, points_m.iter().copied()));
            }
            let described = Instant::now();
            let odds = vectors.iter().map(|vector| model.odds(MayBe::ALL, vector.as_ref()));
            sum += odds.map(|it| it.of(RoadUser::Vehicle)).sum::<f32>();
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
    let (params, of_sensor) = (PaperParams::shipped(), HierarchicalParams::shipped());
    let mut detector = paper(&params, &of_sensor, None, SENSOR_HEIGHT_M);
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
