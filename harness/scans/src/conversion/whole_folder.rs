//! Folders that are written whole or not at all.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::ConversionError;

/// A folder that appears under its name once it is complete. Until then it is a hidden one beside it, which is removed when
/// this is dropped.
#[derive(Debug)]
#[must_use = "a folder that is not finished is thrown away"]
pub struct WholeFolder {
    partial: TempDir,
    target: PathBuf,
}

impl WholeFolder {
    /// Begins the folder `target`, which must not exist.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if it does, or nothing can be written there.
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
        let partial = builder.tempdir_in(parent);
        let partial =
            partial.map_err(|source| ConversionError::Write { path: target.to_path_buf(), source })?;
        Ok(Self { partial, target: target.to_path_buf() })
    }

    /// Writes the file `name`, with its folders.
    ///
    /// # Errors
    ///
    /// [`ConversionError::Write`].
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), ConversionError> {
        let path = self.partial.path().join(name);
        let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = folder.and_then(|()| std::fs::write(&path, content));
        written.map_err(|source| ConversionError::Write { path: self.target.join(name), source })
    }

    /// Gives the folder its name.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if something of that name has appeared.
    pub fn finish(self) -> Result<(), ConversionError> {
        let Self { partial, target } = self;
        if target.exists() {
            return Err(ConversionError::Occupied { path: target });
        }
        std::fs::rename(partial.path(), &target)
            .map_err(|source| ConversionError::Write { path: target, source })?;
        // It has moved: there is nothing left to remove.
        let _ = partial.keep();
        Ok(())
    }
}

/// `name` as the name of a folder that leads nowhere else: whatever is neither letter, digit, `-`, `_` nor an inner dot becomes
/// `_`.
pub fn folder_name(name: &str) -> String {
    let is_plain = |it: char| it.is_ascii_alphanumeric() || matches!(it, '-' | '_' | '.');
    let plain: String = name.chars().map(|it| if is_plain(it) { it } else { '_' }).collect();
    match plain.strip_prefix('.') {
        Some(rest) => format!("_{rest}"),
        None if plain.is_empty() => "_".to_owned(),
        None => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        for (name, expected) in [
            ("0000", "0000"),
            ("main-road-1.2", "main-road-1.2"),
            ("../../etc", "_._.._etc"),
            ("/etc", "_etc"),
            ("..", "_."),
            ("", "_"),
            ("a\\b:c", "a_b_c"),
        ] {
            assert_eq!(folder_name(name), expected, "{name}");
        }
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
