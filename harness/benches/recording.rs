//! What the Rerun recording of a run costs: time outside of detection, and bytes, for each scan.
//!
//! `cargo bench --bench recording [-- DATASET [SCANS]]`; DATASET is an id of the catalogue or a path, from the root of the
//! repository. Without it a simulated street is used. Detectors are the default ones of `run`.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use harness::cli::{StreamArgs, TabName};
use harness::commands::recording::{RecordedScan, Recording, RecordingPlan};
use harness::dataset::catalogue::built_in_catalogue;
use harness::dataset::open::{OpenOptions, open_dataset};
use harness::dataset::scan_selection::ScanSelection;
use harness::matching::assign::MatchingParams;
use harness::matching::criterion::Criterion;
use harness::matching::eligibility::EligibilityParams;
use harness::run::config::RunConfig;
use harness::run::detector_list::{DEFAULT_DETECTORS, detectors_named};
use harness::run::scores::DatasetScores;
use harness::run::side_by_side::SideBySide;
use harness::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo starts benchmarks in the folder of their package; paths are meant from the root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
    // Cargo appends `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|it| !it.starts_with("--")).collect();
    let name = arguments.first().map_or("street-main-road", String::as_str);
    let selection: ScanSelection = arguments.get(1).map_or("0..20", String::as_str).parse()?;
    let dataset = open_dataset(name, &OpenOptions::default(), &built_in_catalogue()?)?;
    let scan_indices = selection.positions(dataset.scan_ids().len())?;
    let description = dataset.description().clone();

    let config = RunConfig::load(None)?;
    let config = config.for_sensor(&description.sensor).unwrap_or(config);
    let listed = detectors_named(&DEFAULT_DETECTORS.map(str::to_owned))?;
    let names: Vec<&'static str> = listed.iter().map(|it| it.name).collect();
    let mut detectors: Vec<_> =
        listed.iter().map(|it| it.build(&config, description.sensor_height_m)).collect();
    let mut scores = DatasetScores::new(description.clone(), &names);

    let folder = tempfile::tempdir()?;
    let file = folder.path().join("run.rrd");
    let stream = StreamArgs {
        save_rrd: None,
        no_rrd: false,
        connect: None,
        spawn: false,
        serve: None,
        rerun_every: 1,
        rerun_points: None,
        blueprint: TabName::Compare,
    };
    let mut recording = Recording::begin(&RecordingPlan {
        arguments: &stream,
        default_file: file.clone(),
        name,
        shown_task: Task::Objects,
        detectors: &names,
        datasets: &[],
    })?
    .ok_or("a recording was asked for")?;

    let criterion = Criterion::POINTS;
    let matching = MatchingParams { criterion, eligibility: EligibilityParams::STANDARD };
    let interrupted = AtomicBool::new(false);
    let side_by_side = SideBySide {
        dataset: &*dataset,
        scan_indices: &scan_indices,
        matching,
        n_warmup: 1,
        n_jobs: 1,
        interrupted: &interrupted,
    };
    // Each log writes what the one before held back; the last is written at the end.
    let mut times = Vec::new();
    let mut n_points = 0;
    side_by_side.run(&mut detectors, |results| -> anyhow::Result<()> {
        scores.add(results.results);
        n_points += results.scan.cloud.len();
        let recorded = RecordedScan {
            results: &results,
            scores: &scores,
            dataset: &*dataset,
            scan_idx: scan_indices[results.run_idx],
            criterion,
            marks: &[],
        };
        let started = Instant::now();
        recording.log(&recorded)?;
        times.push(started.elapsed());
        Ok(())
    })?;
    let started = Instant::now();
    recording.finish()?;
    times.push(started.elapsed());

    let n_scans = scan_indices.len();
    let simulated = if description.is_simulated() { ", simulated" } else { "" };
    let n_detectors = names.len() as f64;
    println!("{name}{simulated}: {n_scans} scans of {} points, {n_detectors} detectors", n_points / n_scans);
    times[1..n_scans].sort_unstable();
    let ms = |it: Duration| it.as_secs_f64() * 1e3;
    let whole = ms(times.iter().sum::<Duration>()) / n_scans as f64;
    let least = times[1..n_scans].first().copied().map_or(whole, ms);
    println!(
        "time of a scan: mean {whole:.1} ms, least {least:.1} ms; for each detector: mean {:.1} ms, least {:.1} ms",
        whole / n_detectors,
        least / n_detectors
    );
    println!("file: {:.2} MB a scan", std::fs::metadata(&file)?.len() as f64 / 1e6 / n_scans as f64);
    Ok(())
}
