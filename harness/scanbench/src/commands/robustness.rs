//! `scanbench robustness`.

use std::path::Path;

use evaluation::run::config::{RunConfig, TrainedModel};
use evaluation::run::detector_list::built_in_named;
use evaluation::run::entrant::Entrant;
use evaluation::run::robustness::{CONDITIONS, Condition};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::plots::study_plots::robustness_plot;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::robustness_table::{
    ConditionRow, ConditionScores, NamedCondition, RobustnessTable, condition_scores,
};
use reports::vocabulary::study::Study;
use simulator::StreetKind;

use crate::cli::RobustnessArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::first_look::look_first_at_all;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::scan_study::{PutUp, ScanStudy};
use crate::commands::shards::watched_study::execute_watched;
use crate::commands::shards::whole_run::WholeRun;
use crate::commands::shards::work_output::WorkOutput;
use crate::commands::standard_streams::{print_result_in, terminal};

/// The method, its strongest rival, and the papers' baselines.
const DETECTORS: [&str; 5] = ["hierarchical", "kd-tree-tree", "kd-tree", "pca", "simple-grid"];

/// What has the trees of [`RobustnessArgs::other_training`].
const OTHER_TRAINING: &str = "hierarchical, other training";

/// The method.
const METHOD: &str = "hierarchical";

/// What the seed of the experiment draws.
const DRAWN: &str = "streets";

/// Runs detectors on simulated streets under one condition after another, each a data set of its own, writes the run
/// directory and prints the table; or makes a shard of that.
pub fn robustness(arguments: &RobustnessArgs) -> Result<(), Failure> {
    let output = WorkOutput::claim(Study::Robustness, arguments.shard.shard, &arguments.output)?;
    let mut study = open_robustness(arguments, output.started)?;
    let Some((made, _)) = execute_watched(&mut study, output)? else { return Ok(()) };
    let scores = write_robustness(&made.directory, &made.whole)?;
    let (finished, run) = made.finish()?;
    print_robustness(&scores, &run.manifest, &finished)
}

/// Who takes part, also with other trees if that is asked for, and the streets of each condition.
pub fn open_robustness(arguments: &RobustnessArgs, started: Timestamp) -> Result<ScanStudy<'_>, Failure> {
    let mut study = ScanStudy::of_simulated_scans(&arguments.detectors, &DETECTORS, started)?;
    let (seed, n_scans) = (arguments.detectors.seed, arguments.scans);
    let datasets = CONDITIONS.iter().map(|it| Ok(OpenedDataset::whole(it.open(seed, n_scans)?)));
    let datasets = datasets.collect::<Result<Vec<OpenedDataset>, Failure>>()?;
    study.datasets = look_first_at_all(datasets, &mut study.config);
    // With what the first look has found.
    for entrant in &mut study.entrants {
        entrant.config = study.config.clone();
    }
    if let Some(directory) = &arguments.other_training {
        let index = study.entrants.iter().position(|it| it.name == METHOD).map_or(0, |it| it + 1);
        study.entrants.insert(index, with_other_training(directory, &study.config)?);
    }
    let conditions = CONDITIONS.iter().map(|it| {
        let drives = it.drives(seed, n_scans);
        serde_json::json!({ "group": it.group, "condition": it.name, "dataset": it.id(), "drives": drives })
    });
    study.put_up = Some(PutUp { drawn: DRAWN, seed, scenes: conditions.collect::<Vec<_>>().into() });
    Ok(study)
}

/// The method with the trees in `directory`.
fn with_other_training(directory: &Path, config: &RunConfig) -> Result<Entrant, Failure> {
    let path = toml::Value::String(directory.display().to_string());
    let trees = format!("{}={path}", TrainedModel::Groupings.parameter()).parse();
    let config = config.overridden(&[trees.map_err(Usage)?], &[])?;
    let method = built_in_named(&[METHOD.to_owned()], &config)?[0];
    Ok(Entrant { name: OTHER_TRAINING, chosen: method.into(), config })
}

/// Writes the files that only this study has into `directory`, and returns its scores.
pub fn write_robustness(directory: &RunDirectory, run: &WholeRun) -> Result<Vec<ConditionScores>, Failure> {
    let conditions: Vec<NamedCondition> = CONDITIONS.iter().map(named).collect();
    let scores = condition_scores(&conditions, &run.numbers.short.tables);
    write_tables(directory, &scores, &notes(&run.manifest))?;
    Ok(scores)
}

/// Prints the table of `scores`, which is written to `finished` beside `manifest`.
pub fn print_robustness(
    scores: &[ConditionScores],
    manifest: &Manifest,
    finished: &Path,
) -> Result<(), Failure> {
    let notes = notes(manifest);
    print_result_in(
        "Tables",
        finished,
        terminal().text(&RobustnessTable { conditions: scores, notes: &notes }),
    )
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
