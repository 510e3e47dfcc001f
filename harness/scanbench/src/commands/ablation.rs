//! `scanbench ablation`.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use evaluation::run::ablation::{TASK, variants};
use evaluation::run::config::RunConfig;
use evaluation::run::entrant::Entrant;
use evaluation::run::side_by_side::OnDetectorFailure;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::plots::study_plots::ablation_plot;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::ablation_score::AblationRow;
use reports::tables::studies::ablation_table::AblationTable;
use reports::vocabulary::study::Study;
use scans::dataset::source::DamagePolicy;

use crate::cli::AblationArgs;
use crate::commands::config::{built_in_methods, choose_criterion, refuse_unread_models};
use crate::commands::failure::Failure;
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::interruption_flag;
use crate::commands::judged_streets::advise_on_judged;
use crate::commands::named_blocks::with_named_blocks;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::commands::opened_results::OpenedResults;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::progress::RunProgress;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::begin_run_directory;
use crate::commands::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::commands::run_numbers::{RunNumbers, write_numbers};
use crate::commands::shards::unfinished_shard::ShardPlan;
use crate::commands::shards::watched_shard::{ShardedRun, make_watched_shard};
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::watched_run::{WatchedRun, WithoutLabels};

/// The method whose parts are left out.
const METHOD: &str = "hierarchical";

const ABLATION_CSV: &str = "ablation.csv";

/// Runs the hierarchical detector whole and without each of its parts on the same scans, writes the run directory and prints the
/// table; or makes a shard of that.
pub fn ablation(arguments: &AblationArgs) -> Result<(), Failure> {
    if let Some(shard) = arguments.shard.shard {
        let plan = ShardPlan::claim(Study::Ablation, shard, &arguments.output)?;
        return make_watched_shard(plan, &mut Ablation::open(arguments)?);
    }
    let ablation = Ablation::open(arguments)?;
    let unnamed = format!("{}-ablation-{}", compact_utc(ablation.started), ids_of(&ablation.datasets));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let progress = RunProgress::new();
    let mut tally = ablation.manifest().tally();
    let sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    ablation.watched(WithoutLabels::Refuse, (interruption_flag(), &progress)).run(sinks)?;
    let numbers = write_numbers(&directory, &ablation.manifest(), &tally)?;
    end_ablation(directory, &numbers)
}

/// Who takes part, and on which scans.
struct Ablation<'a> {
    arguments: &'a AblationArgs,
    config: RunConfig,
    datasets: Vec<OpenedDataset>,
    variants: Vec<Entrant>,
    results: OpenedResults,
    started: Timestamp,
}

impl<'a> Ablation<'a> {
    fn open(arguments: &'a AblationArgs) -> Result<Self, Failure> {
        let started = Timestamp::now();
        let (listed, mut config) = built_in_methods(&arguments.config, &[METHOD.to_owned()])?;
        choose_criterion(&mut config, &arguments.matching);
        let datasets = open_datasets(&arguments.data, &config.classes)?;
        let datasets = with_named_blocks(datasets, arguments.blocks.blocks.as_deref())?;
        let datasets = look_first_at_all(datasets, &mut config);
        advise_on_judged(&datasets)?;
        let variants = variants(listed[0], &config, arguments.models.as_deref())?;
        refuse_unread_models(variants.iter().map(|it| (&it.chosen, &it.config)))?;
        Ok(Self { arguments, config, datasets, variants, results: OpenedResults::default(), started })
    }
}

impl ShardedRun for Ablation<'_> {
    fn datasets(&self) -> &[OpenedDataset] {
        &self.datasets
    }

    fn datasets_mut(&mut self) -> &mut [OpenedDataset] {
        &mut self.datasets
    }

    fn manifest(&self) -> Manifest {
        run_manifest(RunSettings {
            selection: self.arguments.data.scans.as_deref(),
            n_warmup: self.arguments.timing.warmup,
            n_repeats: NonZeroUsize::MIN,
            config: &self.config,
            detectors: self.variants.iter().map(detector_entry).collect(),
            datasets: &self.datasets,
            protocols: &[],
            started: self.started,
        })
    }

    fn watched<'b>(
        &'b self,
        without_labels: WithoutLabels,
        (interrupted, progress): (&'b AtomicBool, &'b RunProgress),
    ) -> WatchedRun<'b> {
        WatchedRun {
            entrants: &self.variants,
            results: &self.results,
            datasets: &self.datasets,
            damage: DamagePolicy::Refuse,
            n_warmup: self.arguments.timing.warmup,
            n_repeats: NonZeroUsize::MIN,
            n_jobs: self.arguments.timing.n_jobs(),
            on_failure: OnDetectorFailure::Stop,
            interrupted,
            progress,
            without_labels,
        }
    }
}

/// Writes the files that only an ablation has into `directory`, the run with these `numbers`, and prints the table.
pub fn end_ablation(directory: RunDirectory, numbers: &RunNumbers) -> Result<(), Failure> {
    let of_task = numbers.tables.iter().filter(|it| it.task == TASK);
    let tables: Vec<_> = of_task.map(|it| AblationTable::new(METHOD, it, &numbers.report)).collect();
    tables.iter().try_for_each(|it| write_files(&directory, it))?;
    let finished = directory.finish()?;
    let printed = tables.iter().try_for_each(|it| print_result(terminal().text(it)));
    // Also where nobody takes the table: the files are there.
    print_diagnostic(format_args!("Ablation: {}", finished.display()));
    printed
}

fn write_files(directory: &RunDirectory, table: &AblationTable) -> Result<(), Failure> {
    let rows: Vec<AblationRow> = table.scores.iter().map(|it| AblationRow::new(table.task, it)).collect();
    directory.write_file(ABLATION_CSV, &to_csv_bytes(&rows)?)?;
    write_figure(directory, "ablation", &ablation_plot(table))?;
    Ok(write_table(directory, "ablation", table)?)
}
