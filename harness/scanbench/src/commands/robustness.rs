//! `scanbench robustness`.

use std::num::NonZeroUsize;

use evaluation::run::robustness::{CONDITIONS, Condition};
use evaluation::run::side_by_side::OnDetectorFailure;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::condition_scores::ConditionScores;
use reports::numbers::tally::Tally;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::condition_row::ConditionRow;
use reports::tables::studies::robustness_table::{NamedCondition, RobustnessTable, condition_scores};
use scans::dataset::source::DamagePolicy;

use crate::cli::RobustnessArgs;
use crate::commands::experiment::Experiment;
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::opened_results::OpenedResults;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::progress::RunProgress;
use crate::commands::run_numbers::write_numbers;
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::watched_run::{WatchedRun, WithoutLabels};
use reports::plots::study_plots::robustness_plot;

/// All there are, the method first.
const DETECTORS: [&str; 4] = ["hierarchical", "kd-tree", "pca", "simple-grid"];

/// Runs detectors on simulated streets under one condition after another, each a data set of its own, writes the run directory
/// and prints the table.
///
/// # Errors
///
/// If anything asked for is not there, or the output cannot be written; nothing is left behind then.
pub fn robustness(arguments: &RobustnessArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let asked = Experiment::begin(&arguments.detectors, &DETECTORS)?;
    let directory = asked.begin_directory(&arguments.output, "robustness")?;
    let datasets =
        CONDITIONS.iter().map(|it| Ok(OpenedDataset::whole(it.open(asked.seed, arguments.scans)?)));
    let datasets = datasets.collect::<Result<Vec<OpenedDataset>, Failure>>()?;
    let entrants = asked.entrants();
    let progress = RunProgress::new();
    let mut tally = Tally::default();
    let sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    let watched = WatchedRun {
        entrants: &entrants,
        results: &OpenedResults::default(),
        datasets: &datasets,
        damage: DamagePolicy::Refuse,
        n_warmup: Experiment::N_WARMUP,
        n_repeats: NonZeroUsize::MIN,
        n_jobs: std::thread::available_parallelism().map_or(1, NonZeroUsize::get),
        on_failure: OnDetectorFailure::Stop,
        interrupted,
        progress: &progress,
        without_labels: WithoutLabels::Refuse,
    };
    watched.run(sinks)?;
    let numbers = write_numbers(&directory, &manifest(arguments, &asked, &datasets), &tally)?;
    let conditions: Vec<NamedCondition> = CONDITIONS.iter().map(named).collect();
    let scores = condition_scores(&conditions, &numbers.tables);
    let notes = notes(arguments, &asked);
    write_tables(&directory, &scores, &notes)?;
    let finished = directory.finish()?;
    let printed = print_result(terminal().text(&RobustnessTable { conditions: &scores, notes: &notes }));
    // Also where nobody takes the table: it is there.
    print_diagnostic(format_args!("Tables: {}", finished.display()));
    printed
}

fn named(condition: &Condition) -> NamedCondition {
    let [group, condition_name] = [condition.group, condition.name].map(str::to_owned);
    NamedCondition { group, condition: condition_name, dataset: condition.id() }
}

/// That of a run, with the drives of each condition.
fn manifest(arguments: &RobustnessArgs, asked: &Experiment, datasets: &[OpenedDataset]) -> Manifest {
    let conditions = CONDITIONS.iter().map(|it| {
        let drives = it.drives(asked.seed, arguments.scans);
        serde_json::json!({ "group": it.group, "condition": it.name, "dataset": it.id(), "drives": drives })
    });
    asked.manifest("streets", conditions.collect::<Vec<_>>().into(), datasets)
}

fn notes(arguments: &RobustnessArgs, asked: &Experiment) -> Vec<String> {
    let n_streets = CONDITIONS.first().map_or(0, |it| it.drives(asked.seed, arguments.scans).len());
    vec![
        format!(
            "NO: annotations that count. obj, veh: tasks objects and vehicles. {} scans per condition, {} of each kind of \
             street, the same streets under all conditions (seeds from {}).",
            n_streets * arguments.scans as usize,
            arguments.scans,
            asked.seed
        ),
        "Each condition changes one thing of the standard. Road gradients are random, except under road. Detectors know the sensor and \
         its height; nothing else is adapted."
            .to_owned(),
    ]
}

fn write_tables(
    directory: &RunDirectory,
    conditions: &[ConditionScores],
    notes: &[String],
) -> Result<(), Failure> {
    let rows: Vec<ConditionRow> = conditions.iter().flat_map(ConditionRow::simulated).collect();
    directory.write_file("robustness.csv", &to_csv_bytes(&rows)?)?;
    write_figure(directory, "robustness", &robustness_plot(conditions))?;
    Ok(write_table(directory, "robustness", &RobustnessTable { conditions, notes })?)
}
