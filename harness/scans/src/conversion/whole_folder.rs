//! Folders that are written whole or not at all.

use std::path::{Path, PathBuf};

use reports::files::claimed_name::ClaimedName;
use reports::files::unfinished::{Kind, Unfinished};
use tempfile::TempDir;

use super::ConversionError;

/// A folder that appears under its name once it is complete. Until then it is a hidden one beside it, which is removed when
/// this is dropped.
#[derive(Debug)]
#[must_use = "a folder that is not finished is thrown away"]
pub struct WholeFolder {
    partial: TempDir,
    unfinished: Unfinished,
    target: PathBuf,
    _name: ClaimedName,
}

impl WholeFolder {
    /// Begins the folder `target`, which must not exist.
    pub fn create(target: &Path) -> Result<Self, ConversionError> {
        if target.exists() {
            return Err(ConversionError::Occupied { path: target.to_path_buf() });
        }
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".partial-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(std::fs::Permissions::from_mode(0o777));
        }
        let refused = |source| ConversionError::Write { path: target.to_path_buf(), source };
        let name = ClaimedName::claim(target).map_err(refused)?;
        let name = name.ok_or_else(|| ConversionError::InUse { path: target.to_path_buf() })?;
        let make = || builder.tempdir_in(parent);
        let (unfinished, partial) =
            Unfinished::begin(Kind::Folder, make, |it| it.path().to_path_buf()).map_err(refused)?;
        Ok(Self { partial, unfinished, target: target.to_path_buf(), _name: name })
    }

    /// Writes the file `name`, with its folders.
    ///
    /// It is an error if a file of that name exists: two names may be one where file names do not distinguish upper and
    /// lower case.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), ConversionError> {
        use std::io::Write as _;
        let path = self.partial.path().join(name);
        // Undisturbed, because folders that are removed would come back.
        let written = self.unfinished.undisturbed(|| {
            path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            std::fs::File::create_new(&path)?.write_all(content)
        });
        written.map_err(|source| ConversionError::Write { path: self.target.join(name), source })
    }

    /// Gives the folder its name.
    pub fn finish(self) -> Result<(), ConversionError> {
        let Self { partial, unfinished, target, _name } = self;
        if target.exists() {
            return Err(ConversionError::Occupied { path: target });
        }
        unfinished
            .undisturbed(|| std::fs::rename(partial.path(), &target))
            .map_err(|source| ConversionError::Write { path: target, source })?;
        // It has moved: there is nothing left to remove.
        let _ = partial.keep();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_written_over() {
        let parent = tempfile::tempdir().unwrap();
        let folder = WholeFolder::create(&parent.path().join("drive")).unwrap();
        folder.write("a/b.txt", b"b").unwrap();
        let error = folder.write("a/b.txt", b"c").expect_err("there is one");
        assert!(matches!(error, ConversionError::Write { .. }), "{error}");
    }

    #[test]
    fn a_folder_appears_when_it_is_finished_or_not_at_all() {
        let parent = tempfile::tempdir().unwrap();
        let target = parent.path().join("drive");
        let n_entries = || std::fs::read_dir(parent.path()).unwrap().count();
        let folder = WholeFolder::create(&target).unwrap();
        folder.write("a/b.txt", b"b").unwrap();
        assert!(!target.exists());
        drop(folder);
        assert_eq!(n_entries(), 0);
        let folder = WholeFolder::create(&target).unwrap();
        folder.write("a/b.txt", b"b").unwrap();
        folder.finish().unwrap();
        assert_eq!(std::fs::read(target.join("a/b.txt")).unwrap(), b"b");
        assert_eq!(n_entries(), 1);
        assert!(matches!(WholeFolder::create(&target), Err(ConversionError::Occupied { .. })));
    }
}
