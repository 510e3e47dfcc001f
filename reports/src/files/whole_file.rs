//! Files that are written whole or not at all.

use std::ffi::OsStr;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::files::archive::ArchiveError;
use crate::files::unfinished::{Kind, Unfinished};

/// Prefix of the names of hidden files.
const UNFINISHED_PREFIX: &str = ".partial-";

/// Whether a file of this name was never completed, as after a program was killed.
pub fn is_unfinished_file(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(UNFINISHED_PREFIX.as_bytes())
}

/// A file that appears under its name once it is complete.
///
/// Until [`Self::finish`] the content is in a hidden file beside it, which is removed when this is dropped.
#[derive(Debug)]
#[must_use = "a file that is not finished is thrown away"]
pub struct WholeFile {
    writer: BufWriter<NamedTempFile>,
    unfinished: Unfinished,
    path: PathBuf,
}

impl WholeFile {
    /// Begins the file `path`, whose folder must exist.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if nothing can be written there.
    pub fn create(path: &Path) -> Result<Self, ArchiveError> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED_PREFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As for any other file, the umask decides about access.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let make = || builder.tempfile_in(folder_of(path));
        let (unfinished, file) = Unfinished::begin(Kind::File, make, |it| it.path().to_path_buf())
            .map_err(|source| ArchiveError::Write { path: path.to_path_buf(), source })?;
        Ok(Self { writer: BufWriter::new(file), unfinished, path: path.to_path_buf() })
    }

    /// The name under which the file will appear.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Brings the content to the disk and gives the file its name; a file of that name is replaced.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if the disk does not take it; then an earlier file is untouched.
    pub fn finish(self) -> Result<(), ArchiveError> {
        let Self { writer, unfinished, path } = self;
        let persist = || -> io::Result<()> {
            let file = writer.into_inner().map_err(|error| without_path(error.into_error()))?;
            file.as_file().sync_all()?;
            unfinished.undisturbed(|| file.persist(&path).map_err(|it| it.error))?;
            Ok(())
        };
        persist().map_err(|source| ArchiveError::Write { path: path.clone(), source })
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes).map_err(without_path)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(without_path)
    }
}

/// `error` without the temporary name of the file, which `tempfile` adds: the error around it has the final name.
fn without_path(error: io::Error) -> io::Error {
    if error.raw_os_error().is_some() { error } else { error.kind().into() }
}

/// Writes `content` to the file `path`, whole or not at all.
///
/// # Errors
///
/// [`ArchiveError::Write`] if the disk does not take it.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), ArchiveError> {
    let mut file = WholeFile::create(path)?;
    file.write_all(content).map_err(|source| ArchiveError::Write { path: path.to_path_buf(), source })?;
    file.finish()
}

/// The folder that `path` is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|it| it.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn an_unfinished_file_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = WholeFile::create(&folder.path().join("a.csv")).unwrap();
        file.write_all(b"half of it").unwrap();
        drop(file);
        assert!(names_in(folder.path()).is_empty());
    }

    #[test]
    fn an_unfinished_file_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        write_whole(&path, b"old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        file.finish().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names_in(folder.path()), ["a.csv"]);
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("a.csv");
        let error = write_whole(&path, b"").unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {path:?}"));
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_the_file_as_any_other() {
        use std::os::unix::fs::PermissionsExt as _;

        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| std::fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
        write_whole(&folder.path().join("ours"), b"").unwrap();
        std::fs::write(folder.path().join("plain"), b"").unwrap();
        assert_eq!(mode("ours"), mode("plain"));
    }
}
