//! Runs read back from their directories.

use std::path::Path;

use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::run_folder::shard_record::ShardRecord;

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::shards::work_output::finished_shard;

pub fn open_run(directory: &Path) -> Result<RunArchive, Failure> {
    refuse_other_than_run(directory)?;
    RunArchive::read(directory).map_err(|error| Failure::damaged_run(directory, error))
}

/// Refuses a `directory` that is not that of a whole run, and says what it is.
pub fn refuse_other_than_run(directory: &Path) -> Result<(), Failure> {
    let name = directory.display();
    if !directory.is_dir() {
        return Err(Usage(format!("there is no run directory {name}")).into());
    }
    refuse_shard(directory)?;
    if !directory.join(MANIFEST_JSON).exists() {
        return Err(Usage(format!("{name} is not the directory of a run: it has no {MANIFEST_JSON}")).into());
    }
    Ok(())
}

/// Refuses the directory of a shard, which has no numbers of its own.
pub fn refuse_shard(directory: &Path) -> Result<(), Failure> {
    // A manifest that cannot be read is reported when the run is read.
    let Some(ShardRecord { index, count, study, .. }) = finished_shard(directory) else { return Ok(()) };
    let (name, whole) = (directory.display(), study.name());
    let words =
        format!("{name} is shard {index} of {count}: `scanbench merge` puts all of `{whole}` together");
    Err(Failure::NotComparable(words.into()))
}

/// Refuses the `name` of a detector, or of something else that runs have, that is not one of the `known`.
pub fn refuse_unknown(what: &str, name: &str, known: &[&str]) -> Result<(), Usage> {
    if known.contains(&name) {
        return Ok(());
    }
    Err(Usage(format!("the run has no {what} {name:?}; its {what}s are {}", known.join(", "))))
}
