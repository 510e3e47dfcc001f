//! Several files and folders that appear in a folder together, or not at all.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::files::archive::ArchiveError;
use crate::files::hidden_folder::HiddenFolder;
use crate::files::new_folders::NewFolders;
use crate::files::whole_file::{folder_of, write_whole};

/// Files and folders that take their names in a folder together.
///
/// Until [`Self::finish`] they are in a hidden folder there, which is removed when this is dropped. So is the folder itself,
/// if it was made for them.
#[derive(Debug)]
#[must_use = "what is not finished is thrown away"]
pub struct WholeSet {
    // Invariant: dropped, and so removed, before the folder around it: fields drop in the order of declaration.
    staged: HiddenFolder,
    _new_folders: NewFolders,
    folder: PathBuf,
}

impl WholeSet {
    /// Begins a set in `folder`, which is made if it is missing.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if nothing can be written there.
    pub fn within(folder: &Path) -> Result<Self, ArchiveError> {
        let begin = || -> io::Result<Self> {
            let new_folders = NewFolders::create(folder)?;
            let staged = HiddenFolder::beside(&folder.join("set"), "partial")?;
            Ok(Self { staged, _new_folders: new_folders, folder: folder.to_path_buf() })
        };
        begin().map_err(|source| ArchiveError::Write { path: folder.to_path_buf(), source })
    }

    /// The folder whose entries are those of the set, for writers that open files themselves.
    pub fn staged(&self) -> &Path {
        self.staged.path()
    }

    /// Writes the file `name`, which may be in a folder of the set: `run/report.json`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if the disk does not take it.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), ArchiveError> {
        let path = self.staged.path().join(name);
        let made = std::fs::create_dir_all(folder_of(&path));
        let made = made.map_err(|source| ArchiveError::Write { path: path.clone(), source });
        made.and_then(|()| write_whole(&path, content)).map_err(|error| match error {
            // The final name, not the temporary one.
            ArchiveError::Write { source, .. } => {
                ArchiveError::Write { path: self.folder.join(name), source }
            }
            other => other,
        })
    }

    /// Gives everything its name. Entries of the same names are replaced, files by files and folders by folders.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if one cannot take its name. Then the folder is as before.
    pub fn finish(self) -> Result<(), ArchiveError> {
        let refused = |path: &Path| {
            let path = path.to_path_buf();
            move |source| ArchiveError::Write { path, source }
        };
        let staged = self.staged.path();
        sync_folders(staged).map_err(refused(&self.folder))?;
        let entries = entries_of(staged).map_err(refused(&self.folder))?;
        let moves: Vec<(PathBuf, PathBuf)> =
            entries.iter().map(|it| (staged.join(it), self.folder.join(it))).collect();
        // In one step, even if the program is interrupted.
        self.staged.undisturbed(|| {
            for (from, to) in &moves {
                check_kind(from, to).map_err(refused(to))?;
            }
            let mut placed = Vec::new();
            for (from, to) in &moves {
                match place(from, to, staged) {
                    Ok(before) => placed.push((from, to, before)),
                    Err(source) => {
                        placed.into_iter().rev().for_each(|(from, to, before)| before.restore(from, to));
                        return Err(refused(to)(source));
                    }
                }
            }
            Ok(())
        })?;
        sync_folder(&self.folder).map_err(refused(&self.folder))
    }
}

/// The entry at a path before one of a set took it.
enum Before {
    Nothing,
    /// It is at the path where the new entry was.
    Exchanged,
    /// It is at this path.
    At(PathBuf),
}

/// Gives `from` the name `to`; an earlier entry of that name is moved into `aside`, the folder of `from`.
fn place(from: &Path, to: &Path, aside: &Path) -> io::Result<Before> {
    if std::fs::symlink_metadata(to).is_err_and(|it| it.kind() == io::ErrorKind::NotFound) {
        return std::fs::rename(from, to).map(|()| Before::Nothing);
    }
    if exchange(from, to).is_ok() {
        return Ok(Before::Exchanged);
    }
    let mut name = std::ffi::OsString::from(".earlier-");
    name.push(to.file_name().unwrap_or_default());
    let old = aside.join(name);
    std::fs::rename(to, &old)?;
    std::fs::rename(from, to).or_else(|error| std::fs::rename(&old, to).and(Err(error)))?;
    Ok(Before::At(old))
}

impl Before {
    /// Brings back the earlier entry at `to`, as far as the system allows it; it has just allowed renaming the same names.
    fn restore(self, from: &Path, to: &Path) {
        let _ = match self {
            Self::Nothing => std::fs::rename(to, from),
            Self::Exchanged => exchange(from, to),
            Self::At(old) => std::fs::rename(to, from).and_then(|()| std::fs::rename(old, to)),
        };
    }
}

/// A file does not replace a folder, nor a folder a file.
fn check_kind(from: &Path, to: &Path) -> io::Result<()> {
    let there = match std::fs::symlink_metadata(to) {
        Ok(there) => there,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    };
    match (std::fs::symlink_metadata(from)?.is_dir(), there.is_dir()) {
        (false, true) => Err(io::ErrorKind::IsADirectory.into()),
        (true, false) => Err(io::ErrorKind::NotADirectory.into()),
        _ => Ok(()),
    }
}

/// Lets two entries swap names in one step, so that an interruption leaves either the one or the other.
#[cfg(target_os = "linux")]
pub(crate) fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

/// Other systems are not supported.
#[cfg(not(target_os = "linux"))]
pub(crate) fn exchange(_one: &Path, _other: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The names in `folder`, sorted.
fn entries_of(folder: &Path) -> io::Result<Vec<std::ffi::OsString>> {
    let names = std::fs::read_dir(folder)?.map(|it| it.map(|it| it.file_name()));
    let mut names = names.collect::<io::Result<Vec<_>>>()?;
    names.sort();
    Ok(names)
}

/// Brings all names in `folder`, and in the folders of it, to the disk.
fn sync_folders(folder: &Path) -> io::Result<()> {
    for name in entries_of(folder)? {
        let path = folder.join(name);
        if std::fs::symlink_metadata(&path)?.is_dir() {
            sync_folders(&path)?;
        }
    }
    sync_folder(folder)
}

/// Brings the names in `folder` to the disk, where the system has that notion.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All files below `folder` with their contents, sorted by name.
    fn files_in(folder: &Path) -> Vec<(String, String)> {
        let mut files = Vec::new();
        for name in entries_of(folder).unwrap() {
            let path = folder.join(&name);
            let name = name.into_string().unwrap();
            if path.is_dir() {
                files.extend(files_in(&path).into_iter().map(|(it, text)| (format!("{name}/{it}"), text)));
                continue;
            }
            files.push((name, std::fs::read_to_string(path).unwrap()));
        }
        files
    }

    fn set(folder: &Path, files: &[(&str, &str)]) -> Result<WholeSet, ArchiveError> {
        let set = WholeSet::within(folder)?;
        files.iter().try_for_each(|(name, text)| set.write(name, text.as_bytes()))?;
        Ok(set)
    }

    #[track_caller]
    fn check(folder: &Path, expected: &[(&str, &str)]) {
        let files = files_in(folder);
        let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (&**name, &**text)).collect();
        assert_eq!(files, expected);
    }

    #[test]
    fn a_set_appears_together_and_replaces_what_was_there() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("deep/ci");
        drop(set(&folder, &[("run/a", "1"), ("b", "1")]).unwrap());
        assert!(files_in(root.path()).is_empty() && !root.path().join("deep").exists());
        set(&folder, &[("run/a", "1"), ("b", "1")]).unwrap().finish().unwrap();
        check(&folder, &[("b", "1"), ("run/a", "1")]);
        std::fs::write(folder.join("mine"), "stays").unwrap();
        set(&folder, &[("run/c", "2"), ("b", "2")]).unwrap().finish().unwrap();
        check(&folder, &[("b", "2"), ("mine", "stays"), ("run/c", "2")]);
    }

    /// However the second entry is hindered, the first is removed again.
    #[test]
    fn what_cannot_take_its_name_leaves_everything_as_it_was() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path();
        set(folder, &[("a", "1"), ("run/a", "1"), ("z/a", "1")]).unwrap().finish().unwrap();
        let before = [("a", "1"), ("run/a", "1"), ("z/a", "1")];
        for files in [&[("a", "2"), ("z", "2")][..], &[("a/b", "2"), ("new", "2")]] {
            let error = set(folder, files).unwrap().finish().unwrap_err();
            assert!(error.to_string().starts_with("cannot write"), "{error}");
            check(folder, &before);
        }
        let half = set(folder, &[("a", "2"), ("new", "2"), ("run/b", "2")]).unwrap();
        let [a, new, run] = ["a", "new", "run"].map(|name| (half.staged().join(name), folder.join(name)));
        let mut placed = Vec::new();
        for (from, to) in [&a, &new, &run] {
            placed.push((from, to, place(from, to, half.staged()).unwrap()));
        }
        check_names(folder, &["a", "new", "run", "z"]);
        placed.into_iter().rev().for_each(|(from, to, before)| before.restore(from, to));
        drop(half);
        check(folder, &before);
    }

    #[track_caller]
    fn check_names(folder: &Path, expected: &[&str]) {
        let names = entries_of(folder).unwrap().into_iter().map(|it| it.into_string().unwrap());
        assert_eq!(names.filter(|it| !it.starts_with('.')).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn errors_have_the_names_that_files_would_have_had() {
        let root = tempfile::tempdir().unwrap();
        let set = set(root.path(), &[("a", "1")]).unwrap();
        let error = set.write("a/b", b"2").unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {:?}", root.path().join("a/b")));
    }
}
