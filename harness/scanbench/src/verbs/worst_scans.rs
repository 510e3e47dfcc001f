//! The recording of the scans with the worst mistakes.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::foreign_detector::ForeignWork;
use evaluation::run::scan_recorder::{Mark, RecordedScan, ScanRecorder as _};
use evaluation::run::side_by_side::SideBySide;
use evaluation::run::sink::{JudgedScan, WatchedDataset};
use reports::run_folder::command_line::shell_word;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_archive::RunArchive;
use reports::vocabulary::task::Task;
use reports::worst::mistakes::ListedMistake;

use crate::cli::{RunArgs, ViewArgs};
use crate::plumbing::config::{choose_matching, chosen_detectors, hide_run, load, wall_in};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage, own_classes};
use crate::plumbing::open_run::refuse_unknown;
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::recorder::{self, Recorder, RecordingPlace, RecordingPlan, finish_and_serve, is_wanted};
use crate::plumbing::run_manifest::refuse_other_scans;
use crate::plumbing::standard_streams::print_diagnostic;
use crate::verbs::run::setup::arguments_of;

/// Runs the scans of `mistakes` again as `manifest` says, and records them, the first mistake's first.
pub fn record(
    arguments: &ViewArgs,
    manifest: &Manifest,
    task: Task,
    mistakes: &[ListedMistake<'_>],
) -> Result<(), Failure> {
    if !is_wanted(&arguments.stream)? {
        return Ok(());
    }
    let interrupted = interruption_flag();
    let again = RunAgain::of(manifest, arguments)?;
    let scans = again.scans_of(mistakes)?;
    let file = arguments.run.join("worst.rrd");
    let written = arguments.stream.save_rrd.clone().flatten().unwrap_or(file.clone());
    let names: Vec<&str> = again.detectors.iter().map(ChosenDetector::name).collect();
    let name = format!("worst of {}", arguments.run.file_name().unwrap_or_default().to_string_lossy());
    let Some(mut recording) = recorder::begin(&RecordingPlan {
        arguments: &arguments.stream,
        place: RecordingPlace::File(file),
        name: &name,
        // A class is one of the objects.
        shown_task: if task.class().is_some() { Task::Objects } else { task },
        detectors: &names,
        n_scans: scans.len(),
        has_poses: again.datasets.iter().any(OpenedDataset::has_poses),
        follows: false,
        shows_changes: false,
        figures: &[],
    })?
    else {
        return Ok(());
    };
    again.log(&scans, interrupted, &mut recording)?;
    finish_and_serve(recording, &written)
}

/// The detector of `run` and the task that `arguments` name.
pub fn chosen_task<'a>(arguments: &'a ViewArgs, run: &'a RunArchive) -> Result<(&'a str, Task), Failure> {
    let names = run.detector_names();
    let detector = arguments.detector.as_deref().or(names.first().copied()).unwrap_or_default();
    refuse_unknown("detector", detector, &names)?;
    Ok((detector, task_named(run, &arguments.task)?))
}

/// The task of `run` with this name.
pub fn task_named(run: &RunArchive, name: &str) -> Result<Task, Usage> {
    let tasks: BTreeSet<Task> = run.scans.iter().map(|it| it.task).collect();
    let known: Vec<&str> = tasks.iter().map(|it| it.name()).collect();
    refuse_unknown("task", name, &known)?;
    Ok(tasks.into_iter().find(|it| it.name() == name).expect("it is known"))
}

struct WorstScan {
    /// Data set, and scan within it.
    indices: [usize; 2],
    marks: Vec<Mark>,
}

/// Points at a mistake, if it has a box.
fn mark(rank: u32, mistake: &ListedMistake<'_>) -> Option<Mark> {
    let kind = mistake.kind;
    let text = format!("worst {rank}: {kind} {}, {}", mistake.class, mistake.reason);
    Some(Mark { position_m: mistake.position_m?, text, change: None })
}

struct RunAgain {
    arguments: Box<RunArgs>,
    config: RunConfig,
    detectors: Vec<ChosenDetector>,
    datasets: Vec<OpenedDataset>,
}

/// Refuses data sets at addresses: another user may have chosen what is fetched, and from where.
fn refuse_addresses(arguments: &RunArgs) -> Result<(), Usage> {
    match arguments.data.datasets.iter().find(|it| it.contains("://")) {
        Some(address) => Err(Usage(format!(
            "the run names the data set {address:?}, which is not fetched unless you trust the run: add --trust, or --no-rrd for the list alone"
        ))),
        None => Ok(()),
    }
}

/// Shows the programs of a configuration that the run names, and refuses to start them unless the run is `trusted`: the user
/// has not chosen them.
fn show_programs(arguments: &RunArgs, detectors: &[ChosenDetector], trusted: bool) -> Result<(), Usage> {
    let Some(config) = &arguments.config.config else { return Ok(()) };
    for detector in detectors {
        let ChosenDetector::Foreign(foreign) = detector else { continue };
        let ForeignWork::Process(process) = &foreign.work else { continue };
        let command = process.command.iter().map(|it| shell_word(it)).collect::<Vec<_>>().join(" ");
        let program = format!("the detector {:?} of {config:?}, the program `{command}`", detector.name());
        if !trusted {
            return Err(Usage(format!(
                "the run names {program}, which is not started unless you trust the run: add --trust, or --no-rrd for the list alone"
            )));
        }
        print_diagnostic(format_args!("Starting {program}"));
    }
    Ok(())
}

/// The arguments that the run of `manifest` was made with. Unless it is `trusted`, it may name no address.
fn trusted_arguments(manifest: &Manifest, trusted: bool) -> Result<Box<RunArgs>, Usage> {
    let arguments = arguments_of(manifest)?;
    if !trusted {
        refuse_addresses(&arguments)?;
    }
    Ok(arguments)
}

/// The data sets of the run of `manifest`, for their scans alone: no detector is asked.
pub fn datasets_of(manifest: &Manifest, trusted: bool) -> Result<Vec<OpenedDataset>, Failure> {
    let arguments = trusted_arguments(manifest, trusted)?;
    let mut config = load(&arguments.config)?;
    config.classes = own_classes(&arguments.data.source).or(&config.classes);
    let datasets = open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &config.classes)?;
    let datasets = look_first_at_all(datasets, &mut config);
    refuse_other_scans(manifest, &datasets, arguments.data.scans.as_deref())?;
    Ok(datasets)
}

/// Indices of the data set and of the scan of this name among `datasets`.
pub fn place_of(
    datasets: &[OpenedDataset],
    (dataset, sequence, scan): (&str, &str, u32),
) -> Result<[usize; 2], Usage> {
    let is_its = |it: &OpenedDataset| it.dataset.description().id == dataset;
    let place = datasets.iter().position(is_its).and_then(|dataset_idx| {
        let ids = datasets[dataset_idx].dataset.scan_ids();
        let scan_idx = ids.iter().position(|id| id.sequence == sequence && id.index == scan)?;
        Some([dataset_idx, scan_idx])
    });
    place.ok_or_else(|| Usage(format!("scan {sequence} {scan} of {dataset:?} does not exist any more")))
}

fn was_walled_in(detector: &ChosenDetector, manifest: &Manifest) -> bool {
    let entry = manifest.detectors.iter().find(|it| it.name == detector.name());
    entry.and_then(|it| it.foreign.as_ref()).is_some_and(|it| it.sandbox)
}

impl RunAgain {
    /// Opens the run of `manifest` for `view`; unless it is to be trusted, it may name files of this machine, and nothing
    /// else. Its detectors see what they saw in the run.
    fn of(manifest: &Manifest, view: &ViewArgs) -> Result<Self, Failure> {
        let arguments = trusted_arguments(manifest, view.trust)?;
        let (mut detectors, mut config) = chosen_detectors(&arguments.config, &arguments.detectors)?;
        show_programs(&arguments, &detectors, view.trust)?;
        for detector in detectors.iter_mut().filter(|it| was_walled_in(it, manifest)) {
            wall_in(detector);
        }
        hide_run(&view.run, &mut config);
        config.places_of_labels.extend(view.stream.save_rrd.clone().flatten());
        choose_matching(&mut config, &arguments.matching)?;
        let resolved = serde_json::to_value(&config.resolved).expect("a configuration has text keys only");
        if resolved != manifest.config {
            return Err(Usage(
                "the parameters differ from those of the run: a file or this program has changed".to_owned(),
            )
            .into());
        }
        let datasets =
            open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &config.classes)?;
        let datasets = look_first_at_all(datasets, &mut config);
        refuse_other_scans(manifest, &datasets, arguments.data.scans.as_deref())?;
        Ok(Self { arguments, config, detectors, datasets })
    }

    /// The scans of all mistakes, each once, in the order of the mistakes.
    fn scans_of(&self, mistakes: &[ListedMistake<'_>]) -> Result<Vec<WorstScan>, Failure> {
        let mut scans: Vec<WorstScan> = Vec::new();
        for (rank, mistake) in (1..).zip(mistakes) {
            let row = mistake.row;
            let indices = place_of(&self.datasets, (&row.dataset, &row.sequence, row.scan))?;
            let mark = mark(rank, mistake);
            match scans.iter_mut().find(|it| it.indices == indices) {
                Some(scan) => scan.marks.extend(mark),
                None => scans.push(WorstScan { indices, marks: mark.into_iter().collect() }),
            }
        }
        Ok(scans)
    }

    fn log(
        &self,
        scans: &[WorstScan],
        interrupted: &AtomicBool,
        recording: &mut Recorder,
    ) -> Result<(), Failure> {
        // Detectors of every data set that has had a scan.
        let mut begun = BTreeMap::new();
        let progress = progress_over_scans(scans.len(), "worst scans");
        for (number, WorstScan { indices: [dataset_idx, scan_idx], marks }) in scans.iter().enumerate() {
            let (dataset_idx, scan_idx) = (*dataset_idx, *scan_idx);
            let opened = &self.datasets[dataset_idx];
            let description = opened.dataset.description();
            let config = self.config.for_scans_of(description);
            let n_warmup = if begun.contains_key(&dataset_idx) { 0 } else { self.arguments.timing.warmup };
            let detectors = begun.entry(dataset_idx).or_insert_with(|| {
                let compared_detectors =
                    self.detectors.iter().map(|it| ComparedDetector::of(it.clone(), &self.config));
                let built = compared_detectors.map(|it| it.begin(description));
                built.collect::<Vec<_>>()
            });
            let side_by_side = SideBySide {
                dataset: &*opened.dataset,
                scan_indices: &[scan_idx],
                part: 0..1,
                n_before: number,
                matching: config.matching,
                class_criteria: &config.class_criteria,
                n_warmup: n_warmup.into(),
                n_repeats: NonZeroUsize::MIN,
                counter: None,
                n_jobs: 1,
                on_failure: self.arguments.on_detector_failure.rule(),
                interrupted,
            };
            side_by_side.run(detectors, |results| -> Result<(), Failure> {
                let watched = WatchedDataset {
                    dataset: &*opened.dataset,
                    scan_indices: &[scan_idx],
                    n_scans: 1,
                    n_before: number,
                    criterion: config.matching.criterion,
                };
                let judged = JudgedScan::new(watched, &results);
                if let Some(warning) = recording.record(&RecordedScan { judged: &judged, marks })? {
                    progress.suspend(|| print_diagnostic(format_args!("warning: {warning}")));
                }
                Ok(())
            })?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }
}
