//! `scanbench ablation`.

use std::path::PathBuf;

use clap::Args;
use evaluation::run::ablation::{TASK, variants};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::plots::study_plots::ablation_plot;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::ablation_score::AblationRow;
use reports::tables::studies::ablation_table::AblationTable;
use reports::vocabulary::study::Study;

use crate::cli::help_text::DETECTORS;
use crate::cli::{
    BlocksArgs, ConfigArgs, DatasetArgs, MatchingArgs, NoRecordingArgs, OutputArgs, ShardArgs, TimingArgs,
};
use crate::plumbing::config::{built_in_methods, choose_matching, refuse_unread_models};
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::judged_streets::advise_on_judged;
use crate::plumbing::named_blocks::with_named_blocks;
use crate::plumbing::open_datasets::open_datasets;
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::recorder::say_that_none_is_written;
use crate::plumbing::scan_study::{Printed, ScanStudy, make_study};
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::terminal;

/// Arguments of `scanbench ablation`.
#[derive(Debug, Args)]
#[command(after_help = ABLATION_EXAMPLES)]
pub struct AblationArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// Parameters of the whole method.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Also run variants with trees that were trained without the part
    ///
    /// DIR has folders such as without-walls and one-round, written by `train groupings` with
    /// `-P hierarchical.walls.enabled=false` and `-P hierarchical.grouping.rounds=1`.
    #[arg(long, value_name = "DIR", help_heading = DETECTORS)]
    pub models: Option<PathBuf>,
    /// Where the table is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
    /// That it has no recording.
    #[command(flatten)]
    pub recording: NoRecordingArgs,
}

const ABLATION_EXAMPLES: &str = "\
Examples:
  scanbench ablation
  scanbench ablation streets ~/data/kitti_tracking -o runs/ablation
  scanbench ablation street-narrow --seed 7 -P hierarchical.grid.xi=2
  scanbench ablation streets --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards

Runs the whole method and one variant without each part. Writes ablation.csv,
ablation.md and the files of a run whose detectors are the variants:
  scanbench compare DIR --detectors 'whole method,without terrain'";

/// The method whose parts are left out.
const METHOD: &str = "hierarchical";

const ABLATION_CSV: &str = "ablation.csv";

/// Runs the hierarchical detector whole and without each of its parts on the same scans, writes the run directory and prints
/// the table; or makes a shard of that.
pub fn ablation(arguments: &AblationArgs) -> Result<(), Failure> {
    say_that_none_is_written(&arguments.recording, "ablation");
    let output = WorkOutput::claim(Study::Ablation, arguments.shard.shard, &arguments.output)?;
    make_study(&mut open_ablation(arguments, output.started)?, output, write_ablation)
}

/// Opens the variants of the method, and the scans that they run on.
pub fn open_ablation(arguments: &AblationArgs, started: Timestamp) -> Result<ScanStudy<'_>, Failure> {
    let (listed, mut config) = built_in_methods(&arguments.config, &[METHOD.to_owned()])?;
    choose_matching(&mut config, &arguments.matching)?;
    let datasets = open_datasets(&arguments.data, &config.classes)?;
    let datasets = with_named_blocks(datasets, arguments.blocks.blocks.as_deref())?;
    let datasets = look_first_at_all(datasets, &mut config);
    advise_on_judged(&datasets)?;
    let compared_detectors = variants(listed[0], &config, arguments.models.as_deref())?;
    refuse_unread_models(compared_detectors.iter().map(|it| (&it.chosen, &it.config)))?;
    Ok(ScanStudy {
        config,
        compared_detectors,
        datasets,
        selection: arguments.data.scans.as_deref(),
        n_warmup: arguments.timing.warmup,
        n_jobs: arguments.timing.n_jobs(),
        started,
        staged: None,
        recorded: None,
        pairs: None,
    })
}

/// Writes the files that only an ablation has into `directory`.
pub fn write_ablation(directory: &RunDirectory, run: &WholeRun) -> Result<Printed, Failure> {
    let of_task = run.facts.tables.iter().filter(|it| it.task == TASK);
    let tables: Vec<_> = of_task.map(|it| AblationTable::new(METHOD, it, &run.facts.report)).collect();
    tables.iter().try_for_each(|it| write_files(directory, it))?;
    let texts: Vec<String> = tables.iter().map(|it| terminal().text(it)).collect();
    Ok(Printed { files: "Ablation", text: texts.join("\n") })
}

fn write_files(directory: &RunDirectory, table: &AblationTable) -> Result<(), Failure> {
    let rows: Vec<AblationRow> = table.scores.iter().map(|it| AblationRow::new(table.task, it)).collect();
    directory.write_file(ABLATION_CSV, &to_csv_bytes(&rows)?)?;
    write_figure(directory, "ablation", &ablation_plot(table))?;
    Ok(write_table(directory, "ablation", table)?)
}
