//! Time of every detector and of each stage of the hierarchical one, interleaved in one run, one thread.
//!
//! `cargo bench --bench detectors [-- DATASET [SCANS]]`; DATASET is an id of the catalogue or a path, from the root of the repository. Without it the
//! simulated street is used.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use detector::detector::StageTime;
use detector::{DetectorOutput, PointCloud};
use harness::dataset::catalogue::built_in_catalogue;
use harness::dataset::open::{OpenOptions, open_dataset};
use harness::dataset::scan_selection::ScanSelection;
use harness::metrics::latency::Latencies;
use harness::run::config::RunConfig;
use harness::run::detector_list::DETECTORS;

const N_ROUNDS: usize = 20;
const N_WARMUP_ROUNDS: usize = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo starts benchmarks in the folder of their package; paths are meant from the root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
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
    measure(&clouds, dataset.description().sensor_height_m)
}

fn measure(clouds: &[PointCloud], sensor_height_m: f32) -> Result<(), Box<dyn std::error::Error>> {
    let config = RunConfig::load(None)?;
    let mut detectors: Vec<_> = DETECTORS.iter().map(|it| it.build(&config, sensor_height_m)).collect();
    let mut latencies: BTreeMap<usize, Vec<Duration>> = BTreeMap::new();
    let mut stages: Vec<(&'static str, Vec<Duration>)> = Vec::new();
    let mut output = DetectorOutput::default();
    for round in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for cloud in clouds {
            for (detector_idx, detector) in detectors.iter_mut().enumerate() {
                let started = Instant::now();
                detector.detect(cloud, &mut output);
                let latency = started.elapsed();
                if round >= N_WARMUP_ROUNDS {
                    latencies.entry(detector_idx).or_default().push(latency);
                    if detector.name() == "hierarchical" {
                        add_stages(&mut stages, &output.stage_times);
                    }
                }
            }
        }
    }
    let all = latencies.into_iter().map(|(idx, durations)| (DETECTORS[idx].name, durations));
    print_rows("detector", all);
    print_rows("stage of hierarchical", stages.into_iter());
    Ok(())
}

fn add_stages(stages: &mut Vec<(&'static str, Vec<Duration>)>, stage_times: &[StageTime]) {
    for it in stage_times {
        match stages.iter_mut().find(|(stage, _)| *stage == it.stage) {
            Some((_, durations)) => durations.push(it.duration),
            None => stages.push((it.stage, vec![it.duration])),
        }
    }
}

fn print_rows(title: &str, rows: impl Iterator<Item = (&'static str, Vec<Duration>)>) {
    println!("\n{title:<24} {:>10} {:>10} {:>10}", "min ms", "p50 ms", "p90 ms");
    for (name, durations) in rows {
        let latencies = Latencies::new(durations);
        let ms = |percent| latencies.percentile(percent).map_or(f64::NAN, |it| it.as_secs_f64() * 1e3);
        println!("{name:<24} {:>10.3} {:>10.3} {:>10.3}", ms(0), ms(50), ms(90));
    }
}
