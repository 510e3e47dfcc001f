//! Gives a finished folder its name.

use std::path::Path;

use crate::files::whole_file::folder_of;
use crate::files::whole_set::exchange;
use crate::run_folder::run_target::{RunDirectoryError, is_empty_folder, metadata, refused};

/// Gives the finished folder its name; an earlier run of that name goes only once the new one is at its path.
pub(crate) fn move_to_target(partial: &Path, target: &Path) -> Result<(), RunDirectoryError> {
    let rename = |from: &Path, to: &Path| -> Result<(), RunDirectoryError> {
        std::fs::rename(from, to).map_err(refused(target))
    };
    let Some(metadata) = metadata(target)? else { return rename(partial, target) };
    if is_empty_folder(target, &metadata)? {
        // In one step where the system allows it, so that there is no moment without a folder of that name.
        if std::fs::rename(partial, target).is_ok() {
            return Ok(());
        }
        std::fs::remove_dir(target).map_err(refused(target))?;
        return rename(partial, target);
    }
    if exchange(partial, target).is_ok() {
        return Ok(());
    }
    let parent = folder_of(target);
    let aside = tempfile::Builder::new().prefix(".replaced-").tempdir_in(parent).map_err(refused(parent))?;
    let old = aside.path().join("old");
    rename(target, &old)?;
    rename(partial, target).or_else(|error| rename(&old, target).and(Err(error)))
}
