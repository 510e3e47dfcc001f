//! `scanbench merge`: shards become what they are parts of.

pub mod manifest;
pub mod run;
pub mod sweep;
pub mod partial;

use std::path::Path;

use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::run_folder::made_in_shards::MadeInShards;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::partial_archive::PartialArchive;
use reports::run_folder::partial_manifest::PartialManifest;
use reports::run_folder::run_target::{ClaimedTarget, LatestPointer, MANIFEST_JSON};
use reports::run_folder::shard_check::{NamedShard, check_shards};
use reports::vocabulary::study::Study;

use crate::cli::{MergeArgs, OutputArgs};
use crate::commands::failure::{Failure, Usage};
use crate::commands::merge::partial::merge_partial;
use crate::commands::merge::run::merge_run;
use crate::commands::merge::sweep::merge_sweep;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::shards::shard_directory::ShardDirectory;

/// Puts shards together: their rows one after the other, and all numbers made of these as those of the whole are.
pub fn merge(arguments: &MergeArgs) -> Result<(), Failure> {
    if arguments.shards.iter().all(|it| PartialArchive::is_partial(it)) {
        let shards = open_shards(arguments, PartialManifest::read)?;
        let order = check_shards(&shards)?;
        let manifests: Vec<&PartialManifest> = order.iter().map(|&idx| &shards[idx].manifest).collect();
        let claimed = claim(Study::Partial, manifests[0], &arguments.output)?;
        return merge_partial(&ShardDirectory::in_order(&shards, &order), &manifests, claimed);
    }
    if let Some(partial) = arguments.shards.iter().find(|it| PartialArchive::is_partial(it)) {
        let words = format!("{} is of `partial`, and others are not", partial.display());
        return Err(Failure::NotComparable(words.into()));
    }
    let shards = open_shards(arguments, Manifest::read)?;
    let order = check_shards(&shards)?;
    let directories = ShardDirectory::in_order(&shards, &order);
    let manifests: Vec<&Manifest> = order.iter().map(|&idx| &shards[idx].manifest).collect();
    let study = directories.first().map_or(Study::Run, |it| it.record.study);
    let claimed = claim(study, manifests[0], &arguments.output)?;
    match study {
        Study::Sweep => merge_sweep(&directories, &manifests, claimed),
        _ => merge_run(study, (&directories, &manifests), claimed),
    }
}

/// Takes the directory of the whole.
fn claim<M: MadeInShards>(study: Study, manifest: &M, output: &OutputArgs) -> Result<ClaimedTarget, Failure> {
    let ids: Vec<&str> = manifest.selected().iter().map(|(id, _)| *id).collect();
    let (ids, now) = (ids.join("+"), compact_utc(Timestamp::now()));
    let (unnamed, latest) = match study {
        Study::Run => (format!("{now}-{ids}"), LatestPointer::Update),
        Study::Sweep | Study::Ablation => (format!("{now}-{}-{ids}", study.name()), LatestPointer::Leave),
        Study::Robustness | Study::Partial => (format!("{now}-{}", study.name()), LatestPointer::Leave),
    };
    Ok(claim_unnamed(claim_named(output)?, &unnamed, latest)?)
}

fn open_shards<M>(
    arguments: &MergeArgs,
    read: fn(&Path) -> Result<M, ArchiveError>,
) -> Result<Vec<NamedShard<M>>, Failure> {
    arguments.shards.iter().map(|it| open_shard(it, read)).collect()
}

fn open_shard<M>(
    directory: &Path,
    read: fn(&Path) -> Result<M, ArchiveError>,
) -> Result<NamedShard<M>, Failure> {
    let name = directory.display().to_string();
    if directory.extension().is_some_and(|it| it == "unfinished") {
        let words = format!("{name} is an unfinished shard: give its command again, and merge it then");
        return Err(Failure::NotComparable(words.into()));
    }
    if !directory.is_dir() {
        return Err(Usage(format!("there is no shard {name}")).into());
    }
    let manifest = read(&directory.join(MANIFEST_JSON));
    Ok(NamedShard { name, manifest: manifest.map_err(|error| Failure::damaged_run(directory, error))? })
}
