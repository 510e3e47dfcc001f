//! `scanbench run`.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use indicatif::ProgressBar;
use jiff::Timestamp;
use reports::files::csv_rows::{CsvRowWriter, to_csv_bytes};
use reports::numbers::run_report::RunReport;
use reports::numbers::tally::Tally;
use reports::pages::run_page::RunPage;
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    MATCHES_CSV, PRECISION_RECALL_CSV, REPORT_JSON, RunDirectory, SCANS_CSV, WORST_POINTS_JSON,
};
use reports::run_folder::run_target::{ClaimedTarget, LatestPointer, MANIFEST_JSON, RunDirectoryError};
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::TABLE_FORMATS;
use reports::tables::formats::markdown::Markdown;
use reports::tables::formats::terminal::Terminal;
use reports::tables::stage_table::StageTable;
use reports::tables::task_table::{TaskTable, task_tables};
use reports::tables::times_table::TimesTable;
use reports::verdicts::standing::{Speeds, Standing, speeds, standings};
use reports::worst::places::WorstPlaces;
use reports::worst::points::{PlanCells, WorstPoints};

use crate::cli::RunArgs;
use crate::commands::config::{judging_config, warn_of_unknown_sensor};
use crate::commands::failure::NothingEvaluated;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets_past_damage};
use crate::commands::plan_cells::plan_cells;
use crate::commands::progress::progress_over_scans;
use crate::commands::provenance::compact_utc;
#[cfg(feature = "rerun")]
use crate::commands::recording::{RecordedScan, Recording, RecordingPlan, serve_until_interrupted};
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::run_manifest::{RunSettings, detector_entries, run_manifest};
use crate::commands::run_rows::{match_rows, scan_row};
use crate::commands::standard_streams::{
    Verbosity, is_said, print_detail, print_diagnostic, print_result, result_width,
};
use crate::conversion::whole_folder::folder_name;
use crate::dataset::DatasetDescription;
use crate::dataset::scan_times::scan_times_s;
use crate::matching::criterion::Criterion;
use crate::metrics::counts::SCORING_VERSION;
use crate::results_recording::recording::{DetectorResult, ResultsRecording};
use crate::run::config::RunConfig;
use crate::run::detector_list::{ListedDetector, detectors_named};
use crate::run::scores::{DatasetScores, overall_time_rows};
use crate::run::side_by_side::{ScanResults, SideBySide};
#[cfg(feature = "rerun")]
use crate::stream::ServedRecording;
#[cfg(feature = "rerun")]
use reports::vocabulary::task::Task;

/// What is to be run.
struct Plan<'a> {
    arguments: &'a RunArgs,
    config: RunConfig,
    detectors: Vec<ListedDetector>,
    datasets: Vec<OpenedDataset>,
    started: Timestamp,
}

/// Runs detectors on labelled scans, writes the run directory and prints the tables.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, or the output cannot be written; nothing is left behind then.
pub fn run(arguments: &RunArgs) -> anyhow::Result<()> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let detectors = detectors_named(&arguments.detectors)?;
    let config = judging_config(&arguments.config, &arguments.matching, &detectors)?;
    let policy = arguments.damage.policy();
    let named = claim_named(&arguments.output)?;
    let datasets = open_datasets_past_damage(&arguments.data, policy, &config.classes)?;
    let plan = Plan { arguments, config, detectors, datasets, started };
    let directory = begin_directory(&plan, named)?;
    let mut archive = Archive::begin(&plan, &directory)?;
    let mut scores = Vec::new();
    for opened in &plan.datasets {
        archive.times_s = scan_times_s(&*opened.dataset);
        archive.mcap = begin_mcap(&plan, opened, &directory)?;
        scores.push(evaluate(&plan, opened, interrupted, &mut archive)?);
        archive.mcap.take().map_or(Ok(()), ResultsRecording::finish)?;
    }
    let finished = archive.finish()?;
    let tally = finished.tally;
    directory.write_file(WORST_POINTS_JSON, WorstPoints::new(&finished.worst).to_json().as_bytes())?;
    let Plan { config, detectors, datasets, started, .. } = &plan;
    let manifest = run_manifest(RunSettings {
        data: &arguments.data,
        n_warmup: arguments.timing.warmup,
        n_repeats: arguments.repeats,
        config,
        detectors: detector_entries(detectors, config),
        datasets,
        started: *started,
    });
    let report = report_of(&tally, &scores)?;
    let tables = write_report(&directory, &manifest, &report)?;
    let times = TimesTable::new(&report, &manifest);
    directory.write_file("table_times.md", Markdown.text(&times).as_bytes())?;
    if let Some(stages) = StageTable::new(&report, &manifest) {
        directory.write_file("table_stages.md", Markdown.text(&stages).as_bytes())?;
    }
    directory.write_file(PRECISION_RECALL_CSV, &to_csv_bytes(&tally.precision_recall_rows())?)?;
    // Made of the files, so that `report` makes the same.
    RunPage::of(directory.folder())?.write(directory.folder())?;
    let written = directory.finish()?;
    let (standings, speeds) = (standings(&tally, &manifest, &report), speeds(&manifest, &report));
    print(&tables, &times, (&standings, &speeds), &written)?;
    #[cfg(feature = "rerun")]
    if let Some(served) = finished.served {
        serve_until_interrupted(&served, interrupted);
    }
    Ok(())
}

fn report_of(tally: &Tally, scores: &[DatasetScores]) -> anyhow::Result<RunReport> {
    let mut rows = tally.metric_rows();
    rows.extend(scores.iter().flat_map(DatasetScores::time_rows));
    let mut overall = tally.overall_rows();
    overall.extend(overall_time_rows(scores));
    Ok(RunReport::with_overall(SCORING_VERSION, rows, overall)?)
}

fn begin_directory(plan: &Plan<'_>, named: Option<ClaimedTarget>) -> Result<RunDirectory, RunDirectoryError> {
    let unnamed = format!("{}-{}", compact_utc(plan.started), ids_of(&plan.datasets));
    RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Update)?)
}

/// The files that grow scan by scan.
struct Archive<'a> {
    scans: CsvRowWriter<ScanRow>,
    matches: CsvRowWriter<MatchRow>,
    criterion: Criterion,
    tally: Tally,
    worst: WorstPlaces<PlanCells>,
    // Of the data set at hand, as is what follows.
    times_s: Vec<f64>,
    mcap: Option<ResultsRecording<'a>>,
    #[cfg(feature = "rerun")]
    recording: Option<Recording>,
}

/// What is left of an archive once its files are written.
struct FinishedArchive {
    tally: Tally,
    worst: WorstPlaces<PlanCells>,
    #[cfg(feature = "rerun")]
    served: Option<ServedRecording>,
}

impl Archive<'_> {
    fn begin(plan: &Plan<'_>, directory: &RunDirectory) -> anyhow::Result<Self> {
        Ok(Self {
            scans: CsvRowWriter::new(directory.begin_file(SCANS_CSV)?)?,
            matches: CsvRowWriter::new(directory.begin_file(MATCHES_CSV)?)?,
            criterion: plan.config.matching.criterion,
            tally: Tally::default(),
            worst: WorstPlaces::default(),
            times_s: Vec::new(),
            mcap: None,
            #[cfg(feature = "rerun")]
            recording: begin_recording(plan, directory)?,
        })
    }

    fn add(
        &mut self,
        opened: &OpenedDataset,
        results: &ScanResults<'_>,
        scores: &DatasetScores,
        progress: &ProgressBar,
    ) -> anyhow::Result<()> {
        let dataset = opened.dataset.description();
        let time_s = self.times_s[opened.scan_indices[results.run_idx]];
        if let Some(mcap) = &mut self.mcap {
            mcap.add_scan(results.run_idx, results.scan)?;
        }
        for result in results.results {
            for assignment in &result.assignments {
                let row = scan_row(dataset, (results.scan, time_s), result, assignment);
                let criterion = self.criterion.kind();
                let matches = match_rows(dataset, criterion, results.scan, result, assignment);
                self.tally.add_scan(&row);
                self.scans.write(&row)?;
                for row in &matches {
                    self.tally.add_match(row);
                    let cloud = &results.scan.cloud;
                    self.worst.add(row, |window| plan_cells(cloud, window, dataset.sensor_height_m));
                    self.matches.write(row)?;
                }
                if let Some(mcap) = &mut self.mcap {
                    let (scan_row, match_rows) = (&row, &matches[..]);
                    let stage_times = &result.output.stage_times;
                    mcap.add_result(results.scan, &DetectorResult { scan_row, match_rows, stage_times })?;
                }
            }
        }
        #[cfg(feature = "rerun")]
        if let Some(recording) = &mut self.recording {
            let recorded = RecordedScan {
                results,
                scores,
                dataset: &*opened.dataset,
                scan_idx: opened.scan_indices[results.run_idx],
                criterion: self.criterion,
                marks: &[],
            };
            if let Some(warning) = recording.log(&recorded)? {
                warn(progress, &warning);
            }
        }
        #[cfg(not(feature = "rerun"))]
        let _ = scores;
        if is_said(Verbosity::Verbose) {
            progress.suspend(|| print_detail(scan_line(dataset, results)));
        }
        progress.inc(1);
        Ok(())
    }

    fn finish(self) -> anyhow::Result<FinishedArchive> {
        self.scans.finish()?;
        self.matches.finish()?;
        #[cfg(feature = "rerun")]
        let served = match self.recording.map(Recording::finish).transpose()? {
            Some(ending) => {
                if let Some(warning) = ending.warning {
                    print_diagnostic(format_args!("warning: {warning}"));
                }
                ending.served
            }
            None => None,
        };
        Ok(FinishedArchive {
            tally: self.tally,
            worst: self.worst,
            #[cfg(feature = "rerun")]
            served,
        })
    }
}

/// The recording for Foxglove, if one is asked for: one for each data set, which have times and sensors of their own.
fn begin_mcap<'a>(
    plan: &'a Plan<'_>,
    opened: &'a OpenedDataset,
    directory: &RunDirectory,
) -> anyhow::Result<Option<ResultsRecording<'a>>> {
    if !plan.arguments.mcap {
        return Ok(None);
    }
    let name = match &plan.datasets[..] {
        [_] => "run.mcap".to_owned(),
        _ => format!("run-{}.mcap", folder_name(&opened.dataset.description().id)),
    };
    let path = directory.path_of(&name);
    Ok(Some(ResultsRecording::create(&path, &*opened.dataset, &opened.scan_indices)?))
}

/// What came of a scan, for those who want to know while it runs: of every detector the time, its longest stage, and the
/// number of detections.
fn scan_line(dataset: &DatasetDescription, results: &ScanResults<'_>) -> String {
    let mut line = format!("{} {}: {} points", dataset.id, results.scan.id, results.scan.cloud.len());
    for result in results.results {
        let ms = |time: std::time::Duration| 1e3 * time.as_secs_f64();
        let n_detections = result.output.detections.len();
        let _ =
            write!(line, "; {} {:.2} ms, {n_detections} detections", result.detector, ms(result.times.first));
        if let Some(longest) = result.output.stage_times.iter().max_by_key(|it| it.duration) {
            let _ = write!(line, " ({} {:.2} ms)", longest.stage, ms(longest.duration));
        }
    }
    line
}

/// Not through the bar itself, which says nothing where it is hidden.
#[cfg(feature = "rerun")]
fn warn(progress: &ProgressBar, warning: &str) {
    progress.suspend(|| print_diagnostic(format_args!("warning: {warning}")));
}

#[cfg(feature = "rerun")]
fn begin_recording(plan: &Plan<'_>, directory: &RunDirectory) -> anyhow::Result<Option<Recording>> {
    // False objects show only where they can be known: a run on cars and vans alone opens on the vehicles.
    let covers_objects = |it: &OpenedDataset| it.dataset.description().annotated.covers(Task::Objects);
    let shown_task = if plan.datasets.iter().all(covers_objects) { Task::Objects } else { Task::Vehicles };
    let name = directory.target().file_name().unwrap_or_default().to_string_lossy();
    let detectors: Vec<&str> = plan.detectors.iter().map(|it| it.name).collect();
    Recording::begin(&RecordingPlan {
        arguments: &plan.arguments.stream,
        default_file: directory.path_of("run.rrd"),
        name: &name,
        shown_task,
        detectors: &detectors,
        datasets: &plan.datasets,
        at_the_start: false,
    })
}

fn evaluate(
    plan: &Plan<'_>,
    opened: &OpenedDataset,
    interrupted: &AtomicBool,
    archive: &mut Archive<'_>,
) -> anyhow::Result<DatasetScores> {
    let Plan { arguments, detectors: listed, .. } = plan;
    let description = opened.dataset.description();
    warn_of_unknown_sensor(&plan.config, &description.sensor);
    let config = &plan.config.for_sensor(&description.sensor).unwrap_or_else(|| plan.config.clone());
    let mut detectors: Vec<_> =
        listed.iter().map(|it| it.build(config, description.sensor_height_m)).collect();
    let names: Vec<&'static str> = listed.iter().map(|it| it.name).collect();
    let mut scores = DatasetScores::new(description.clone(), &names);
    let side_by_side = SideBySide {
        dataset: &*opened.dataset,
        scan_indices: &opened.scan_indices,
        matching: config.matching,
        n_warmup: arguments.timing.warmup.into(),
        n_repeats: arguments.repeats,
        n_jobs: arguments.timing.n_jobs(),
        interrupted,
    };
    let progress = progress_over_scans(opened.scan_indices.len(), &description.id);
    let on_damage =
        |id: &_, error| progress.suspend(|| opened.on_damage(arguments.damage.policy(), id, error));
    side_by_side.run_past_damage(&mut detectors, on_damage, |results| -> anyhow::Result<()> {
        scores.add(results.results);
        archive.add(opened, &results, &scores, &progress)
    })?;
    progress.finish_and_clear();
    opened.warn_of_points_left_out();
    if scores.n_annotations() == 0 {
        let reason = format!(
            "none of the {} scans of {:?} has an annotation that counts",
            scores.n_scans(),
            description.id
        );
        return Err(NothingEvaluated { reason }.into());
    }
    Ok(scores)
}

fn write_report(
    directory: &RunDirectory,
    manifest: &Manifest,
    report: &RunReport,
) -> anyhow::Result<Vec<TaskTable>> {
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    directory.write_file(REPORT_JSON, report.to_json().as_bytes())?;
    let tables = task_tables(report, manifest)?;
    for table in &tables {
        for format in TABLE_FORMATS {
            directory.write_file(&format.file_name(&table.file_stem()), format.text(table).as_bytes())?;
        }
    }
    Ok(tables)
}

fn print(
    tables: &[TaskTable],
    times: &TimesTable,
    (standings, speeds): (&[Standing], &Speeds),
    finished: &Path,
) -> anyhow::Result<()> {
    let terminal = Terminal { width: Some(result_width()) };
    let texts = tables.iter().map(|it| terminal.text(it)).chain([terminal.text(times)]);
    let sentences = standings.iter().map(Standing::sentence).chain(speeds.sentence());
    let texts = texts.chain([terminal.sentences(sentences)]);
    let printed = texts.into_iter().try_for_each(print_result);
    // Also where nobody takes the tables: the run is there.
    print_diagnostic(format_args!("Run directory: {}", finished.display()));
    printed
}
