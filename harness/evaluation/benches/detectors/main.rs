//! Time of every detector, and of the default one by stage, against a plain grid write, over numbers of points and
//! on two threads. Everything that is compared is interleaved in one run; one thread unless said otherwise.
//!
//! `cargo bench -p evaluation --bench detectors [-- DATASET [SCANS]]`; DATASET is an id of the catalogue or a path, from the
//! root of the repository. Without it the simulated street is used.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod rows;
mod every_detector;
mod plain_grid;
mod numbers_of_points;
mod two_threads;

use detector::PointCloud;
use evaluation::run::config::RunConfig;
use scans::dataset::scan_selection::ScanSelection;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

/// How often everything is measured on every scan.
const N_ROUNDS: usize = 20;
/// Rounds before that, which are not counted.
const N_WARMUP_ROUNDS: usize = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo starts benchmarks in the folder of their package; paths are meant from the root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))?;
    // Cargo appends `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|it| !it.starts_with("--")).collect();
    let name = arguments.first().map_or("street-main-road", String::as_str);
    let selection: ScanSelection = arguments.get(1).map_or("0..8", String::as_str).parse()?;
    let dataset = open_dataset(name, &OpenOptions::default(), &built_in_catalogue()?)?;
    let positions = selection.positions(dataset.scan_ids().len())?;
    let clouds: Vec<PointCloud> = positions
        .iter()
        .map(|&it| Ok(dataset.read_scan(it)?.cloud))
        .collect::<Result<_, Box<dyn std::error::Error>>>()?;
    let n_points: usize = clouds.iter().map(PointCloud::len).sum();
    let simulated = if dataset.description().is_simulated() { ", simulated" } else { "" };
    println!(
        "{name}{simulated}: {} scans, {} points a scan, {N_ROUNDS} rounds",
        clouds.len(),
        n_points / clouds.len()
    );
    let sensor_height_m = dataset.description().sensor_height_m;
    let sensor = &dataset.description().sensor;
    let config = RunConfig::load(None)?.for_sensor(sensor).ok_or("no density curve comes with the sensor")?;
    for measure in
        [every_detector::measure, plain_grid::measure, numbers_of_points::measure, two_threads::measure]
    {
        measure(&clouds, &config, sensor_height_m);
    }
    Ok(())
}
