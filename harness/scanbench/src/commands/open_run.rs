//! Runs read back from their directories.

use std::path::Path;

use reports::run_folder::run_archive::RunArchive;

use crate::commands::failure::{Failure, Usage};

/// The run in `directory`.
///
/// # Errors
///
/// [`Usage`] if there is no such directory, [`Failure::Data`] if a file of it is missing or damaged.
pub fn open_run(directory: &Path) -> Result<RunArchive, Failure> {
    if !directory.is_dir() {
        return Err(Usage(format!("there is no run directory {}", directory.display())).into());
    }
    RunArchive::read(directory).map_err(|error| Failure::damaged_run(directory, error))
}
