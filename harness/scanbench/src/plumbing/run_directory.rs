//! The directory that a verb writes its files into.

use std::path::Path;

use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{
    ClaimedTarget, ExistingTarget, LatestPointer, RUNS, RunDirectoryError,
};

use crate::cli::OutputArgs;
use crate::plumbing::failure::{Failure, Usage};

/// Takes the directory that `arguments` name, if they do.
pub fn claim_named(arguments: &OutputArgs) -> Result<Option<ClaimedTarget>, Failure> {
    let existing = if arguments.overwrite { ExistingTarget::Replace } else { ExistingTarget::Refuse };
    let Some(target) = &arguments.output else { return Ok(None) };
    match ClaimedTarget::claim(target, existing, LatestPointer::Leave) {
        Err(error @ RunDirectoryError::Occupied { .. }) => {
            Err(Usage(format!("{error} with --overwrite")).into())
        }
        claimed => Ok(Some(claimed?)),
    }
}

/// The directory that was `named`, or else `unnamed` in `runs/`, to which `latest` may point. It gets a number if one of
/// that name exists, or if another program is writing it.
pub fn claim_unnamed(
    named: Option<ClaimedTarget>,
    unnamed: &str,
    latest: LatestPointer,
) -> Result<ClaimedTarget, RunDirectoryError> {
    named.map_or_else(|| ClaimedTarget::claim_unused(Path::new(RUNS), unnamed, latest), Ok)
}

/// Begins the directory that `arguments` name, or else `unnamed`, as [`claim_unnamed`] does.
pub fn begin_run_directory(
    arguments: &OutputArgs,
    unnamed: &str,
    latest: LatestPointer,
) -> Result<RunDirectory, Failure> {
    Ok(RunDirectory::begin(claim_unnamed(claim_named(arguments)?, unnamed, latest)?)?)
}
