//! What the Rerun recording of a run costs: time outside of detection, and bytes, for each scan.
//!
//! `cargo bench -p viewer [-- DATASET [SCANS]]`; DATASET is an id of the catalogue or a path, from the root of the
//! repository. Without it a simulated street is used. Detectors are the default ones of `run`.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use evaluation::matching::assign::MatchingParams;
use evaluation::matching::criterion::Criterion;
use evaluation::matching::eligibility::EligibilityParams;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{ChosenDetector, DEFAULT_DETECTORS, detectors_named};
use evaluation::run::scan_recorder::{RecordedScan, ScanRecorder as _};
use evaluation::run::side_by_side::{OnDetectorFailure, SideBySide};
use evaluation::run::sink::{JudgedScan, WatchedDataset};
use reports::vocabulary::task::Task;
use scans::dataset::Dataset;
use scans::dataset::scan_selection::ScanSelection;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use viewer::run_recording::{RecordingPath, RunRecording, RunRecordingOptions};
use viewer::{FirstTab, Opening, PointChoice, StreamOptions, ViewerChoice};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo starts benchmarks in the folder of their package; paths are meant from the root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))?;
    // Cargo appends `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|it| !it.starts_with("--")).collect();
    let name = arguments.first().map_or("street-main-road", String::as_str);
    let selection: ScanSelection = arguments.get(1).map_or("0..20", String::as_str).parse()?;
    let dataset = open_dataset(name, &OpenOptions::default(), &built_in_catalogue()?)?;
    let scan_indices = selection.positions(dataset.scan_ids().len())?;
    let config = RunConfig::load(None)?;
    let chosen = detectors_named(&DEFAULT_DETECTORS.map(str::to_owned), &config)?;

    let folder = tempfile::tempdir()?;
    let file = folder.path().join("run.rrd");
    let (mut times, n_points) = record(&*dataset, &scan_indices, &chosen, &file)?;

    let n_scans = scan_indices.len();
    let simulated = if dataset.description().is_simulated() { ", simulated" } else { "" };
    let n_detectors = chosen.len() as f64;
    println!("{name}{simulated}: {n_scans} scans of {} points, {n_detectors} detectors", n_points / n_scans);
    let ms = |it: Duration| it.as_secs_f64() * 1e3;
    let mean = ms(times.iter().sum::<Duration>()) / n_scans as f64;
    // The first does without writing what the one before held back, the last does nothing else.
    let whole = &mut times[1..n_scans];
    whole.sort_unstable();
    let [least, median] = [0, whole.len() / 2].map(|rank| whole.get(rank).copied().map_or(mean, ms));
    for (of, parts) in [("a scan", 1.0), ("a scan and detector", n_detectors)] {
        let [mean, least, median] = [mean, least, median].map(|it| it / parts);
        println!("time of {of}: mean {mean:.1} ms, median {median:.1} ms, least {least:.1} ms");
    }
    println!("file: {:.2} MB a scan", std::fs::metadata(&file)?.len() as f64 / 1e6 / n_scans as f64);
    Ok(())
}

/// Runs the detectors on the scans and records them in `file`. Returns the time of logging each scan, then that of the end,
/// and the number of all points.
fn record(
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    chosen: &[ChosenDetector],
    file: &Path,
) -> Result<(Vec<Duration>, usize), Box<dyn std::error::Error>> {
    let description = dataset.description();
    let config = RunConfig::load(None)?;
    let names: Vec<&'static str> = chosen.iter().map(ChosenDetector::name).collect();
    let mut detectors: Vec<_> =
        chosen.iter().map(|it| ComparedDetector::of(it.clone(), &config).begin(description)).collect();
    let options = RunRecordingOptions {
        stream: StreamOptions {
            name: "benchmark".to_owned(),
            viewer: ViewerChoice::None,
            opening: Opening {
                shown_task: Task::Objects,
                first_tab: FirstTab::Compare,
                has_poses: false,
                follows: true,
                figures: &[],
            },
            points: PointChoice::default(),
        },
        path: RecordingPath::InRun(file.to_owned()),
        every: 1,
    };
    let mut recording = RunRecording::begin(options, &names)?;
    let criterion = Criterion::POINTS;
    let side_by_side = SideBySide {
        dataset,
        scan_indices,
        part: 0..scan_indices.len(),
        n_before: 0,
        class_criteria: &config.class_criteria,
        matching: MatchingParams { criterion, eligibility: EligibilityParams::STANDARD },
        n_warmup: 1,
        n_repeats: NonZeroUsize::MIN,
        counter: None,
        n_jobs: 1,
        on_failure: OnDetectorFailure::Stop,
        interrupted: &AtomicBool::new(false),
    };
    let watched =
        WatchedDataset { dataset, scan_indices, n_scans: scan_indices.len(), n_before: 0, criterion };
    let (mut times, mut n_points) = (Vec::new(), 0);
    side_by_side.run(&mut detectors, |results| -> Result<(), Box<dyn std::error::Error>> {
        n_points += results.scan.cloud.len();
        let judged = JudgedScan::new(watched, &results);
        let started = Instant::now();
        recording.record(&RecordedScan { judged: &judged, marks: &[] })?;
        times.push(started.elapsed());
        Ok(())
    })?;
    let started = Instant::now();
    recording.finish()?;
    times.push(started.elapsed());
    Ok((times, n_points))
}
