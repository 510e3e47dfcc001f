//! `scanbench merge`: puts shards together.

use std::path::{Path, PathBuf};

use clap::Args;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{ClaimedTarget, MANIFEST_JSON};
use reports::run_folder::shard_check::{NamedShard, check_shards};
use reports::vocabulary::study::Study;

use crate::cli::OutputArgs;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::shards::executor::WholeResult;
use crate::plumbing::shards::shard_log::ShardLog;
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::verbs::SCAN_STUDIES;
use crate::verbs::partial::print_partial;
use crate::verbs::partial::whole_partial::WholePartial;
use crate::verbs::reproduce::papers_run::merge_reproduction;
use crate::verbs::run::ending::print_ending;
use crate::verbs::sweep::print_sweep;
use crate::verbs::sweep::whole_sweep::WholeSweep;

/// Arguments of `scanbench merge`.
#[derive(Debug, Args)]
#[command(after_help = MERGE_EXAMPLES)]
pub struct MergeArgs {
    /// All shards of a run or of another study, in any order, or the folder that holds them
    #[arg(value_name = "SHARD", required = true)]
    pub shards: Vec<PathBuf>,
    /// Where the run is written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const MERGE_EXAMPLES: &str = "\
Examples:
  scanbench run --shard 1/2 -o shards && scanbench run --shard 2/2 -o shards
  scanbench merge shards -o runs/whole
  scanbench sweep -L xi=2,3 --shard 1/1 -o cells && scanbench merge cells -o runs/cells

The result equals that of an undivided run, except for times. Shards are refused
(exit code 5) if one is missing or duplicate, or if data, parameters or programs
differ. Times of different processors are separate, in table_times.md and
times_of_processors.csv. docs/many-machines.md says more.";

/// Puts shards together: their rows one after the other, and all numbers made of these as those of the whole are.
pub fn merge(arguments: &MergeArgs) -> Result<(), Failure> {
    let folders = folders(&arguments.shards);
    let output = &arguments.output;
    let shards = open_shards(&folders)?;
    match study_of(&shards) {
        Study::Partial => {
            let merged = put_together::<WholePartial>(&shards, output)?;
            print_partial(merged.whole, &merged.directory.finish()?)
        }
        Study::Sweep => {
            let merged = put_together::<WholeSweep>(&shards, output)?;
            print_sweep(merged.whole, &merged.directory.finish()?)
        }
        _ => merge_run(put_together::<WholeRun>(&shards, output)?),
    }
}

/// Result of shards, in a directory that has no name yet.
struct Merged<Whole> {
    study: Study,
    directory: RunDirectory,
    whole: Whole,
}

/// The study that the first of `shards` is of.
fn study_of(shards: &[NamedShard]) -> Study {
    shards.first().and_then(|it| Some(it.manifest.shard.as_ref()?.study)).unwrap_or(Study::Run)
}

fn put_together<Whole: WholeResult>(
    shards: &[NamedShard],
    output: &OutputArgs,
) -> Result<Merged<Whole>, Failure> {
    let order = check_shards(shards)?;
    let logs = ShardLog::in_order(shards, &order);
    let manifests: Vec<&Manifest> = order.iter().map(|&idx| &shards[idx].manifest).collect();
    let study = study_of(shards);
    let directory = RunDirectory::begin(claim(study, manifests[0], output)?)?;
    let whole = Whole::of_shards(study, &logs, &manifests, &directory)?;
    Ok(Merged { study, directory, whole })
}

/// Writes and prints the study that shards of a run are of.
fn merge_run(Merged { study, directory, whole }: Merged<WholeRun>) -> Result<(), Failure> {
    if study == Study::Reproduce {
        return merge_reproduction(&whole, directory);
    }
    match SCAN_STUDIES.iter().find(|it| it.0 == study) {
        Some((_, write)) => write(&directory, &whole)?.print(&directory.finish()?),
        None => print_ending(&whole, &directory.finish()?),
    }
}

fn claim(study: Study, manifest: &Manifest, output: &OutputArgs) -> Result<ClaimedTarget, Failure> {
    let ids: Vec<&str> = manifest.selected().iter().map(|(id, _)| *id).collect();
    WorkOutput::claim(study, None, output)?.target(&ids.join("+"))
}

/// The folders of the shards: those that are named, and those within a folder that is no shard itself.
fn folders(named: &[PathBuf]) -> Vec<PathBuf> {
    let of_folder = |folder: &PathBuf| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut within: Vec<PathBuf> =
            entries.map(|it| it.path()).filter(|it| is_called_as_a_shard(it)).collect();
        within.sort();
        if within.is_empty() || folder.join(MANIFEST_JSON).is_file() { vec![folder.clone()] } else { within }
    };
    named.iter().flat_map(of_folder).collect()
}

fn is_called_as_a_shard(path: &Path) -> bool {
    path.is_dir() && path.file_name().is_some_and(|it| it.to_string_lossy().starts_with("shard-"))
}

fn open_shards(folders: &[PathBuf]) -> Result<Vec<NamedShard>, Failure> {
    folders.iter().map(|it| open_shard(it)).collect()
}

fn open_shard(directory: &Path) -> Result<NamedShard, Failure> {
    let name = directory.display().to_string();
    if directory.extension().is_some_and(|it| it == "unfinished") {
        let words = format!("{name} is an unfinished shard: give its command again, and merge it then");
        return Err(Failure::NotComparable(words.into()));
    }
    if !directory.is_dir() {
        return Err(Usage(format!("there is no shard {name}")).into());
    }
    let manifest = Manifest::read(&directory.join(MANIFEST_JSON));
    Ok(NamedShard { name, manifest: manifest.map_err(|error| Failure::damaged_run(directory, error))? })
}
