//! Time to simulate a scan of each kind of street with the HDL-64E, dry and in rain, one thread.
//!
//! `cargo bench -p simulator`
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::time::{Duration, Instant};

use simulator::rain::Rain;
use simulator::sensor::SensorModel;
use simulator::{Street, StreetKind};

const N_SCANS: u32 = 20;
const TURNS_PER_SCAN: u32 = 10;
const RAIN_MM_PER_H: f32 = 10.0;

fn main() {
    let sensor = SensorModel::hdl_64e_s2();
    println!(
        "{:<32} {:>12} {:>10} {:>10} {:>8}",
        "street (simulated)", "points", "p50 ms", "p90 ms", "scans/s"
    );
    for kind in StreetKind::ALL {
        let dry = Street::new(kind, 1);
        let wet = dry.clone().in_rain(Rain::new(RAIN_MM_PER_H));
        measure(kind.name(), &dry, &sensor);
        measure(&format!("{}, {RAIN_MM_PER_H} mm/h", kind.name()), &wet, &sensor);
    }
}

fn measure(name: &str, street: &Street, sensor: &SensorModel) {
    let mut n_points = 0;
    let durations: Vec<Duration> = (0..N_SCANS)
        .map(|scan| {
            let started = Instant::now();
            n_points += street.scan(sensor, scan * TURNS_PER_SCAN).cloud.len();
            started.elapsed()
        })
        .collect();
    let fps = f64::from(N_SCANS) / durations.iter().sum::<Duration>().as_secs_f64();
    let mut sorted = durations;
    sorted.sort_unstable();
    let [p50, p90] = [50, 90].map(|percent| sorted[sorted.len() * percent / 100].as_secs_f64() * 1e3);
    println!("{name:<32} {:>12} {p50:>10.1} {p90:>10.1} {fps:>8.2}", n_points / N_SCANS as usize);
}
