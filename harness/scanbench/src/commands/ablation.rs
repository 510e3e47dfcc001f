//! `scanbench ablation`.

use std::num::NonZeroUsize;

use evaluation::run::ablation::{TASK, variants};
use evaluation::run::side_by_side::OnDetectorFailure;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::tally::Tally;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::ablation_score::AblationRow;
use reports::tables::studies::ablation_table::AblationTable;
use scans::dataset::source::DamagePolicy;

use crate::cli::AblationArgs;
use crate::commands::config::{built_in_detectors, choose_criterion};
use crate::commands::failure::Failure;
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{ids_of, open_datasets};
use crate::commands::opened_results::OpenedResults;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::progress::RunProgress;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::begin_run_directory;
use crate::commands::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::commands::run_numbers::write_numbers;
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::survival_study::survival_study;
use crate::commands::watched_run::WatchedRun;
use reports::plots::study_plots::ablation_plot;

/// The method whose parts are left out.
const METHOD: &str = "hierarchical";

const ABLATION_CSV: &str = "ablation.csv";

/// Runs the hierarchical detector whole and without each of its parts on the same scans, writes the run directory and prints the
/// table.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, or the output cannot be written; nothing is left behind then.
pub fn ablation(arguments: &AblationArgs) -> Result<(), Failure> {
    if arguments.oracle {
        return survival_study(arguments);
    }
    let (interrupted, started) = (interruption_flag(), Timestamp::now());
    let (listed, mut config) = built_in_detectors(&arguments.config, &[METHOD.to_owned()])?;
    choose_criterion(&mut config, &arguments.matching);
    let datasets = look_first_at_all(open_datasets(&arguments.data, &config.classes)?, &mut config);
    let variants = variants(listed[0], &config)?;
    let unnamed = format!("{}-ablation-{}", compact_utc(started), ids_of(&datasets));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let progress = RunProgress::new();
    let mut tally = Tally::default();
    let sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    let watched = WatchedRun {
        entrants: &variants,
        results: &OpenedResults::default(),
        datasets: &datasets,
        damage: DamagePolicy::Refuse,
        n_warmup: arguments.timing.warmup,
        n_repeats: NonZeroUsize::MIN,
        n_jobs: arguments.timing.n_jobs(),
        on_failure: OnDetectorFailure::Stop,
        interrupted,
        progress: &progress,
        goes_on_without_labels: false,
    };
    watched.run(sinks)?;
    let manifest = run_manifest(RunSettings {
        selection: arguments.data.scans.as_deref(),
        n_warmup: arguments.timing.warmup,
        n_repeats: NonZeroUsize::MIN,
        config: &config,
        detectors: variants.iter().map(detector_entry).collect(),
        datasets: &datasets,
        protocols: &[],
        started,
    });
    let numbers = write_numbers(&directory, &manifest, &tally)?;
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
