//! What the tables of this benchmark have in common.

use std::time::Duration;

use detector::Detector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{DEFAULT_DETECTORS, DETECTORS};
use reports::numbers::latencies::Latencies;

/// The detector that is measured: the first of those that run by default, as runs build it.
pub fn default_detector(config: &RunConfig, sensor_height_m: f32) -> Box<dyn Detector> {
    let listed = DETECTORS.iter().find(|it| it.name == DEFAULT_DETECTORS[0]);
    listed.expect("defaults are on the list").build(config, sensor_height_m)
}

/// The statistics of durations.
pub fn latencies(durations: &[Duration]) -> Latencies {
    Latencies::new(durations.iter().map(|it| it.as_secs_f64() * 1e3).collect())
}

/// A percentile in milliseconds; 0 is the least.
pub fn ms(latencies: &Latencies, percent: u32) -> f64 {
    latencies.percentile_ms(percent).unwrap_or(f64::NAN)
}

/// Prints a table of latencies.
pub fn print_rows(title: &str, rows: impl Iterator<Item = (&'static str, Vec<Duration>)>) {
    println!("\n{title:<24} {:>10} {:>10} {:>10}", "min ms", "p50 ms", "p90 ms");
    for (name, durations) in rows {
        let latencies = latencies(&durations);
        let [min, p50, p90] = [0, 50, 90].map(|percent| ms(&latencies, percent));
        println!("{name:<24} {min:>10.3} {p50:>10.3} {p90:>10.3}");
    }
}
