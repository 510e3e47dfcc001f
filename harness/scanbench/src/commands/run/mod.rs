//! `scanbench run`.

pub mod setup;
pub mod ending;
pub mod shard;

use jiff::Timestamp;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use scans::conversion::results::result_folder::ResultFolder;

use crate::cli::{ResultFilesArgs, RunArgs};
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of};
use crate::commands::progress::RunProgress;
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::serve_until_interrupted;
use crate::commands::run::ending::{print_ending, write_agreement};
use crate::commands::run::setup::ChosenRun;
use crate::commands::run::shard::run_shard;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::run_numbers::write_numbers;
use crate::commands::run_protocols::write_protocols;
use crate::commands::sinks::agreement_of_detectors::AgreementOfDetectors;
use crate::commands::sinks::detection_files::DetectionFiles;
use crate::commands::sinks::mcap_results::McapResults;
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::sinks::protocol_rows::ProtocolRowFiles;
use crate::commands::sinks::rerun_recording::RerunRecording;
use crate::commands::standard_streams::print_diagnostic;
use crate::commands::watched_run::WithoutLabels;

/// Runs detectors on labelled scans, writes the run directory and prints the tables; or a shard of that.
pub fn run(arguments: &RunArgs) -> Result<(), Failure> {
    if let Some(shard) = arguments.shard.shard {
        return run_shard(arguments, shard);
    }
    let (interrupted, started) = (interruption_flag(), Timestamp::now());
    let chosen = ChosenRun::of(arguments)?;
    let named = claim_named(&arguments.output)?;
    let opened = chosen.open(arguments)?;
    let datasets = &opened.datasets;
    let unnamed = format!("{}-{}", compact_utc(started), ids_of(datasets));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Update)?)?;
    let progress = RunProgress::new();
    let mut tally = opened.manifest(arguments, started).tally();
    let (mut served, mut agreement) = (None, Vec::new());
    let mut protocol_tally = ProtocolTally::default();
    let name = directory.target().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let recorder = opened.begin_recording(arguments, &name, directory.path_of("run.rrd"))?;
    let mut sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    sinks.push(Box::new(AgreementOfDetectors::new(&mut agreement)));
    sinks.push(Box::new(arguments.mcap.then(|| McapResults::new(&directory, datasets.len()))));
    sinks.push(Box::new(recorder.map(|it| RerunRecording::new(it, &progress, &mut served))));
    sinks.push(Box::new(detection_files(&arguments.result_files, datasets)?));
    let protocols = &arguments.protocol.protocols;
    sinks.push(Box::new(ProtocolRowFiles::begin(&directory, protocols, &mut protocol_tally)?));
    let watched = opened.watched(arguments, WithoutLabels::Compare, (interrupted, &progress));
    if let Err(failure) = watched.run(sinks) {
        let has_rows = !tally.datasets().is_empty();
        return Err(if has_rows { unfinished(directory, failure) } else { failure });
    }
    let manifest = opened.manifest(arguments, started);
    let protocols = write_protocols(&directory, &manifest, (&tally, &protocol_tally))?;
    let numbers = write_numbers(&directory, &manifest, &tally)?;
    let more = protocols.into_iter().chain(write_agreement(&directory, &agreement)?).collect();
    let written = directory.finish()?;
    print_ending((&numbers, &manifest, &tally), (more, &agreement), &written)?;
    if let Some(served) = served {
        serve_until_interrupted(&*served, interrupted);
    }
    Ok(())
}

fn detection_files(
    arguments: &ResultFilesArgs,
    datasets: &[OpenedDataset],
) -> Result<Option<DetectionFiles>, Failure> {
    let Some((path, format)) = arguments.detections_out.as_deref().zip(arguments.result_format) else {
        return Ok(None);
    };
    for OpenedDataset { dataset, scan_indices, .. } in datasets {
        // Whether a scan is damaged is told when it is its turn.
        let frames = scan_indices.iter().filter_map(|it| Some((*it, dataset.foreign_frame(*it).ok()?)));
        if let Some((scan_idx, frame)) = { frames }.next() {
            format.output().check(&dataset.scan_ids()[scan_idx], &frame)?;
        }
    }
    let folder = ResultFolder::create(path, format.output(), datasets.len() > 1)?;
    Ok(Some(DetectionFiles::new(folder)))
}

/// Leaves the files of a run that a detector has ended.
fn unfinished(directory: RunDirectory, failure: Failure) -> Failure {
    if !matches!(failure, Failure::Detector(_)) {
        return failure;
    }
    match directory.leave_unfinished() {
        Ok(place) => {
            print_diagnostic(format_args!("Rows of the scans before the failure: {}", place.display()));
            failure
        }
        Err(error) => error.into(),
    }
}
