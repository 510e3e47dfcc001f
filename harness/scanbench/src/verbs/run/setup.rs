//! Setup of a run, whole or in parts: detectors, parameters, data sets, results of others, a recording.

use clap::Parser as _;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ChosenDetector;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;

use crate::cli::RunArgs;
use crate::plumbing::config::{choose_matching, chosen_with_results, hide_run, wall_in};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::named_blocks::with_named_blocks;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage, own_classes};
use crate::plumbing::opened_results::OpenedResults;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::plumbing::standard_streams::print_diagnostic;
use crate::plumbing::watched_run::WatchedRun;
use crate::verbs::{Cli, Command};

/// The arguments that the run of `manifest` was made with.
pub fn arguments_of(manifest: &Manifest) -> Result<Box<RunArgs>, Usage> {
    let parsed = Cli::try_parse_from(&manifest.argv).map(|it| it.command);
    let Ok(Command::Run(arguments)) = parsed else {
        let line = manifest.argv.join(" ");
        return Err(Usage(format!("this program does not understand the command of the run: `{line}`")));
    };
    Ok(arguments)
}

/// Detectors and their parameters; no data set is open yet.
pub struct ChosenRun {
    chosen: Vec<ChosenDetector>,
    config: RunConfig,
}

impl ChosenRun {
    pub fn of(arguments: &RunArgs) -> Result<Self, Failure> {
        let left = &arguments.foreign.detections;
        let (mut chosen, mut config) = chosen_with_results(&arguments.config, &arguments.detectors, left)?;
        if arguments.foreign.sandbox {
            let n_programs = chosen.iter_mut().map(wall_in).filter(|it| *it).count();
            // A run may have had one before a detector is added.
            if n_programs == 0 && arguments.add_to.is_none() {
                return Err(sandbox_for_none().into());
            }
        }
        let runs = arguments.output.output.iter().chain(&arguments.add_to);
        runs.for_each(|it| hide_run(it, &mut config));
        config.places_of_labels.extend(arguments.stream.save_rrd.clone().flatten());
        choose_matching(&mut config, &arguments.matching)?;
        config.classes = own_classes(&arguments.data.source).or(&config.classes);
        Ok(Self { chosen, config })
    }

    /// Opens the data sets, and looks at their first scans. Boxes of other programs are in the frame of the files: it is
    /// not levelled if there are any.
    pub fn open(self, arguments: &RunArgs) -> Result<OpenedRun, Failure> {
        let Self { chosen, mut config } = self;
        let damage = arguments.damage.policy();
        let datasets = open_datasets_past_damage(&arguments.data, damage, &config.classes)?;
        let mut datasets = with_named_blocks(datasets, arguments.blocks.blocks.as_deref())?;
        let has_results = chosen.iter().any(ChosenDetector::is_of_results);
        for it in &mut datasets {
            it.stated.transform |= has_results;
        }
        let mut datasets = look_first_at_all(datasets, &mut config);
        for it in &mut datasets {
            it.first_look.labels_are_right = arguments.labels_are_right;
            if it.first_look.doubts_labels() {
                let id = &it.dataset.description().id;
                print_diagnostic(format_args!(
                    "{id}: no verdict rests on suspect labels; if they are right, say so with --labels-are-right"
                ));
            }
        }
        let compared_detectors: Vec<ComparedDetector> =
            chosen.into_iter().map(|it| ComparedDetector::of(it, &config)).collect();
        let missing = arguments.foreign.missing_detections.rule();
        let results = OpenedResults::open(&compared_detectors, &datasets, missing, damage)?;
        Ok(OpenedRun { config, datasets, compared_detectors, results })
    }
}

/// The refusal of walls around no program.
pub fn sandbox_for_none() -> Usage {
    Usage("--sandbox is for programs of scanbench.toml, and -d names none".to_owned())
}

/// Everything that a run needs to begin.
pub struct OpenedRun {
    /// Parameters of detectors and matching.
    pub config: RunConfig,
    pub datasets: Vec<OpenedDataset>,
    pub compared_detectors: Vec<ComparedDetector>,
    /// Results of detectors that do not run here.
    pub results: OpenedResults,
}

impl OpenedRun {
    /// Everything that decides the numbers of the run, begun at `started`.
    pub fn manifest(&self, arguments: &RunArgs, started: Timestamp) -> Manifest {
        run_manifest(RunSettings {
            selection: arguments.data.scans.as_deref(),
            n_warmup: arguments.timing.warmup,
            n_repeats: arguments.repeats,
            config: &self.config,
            detectors: self
                .compared_detectors
                .iter()
                .map(|it| self.results.with_checksums(detector_entry(it)))
                .collect(),
            datasets: &self.datasets,
            protocols: &arguments.protocol.protocols,
            started,
        })
    }

    pub fn watched<'a>(&'a self, arguments: &RunArgs, progress: &'a RunProgress) -> WatchedRun<'a> {
        let timing = &arguments.timing;
        WatchedRun {
            results: Some(&self.results),
            damage: arguments.damage.policy(),
            n_repeats: arguments.repeats,
            on_failure: arguments.on_detector_failure.rule(),
            ..WatchedRun::of_study(
                &self.compared_detectors,
                &self.datasets,
                timing.warmup,
                timing.n_jobs(),
                progress,
            )
        }
    }
}
