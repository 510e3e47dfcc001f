//! How a finished folder gets its name.

use std::io;
use std::path::Path;

use crate::files::whole_file::folder_of;
use crate::run_folder::run_target::{RunDirectoryError, is_empty_folder, metadata, refused};

/// Gives the finished folder its name; an earlier run of that name goes only once the new one is at its path.
pub(crate) fn move_to_target(partial: &Path, target: &Path) -> Result<(), RunDirectoryError> {
    let rename = |from: &Path, to: &Path| -> Result<(), RunDirectoryError> {
        std::fs::rename(from, to).map_err(refused(target))
    };
    let Some(metadata) = metadata(target)? else { return rename(partial, target) };
    if is_empty_folder(target, &metadata)? {
        // Where the system allows, in one step, so that no moment is without a folder of that name.
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

/// Lets two folders swap names in one step, so that whoever ends the program meanwhile leaves the one or the other.
#[cfg(target_os = "linux")]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

/// Not every system can.
#[cfg(not(target_os = "linux"))]
fn exchange(_one: &Path, _other: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
