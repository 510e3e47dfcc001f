//! Folders that are written whole or not at all.

use std::fmt::Write as _;
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
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if it does, somebody else is writing it, or nothing can be written there.
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
    /// # Errors
    ///
    /// [`ConversionError::Write`], also if there is a file of that name already: two names may be one where upper and lower case are not told apart.
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
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if something of that name has appeared.
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

/// `name` as the name of a folder that leads nowhere else, and another one for every name: each byte of what is neither letter, digit, `-`, `_` nor
/// an inner dot becomes `%` and two hexadecimal digits; the empty name becomes `%`.
pub fn folder_name(name: &str) -> String {
    if name.is_empty() {
        return "%".to_owned();
    }
    let mut folder = String::with_capacity(name.len());
    for (place, byte) in name.bytes().enumerate() {
        let is_plain =
            byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_') || (byte == b'.' && place > 0);
        if is_plain {
            folder.push(char::from(byte));
        } else {
            let _ = write!(folder, "%{byte:02X}");
        }
    }
    folder
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_lead_nowhere_else() {
        for (name, expected) in [
            ("0000", "0000"),
            ("main-road-1.2", "main-road-1.2"),
            ("../../etc", "%2E.%2F..%2Fetc"),
            ("/etc", "%2Fetc"),
            ("..", "%2E."),
            ("", "%"),
            ("a\\b:c", "a%5Cb%3Ac"),
            ("a/b", "a%2Fb"),
            ("a_b", "a_b"),
            ("a%2Fb", "a%252Fb"),
            ("straße", "stra%C3%9Fe"),
        ] {
            assert_eq!(folder_name(name), expected, "{name}");
        }
    }

    proptest! {
        #[test]
        fn different_names_are_different_folders(one in ".{0,8}", other in ".{0,8}") {
            prop_assert_eq!(one == other, folder_name(&one) == folder_name(&other));
        }
    }

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
