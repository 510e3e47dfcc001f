//! `scanbench run`.

use std::path::Path;

use evaluation::protocols::known_protocols::official_protocol;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::entrant::Entrant;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::tally::Tally;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::agreement_row::AgreementRow;
use reports::run_folder::manifest::DatasetEntry;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use reports::tables::agreement_table::AgreementOfDetectors as AgreementOfDetectorsTable;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;
use reports::verdicts::standing::{Speeds, Standing, speeds, standings};
use reports::vocabulary::protocol::Protocol;
use reports::vocabulary::task::Task;
use scans::conversion::results::result_folder::ResultFolder;

use crate::cli::{ResultFilesArgs, RunArgs};
use crate::commands::config::{choose_criterion, chosen_with_results};
use crate::commands::failure::Failure;
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets_past_damage};
use crate::commands::opened_results::OpenedResults;
use crate::commands::progress::RunProgress;
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::{self, Recorder, RecordingPlan, serve_until_interrupted};
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::commands::run_numbers::{RunNumbers, write_numbers};
use crate::commands::run_protocols::write_protocols;
use crate::commands::sinks::agreement_of_detectors::AgreementOfDetectors;
use crate::commands::sinks::detection_files::DetectionFiles;
use crate::commands::sinks::label_scores::LabelScores;
use crate::commands::sinks::mcap_results::McapResults;
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::sinks::protocol_rows::ProtocolRowFiles;
use crate::commands::sinks::rerun_recording::RerunRecording;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::watched_run::WatchedRun;

/// Runs detectors on labelled scans, writes the run directory and prints the tables.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, or the output cannot be written; nothing is left behind then.
pub fn run(arguments: &RunArgs) -> Result<(), Failure> {
    let (interrupted, started) = (interruption_flag(), Timestamp::now());
    let left = &arguments.foreign.detections;
    let (chosen, mut config) = chosen_with_results(&arguments.config, &arguments.detectors, left)?;
    choose_criterion(&mut config, &arguments.matching);
    let named = claim_named(&arguments.output)?;
    let datasets = open_for(&chosen, arguments, &mut config)?;
    let entrants: Vec<Entrant> = chosen.into_iter().map(|it| Entrant::of(it, &config)).collect();
    let (missing, damage) = (arguments.foreign.missing_detections.rule(), arguments.damage.policy());
    let results = OpenedResults::open(&entrants, &datasets, missing, damage)?;
    let unnamed = format!("{}-{}", compact_utc(started), ids_of(&datasets));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Update)?)?;
    let progress = RunProgress::new();
    let (mut tally, mut served, mut agreement) = (Tally::default(), None, Vec::new());
    let (mut protocol_tally, mut label_tally) = (ProtocolTally::default(), ProtocolTally::default());
    let recorder = begin_recording(arguments, &entrants, &datasets, &directory)?;
    let mut sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    sinks.push(Box::new(AgreementOfDetectors::new(&mut agreement)));
    sinks.push(Box::new(arguments.mcap.then(|| McapResults::new(&directory, datasets.len()))));
    sinks.push(Box::new(recorder.map(|it| RerunRecording::new(it, &progress, &mut served))));
    sinks.push(Box::new(detection_files(&arguments.result_files, &datasets)?));
    sinks.push(Box::new(protocol_rows(&arguments.protocol.protocols, &directory, &mut protocol_tally)?));
    sinks.push(Box::new(LabelScores::begin(&directory, &arguments.protocol.protocols, &mut label_tally)?));
    let watched = WatchedRun {
        entrants: &entrants,
        results: &results,
        datasets: &datasets,
        damage,
        n_warmup: arguments.timing.warmup,
        n_repeats: arguments.repeats,
        n_jobs: arguments.timing.n_jobs(),
        on_failure: arguments.on_detector_failure.rule(),
        interrupted,
        progress: &progress,
        goes_on_without_labels: true,
    };
    if let Err(failure) = watched.run(sinks) {
        let has_rows = !tally.datasets().is_empty();
        return Err(if has_rows { unfinished(directory, failure) } else { failure });
    }
    let manifest = run_manifest(RunSettings {
        selection: arguments.data.scans.as_deref(),
        n_warmup: arguments.timing.warmup,
        n_repeats: arguments.repeats,
        config: &config,
        detectors: entrants.iter().map(|it| results.with_checksum(detector_entry(it))).collect(),
        datasets: &datasets,
        protocols: &arguments.protocol.protocols,
        started,
    });
    protocol_tally.take_labels_of(label_tally);
    let protocols = write_protocols(&directory, &manifest, (&tally, &protocol_tally))?;
    let numbers = write_numbers(&directory, &manifest, &tally)?;
    let is_compared = |it: &DatasetEntry| agreement.iter().any(|row| row.dataset == it.id);
    let is_scored = !manifest.datasets.iter().all(is_compared);
    let agreement = write_agreement(&directory, &agreement)?;
    let written = directory.finish()?;
    let standings = if is_scored { standings(&tally, &manifest, &numbers.report) } else { Vec::new() };
    let more = protocols.into_iter().chain(agreement);
    print(&numbers, (&standings, &speeds(&manifest, &numbers.report)), (is_scored, more), &written)?;
    if let Some(served) = served {
        serve_until_interrupted(&*served, interrupted);
    }
    Ok(())
}

/// Opens the data sets, and looks at their first scans. Boxes that others made are in the frame of the files, which is not levelled
/// under them.
fn open_for(
    chosen: &[ChosenDetector],
    arguments: &RunArgs,
    config: &mut RunConfig,
) -> Result<Vec<OpenedDataset>, Failure> {
    let mut datasets =
        open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &config.classes)?;
    let has_results = chosen.iter().any(ChosenDetector::is_of_results);
    for it in &mut datasets {
        it.stated.transform |= has_results;
    }
    Ok(look_first_at_all(datasets, config))
}

/// Writes how far detectors agree where nothing is labelled, and returns the table; `None` if everything is.
fn write_agreement(directory: &RunDirectory, rows: &[AgreementRow]) -> Result<Option<String>, Failure> {
    if rows.is_empty() {
        return Ok(None);
    }
    let table = AgreementOfDetectorsTable { rows };
    directory.write_file("agreement.csv", &to_csv_bytes(rows)?)?;
    directory.write_file("table_agreement.md", Markdown.text(&table).as_bytes())?;
    Ok(Some(terminal().text(&table)))
}

/// What evaluates scans under `protocols`; `None` if there are none.
fn protocol_rows<'a>(
    protocols: &[Protocol],
    directory: &RunDirectory,
    tally: &'a mut ProtocolTally,
) -> Result<Option<ProtocolRowFiles<'a>>, Failure> {
    let chosen: Vec<_> = protocols.iter().filter_map(|it| official_protocol(*it)).collect();
    if chosen.is_empty() { Ok(None) } else { ProtocolRowFiles::begin(directory, chosen, tally).map(Some) }
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

fn begin_recording(
    arguments: &RunArgs,
    entrants: &[Entrant],
    datasets: &[OpenedDataset],
    directory: &RunDirectory,
) -> Result<Option<Recorder>, Failure> {
    // False objects show only where they can be known: a run on cars and vans alone opens on the vehicles.
    let covers_objects = |it: &OpenedDataset| it.dataset.description().annotated.covers(Task::Objects);
    let shown_task = if datasets.iter().all(covers_objects) { Task::Objects } else { Task::Vehicles };
    let name = directory.target().file_name().unwrap_or_default().to_string_lossy();
    let detectors: Vec<&str> = entrants.iter().map(|it| it.name).collect();
    recorder::begin(&RecordingPlan {
        arguments: &arguments.stream,
        default_file: directory.path_of("run.rrd"),
        name: &name,
        shown_task,
        detectors: &detectors,
        n_scans: datasets.iter().map(|it| it.scan_indices.len()).sum(),
        has_poses: datasets.iter().any(OpenedDataset::has_poses),
        at_the_start: false,
    })
}

fn print(
    numbers: &RunNumbers,
    (standings, speeds): (&[Standing], &Speeds),
    (is_scored, more): (bool, impl Iterator<Item = String>),
    finished: &Path,
) -> Result<(), Failure> {
    let terminal = terminal();
    let tables = numbers.tables.iter().filter(|_| is_scored).map(|it| terminal.text(it));
    let sentences = standings.iter().map(Standing::sentence).chain(speeds.sentence());
    let last = [terminal.text(&numbers.times), terminal.sentences(sentences)];
    let texts = tables.chain(more).chain(last);
    let printed = texts.into_iter().try_for_each(print_result);
    // Also where nobody takes the tables: the run is there.
    print_diagnostic(format_args!("Run directory: {}", finished.display()));
    printed
}
