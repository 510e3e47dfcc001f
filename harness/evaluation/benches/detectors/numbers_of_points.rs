//! How the time of the default detector grows with the number of points.

use std::time::{Duration, Instant};

use detector::{DetectorOutput, PointCloud};
use evaluation::run::config::RunConfig;

use crate::rows::{default_detector, latencies as latencies_of, ms};
use crate::{N_ROUNDS, N_WARMUP_ROUNDS};

/// Measures and prints: every fourth and every second point of each scan, all of them, and two scans in one.
pub fn measure(clouds: &[PointCloud], config: &RunConfig, sensor_height_m: f32) {
    let with_another = (0..clouds.len()).map(|idx| merged(&clouds[idx], &clouds[(idx + 1) % clouds.len()]));
    let thinned = |step: usize| clouds.iter().map(|cloud| every(cloud, step)).collect();
    let sizes: [(&str, Vec<PointCloud>); 4] = [
        ("every fourth point", thinned(4)),
        ("every second point", thinned(2)),
        ("all points", clouds.to_vec()),
        ("two scans in one", with_another.collect()),
    ];
    let mut detector = default_detector(config, sensor_height_m);
    let mut output = DetectorOutput::default();
    let mut latencies: [Vec<Duration>; 4] = std::array::from_fn(|_| Vec::new());
    for round in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for scan_idx in 0..clouds.len() {
            for ((_, scans), latencies) in sizes.iter().zip(&mut latencies) {
                let started = Instant::now();
                detector.detect(&scans[scan_idx], &mut output);
                if round >= N_WARMUP_ROUNDS {
                    latencies.push(started.elapsed());
                }
            }
        }
    }
    println!(
        "\n{:<24} {:>10} {:>10} {:>10} {:>12} {:>12}",
        format!("{} on", detector.name()),
        "points",
        "min ms",
        "p50 ms",
        "min ns/point",
        "p50 ns/point"
    );
    for ((name, scans), latencies) in sizes.iter().zip(latencies) {
        let n_points = scans.iter().map(PointCloud::len).sum::<usize>() / scans.len();
        let latencies = latencies_of(&latencies);
        let [min, p50] = [0, 50].map(|percent| ms(&latencies, percent));
        let per_point = |ms: f64| ms * 1e6 / n_points as f64;
        let [min_ns, p50_ns] = [min, p50].map(per_point);
        println!("{name:<24} {n_points:>10} {min:>10.3} {p50:>10.3} {min_ns:>12.1} {p50_ns:>12.1}");
    }
}

fn every(cloud: &PointCloud, step: usize) -> PointCloud {
    cloud.positions_m().step_by(step).collect()
}

fn merged(a: &PointCloud, b: &PointCloud) -> PointCloud {
    a.positions_m().chain(b.positions_m()).collect()
}
