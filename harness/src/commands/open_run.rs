//! Runs read back from their directories.

use std::path::Path;

use anyhow::Context as _;
use reports::run_folder::run_archive::RunArchive;

use crate::commands::failure::{DamagedRun, Usage};

/// The run in `directory`.
///
/// # Errors
///
/// [`Usage`] if there is no such directory, [`DamagedRun`] if a file of it is missing or damaged.
pub fn open_run(directory: &Path) -> anyhow::Result<RunArchive> {
    anyhow::ensure!(directory.is_dir(), Usage(format!("there is no run directory {}", directory.display())));
    RunArchive::read(directory).with_context(|| DamagedRun { directory: directory.to_path_buf() })
}
