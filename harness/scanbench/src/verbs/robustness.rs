//! `scanbench robustness`.

use std::path::{Path, PathBuf};

use clap::Args;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::{RunConfig, TrainedModel};
use evaluation::run::detector_list::built_in_named;
use evaluation::run::robustness::{CONDITIONS, Condition};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::plots::study_plots::robustness_plot;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::robustness_table::{
    ConditionRow, NamedCondition, RobustnessTable, condition_scores,
};
use reports::vocabulary::study::Study;
use simulator::StreetKind;

use crate::cli::help_text::{DATA, DETECTORS as DETECTORS_HEADING};
use crate::cli::{ExperimentArgs, NoRecordingArgs, OutputArgs, ShardArgs, experiment_detectors_help};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::recorder::say_that_none_is_written;
use crate::plumbing::scan_study::{Printed, ScanStudy, StagedScenes, make_study};
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::terminal;

/// Arguments of `scanbench robustness`.
#[derive(Debug, Args)]
#[command(after_help = ROBUSTNESS_EXAMPLES)]
#[command(mut_arg("detectors", |it| it.help(experiment_detectors_help(&DETECTORS.join(",")))))]
pub struct RobustnessArgs {
    /// Scans of each of the three kinds of street, under each condition
    #[arg(long, help_heading = DATA, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub scans: u32,
    /// Also run hierarchical with other trees, those in DIR, under the name "hierarchical, other training"
    ///
    /// DIR is what `scanbench train groupings` wrote.
    #[arg(long, value_name = "DIR", help_heading = DETECTORS_HEADING)]
    pub other_training: Option<PathBuf>,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// The detectors, in the order of the table.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Where the tables are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// That it has no recording.
    #[command(flatten)]
    pub recording: NoRecordingArgs,
}

const ROBUSTNESS_EXAMPLES: &str = "\
Examples:
  scanbench robustness
  scanbench robustness --scans 20 --seed 7 -o runs/robustness
  scanbench robustness -d hierarchical -P walls.enabled=false
  scanbench robustness --other-training docs/models/streets-and-rain
  scanbench robustness --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards

Simulates the same streets under one condition after another: slopes and hills,
kerbs, a truck ahead, mounting heights, sensors, rain, rolling shutter. Writes
robustness.csv with the counts behind every rate, robustness.md and the files of a
run whose data sets are the conditions.";

/// The method, its strongest rival, and the papers' baselines.
const DETECTORS: [&str; 5] = ["hierarchical", "kd-tree-tree", "kd-tree", "pca", "simple-grid"];

/// Name of the method with the trees of [`RobustnessArgs::other_training`].
const OTHER_TRAINING: &str = "hierarchical, other training";

const METHOD: &str = "hierarchical";

/// Kind of the scenes that the seed of the experiment draws.
const DRAWN: &str = "streets";

/// Runs detectors on simulated streets under one condition after another, each a data set of its own, writes the run
/// directory and prints the table; or makes a shard of that.
pub fn robustness(arguments: &RobustnessArgs) -> Result<(), Failure> {
    say_that_none_is_written(&arguments.recording, "robustness");
    let output = WorkOutput::claim(Study::Robustness, arguments.shard.shard, &arguments.output)?;
    make_study(&mut open_robustness(arguments, output.started)?, output, write_robustness)
}

/// Opens the detectors, also with other trees if that is asked for, and the streets of each condition.
pub fn open_robustness(arguments: &RobustnessArgs, started: Timestamp) -> Result<ScanStudy<'_>, Failure> {
    let output = &arguments.output;
    let mut study = ScanStudy::of_simulated_scans(&arguments.detectors, &DETECTORS, output, started)?;
    let (seed, n_scans) = (arguments.detectors.seed, arguments.scans);
    let datasets = CONDITIONS.iter().map(|it| Ok(OpenedDataset::whole(it.open(seed, n_scans)?)));
    let datasets = datasets.collect::<Result<Vec<OpenedDataset>, Failure>>()?;
    study.datasets = look_first_at_all(datasets, &mut study.config);
    // With the changes of the first look.
    for compared_detector in &mut study.compared_detectors {
        compared_detector.config = study.config.clone();
    }
    if let Some(directory) = &arguments.other_training {
        let index = study.compared_detectors.iter().position(|it| it.name == METHOD).map_or(0, |it| it + 1);
        study.compared_detectors.insert(index, with_other_training(directory, &study.config)?);
    }
    let conditions = CONDITIONS.iter().map(|it| {
        let drives = it.drives(seed, n_scans);
        serde_json::json!({ "group": it.group, "condition": it.name, "dataset": it.id(), "drives": drives })
    });
    study.staged = Some(StagedScenes { drawn: DRAWN, seed, scenes: conditions.collect::<Vec<_>>().into() });
    Ok(study)
}

/// The method with the trees in `directory`.
fn with_other_training(directory: &Path, config: &RunConfig) -> Result<ComparedDetector, Failure> {
    let path = toml::Value::String(directory.display().to_string());
    let trees = format!("{}={path}", TrainedModel::Groupings.parameter()).parse();
    let config = config.overridden(&[trees.map_err(Usage)?], &[])?;
    let method = built_in_named(&[METHOD.to_owned()], &config)?[0];
    Ok(ComparedDetector { name: OTHER_TRAINING, chosen: method.into(), config })
}

/// Writes the files that only this study has into `directory`.
pub fn write_robustness(directory: &RunDirectory, run: &WholeRun) -> Result<Printed, Failure> {
    let named: Vec<NamedCondition> = CONDITIONS.iter().map(named).collect();
    let conditions = &condition_scores(&named, &run.facts.tables)[..];
    let rows: Vec<ConditionRow> = conditions.iter().flat_map(ConditionRow::simulated).collect();
    directory.write_file("robustness.csv", &to_csv_bytes(&rows)?)?;
    write_figure(directory, "robustness", &robustness_plot(conditions))?;
    let table = RobustnessTable { conditions, notes: &notes(&run.facts.manifest) };
    write_table(directory, "robustness", &table)?;
    Ok(Printed { files: "Tables", text: terminal().text(&table) })
}

fn named(condition: &Condition) -> NamedCondition {
    let [group, condition_name] = [condition.group, condition.name].map(str::to_owned);
    NamedCondition { group, condition: condition_name, trained: condition.trained, dataset: condition.id() }
}

fn notes(manifest: &Manifest) -> Vec<String> {
    let n_scans = manifest.datasets.first().map_or(0, |it| it.n_scans);
    // One drive through each.
    let n_streets = StreetKind::ALL.len() as u64;
    let seed = manifest.seeds.get(DRAWN).copied().unwrap_or_default();
    vec![
        format!(
            "NO: annotations that count. obj, veh: tasks objects and vehicles. {n_scans} scans per condition, {} of each kind of \
             street, the same streets under all conditions (seeds from {seed}).",
            n_scans / n_streets,
        ),
        "✓: the trees of hierarchical, kd-tree-tree and kd-tree were trained under this condition too, on other drives, with rain of 20 mm/h. \
         Those of pca and paper were trained under the standard alone, and no parameter was chosen by a condition."
            .to_owned(),
        "Each condition changes one thing of the standard. Road gradients are random, except under road. Detectors know the sensor and \
         its height; nothing else is adapted, except that hierarchical learns the density of the new sensors from five of these scans, without \
         labels."
            .to_owned(),
    ]
}
