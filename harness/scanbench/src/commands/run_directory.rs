//! Where a verb leaves its files.

use std::path::Path;

use reports::run_directory::{ExistingTarget, LatestPointer, RunDirectory, RunDirectoryError};

use crate::cli::OutputArgs;
use crate::commands::failure::Usage;

/// Begins the directory that `arguments` name, or else `unnamed` in `runs/`, of which `latest` may be told.
///
/// # Errors
///
/// [`Usage`] if the directory exists, with the remedy; [`RunDirectoryError`] if nothing can be written there.
pub fn begin_run_directory(
    arguments: &OutputArgs,
    unnamed: &str,
    latest: LatestPointer,
) -> anyhow::Result<RunDirectory> {
    let existing = if arguments.overwrite { ExistingTarget::Replace } else { ExistingTarget::Refuse };
    let created = match &arguments.output {
        Some(target) => RunDirectory::create(target, existing, LatestPointer::Leave),
        None => RunDirectory::create(&Path::new("runs").join(unnamed), existing, latest),
    };
    created.map_err(|error| match error {
        RunDirectoryError::Occupied { .. } => Usage(format!("{error} with --overwrite")).into(),
        error => error.into(),
    })
}
