//! Files that two directories have: they get a second name and are not copied where the file system can do without.

use std::path::Path;

use reports::files::archive::ArchiveError;
use reports::files::new_file::add_name;
use reports::files::new_folders::NewFolders;

/// Gives the file at `from`, or all files in the folder there, a second name at `to`. What is at `to` already stays.
pub fn keep(from: &Path, to: &Path) -> Result<(), ArchiveError> {
    let unread = |source| ArchiveError::Read { path: from.to_owned(), source };
    let unwritten = |source| ArchiveError::Write { path: to.to_owned(), source };
    let kind = std::fs::symlink_metadata(from).map_err(unread)?.file_type();
    if kind.is_dir() {
        // A folder that stays empty goes again.
        let _folder = NewFolders::create(to).map_err(unwritten)?;
        for entry in std::fs::read_dir(from).map_err(unread)? {
            let entry = entry.map_err(unread)?;
            keep(&entry.path(), &to.join(entry.file_name()))?;
        }
    } else if kind.is_file() && !to.exists() {
        add_name(from, to).map_err(unwritten)?;
    }
    Ok(())
}
