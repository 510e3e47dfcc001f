//! Hidden folders for unfinished results.

use std::io;
use std::path::Path;

use tempfile::TempDir;

use super::unfinished::{Kind, Unfinished};
use super::whole_file::folder_of;

/// A hidden folder that is removed with its content when this is dropped or the program is interrupted.
#[derive(Debug)]
#[must_use = "the folder goes when this is dropped"]
pub struct HiddenFolder {
    // Invariant: removed before it is forgotten.
    folder: TempDir,
    unfinished: Unfinished,
}

impl HiddenFolder {
    /// Makes a hidden folder beside `target`. Its name contains `state`, such as `partial`.
    ///
    /// # Errors
    ///
    /// If the operating system refuses.
    pub fn beside(target: &Path, state: &str) -> io::Result<Self> {
        let name = target.file_name().unwrap_or_default();
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{}.{state}-", name.to_string_lossy());
        builder.prefix(&prefix);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As for any other folder, the umask decides about access.
            builder.permissions(std::fs::Permissions::from_mode(0o777));
        }
        let make = || builder.tempdir_in(folder_of(target));
        let (unfinished, folder) = Unfinished::begin(Kind::Folder, make, |it| it.path().to_path_buf())?;
        Ok(Self { folder, unfinished })
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Runs `step`, such as renaming the folder; nothing is removed meanwhile.
    pub fn undisturbed<T>(&self, step: impl FnOnce() -> T) -> T {
        self.unfinished.undisturbed(step)
    }
}
