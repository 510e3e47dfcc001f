//! Reads files and folders with errors that name them.

use std::path::{Path, PathBuf};

use reports::files::regular_file::read_bytes;

use super::DatasetError;

/// The largest file that is read as a whole, in bytes: a hundred million points.
const MOST_OF_FILE: u64 = 1 << 31;

/// The bytes of the file at `path`.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, DatasetError> {
    read_bytes(path, MOST_OF_FILE).map_err(DatasetError::io(path))
}

/// The size of the file at `path` in bytes.
pub fn n_bytes_of(path: &Path) -> Result<u64, DatasetError> {
    Ok(std::fs::metadata(path).map_err(DatasetError::io(path))?.len())
}

/// Whether a file, folder or link is at `path`, even a broken link: a file to be read must not be ignored.
pub fn is_there(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok()
}

/// Paths of the files and folders in `folder` that are not hidden, in the order of names.
pub fn entries_of(folder: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let entries = std::fs::read_dir(folder).and_then(|it| it.map(|entry| Ok(entry?.path())).collect());
    let mut paths: Vec<PathBuf> = entries.map_err(DatasetError::io(folder))?;
    paths.retain(|path| !is_hidden(path));
    paths.sort();
    Ok(paths)
}

/// Whether the name begins with a dot, as for the copies that some systems leave beside a file.
pub fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

/// Whether the name ends in a dot and `extension`.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|it| it == extension)
}

/// The last part of `path`; empty if it has none, as for `..`.
pub fn name_of(path: &Path) -> String {
    path.file_name().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The last part of `path` up to its last dot; empty if it has none.
pub fn stem_of(path: &Path) -> String {
    path.file_stem().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The names of `paths`, all of which must be UTF-8.
pub fn names_of(paths: &[PathBuf], expected: &str) -> Result<Vec<String>, DatasetError> {
    let name = |path: &PathBuf| path.file_name().and_then(|it| it.to_str()).map(str::to_owned);
    paths.iter().map(|path| name(path).ok_or_else(|| DatasetError::file_name(path, expected))).collect()
}
