//! The path of a run directory, taken before the run begins.

use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};

use crate::files::archive::ArchiveError;
use crate::files::claimed_name::ClaimedName;
use crate::files::new_folders::NewFolders;
use crate::files::whole_file::folder_of;

/// How the run came about.
pub const MANIFEST_JSON: &str = "manifest.json";
/// Where runs go that nobody names a folder for, in the working directory.
pub const RUNS: &str = "runs";
/// Points at the newest run beside it.
pub const LATEST: &str = "latest";

/// Runs of one name that are distinguished by a number.
const MOST_OF_ONE_NAME: usize = 1000;

/// How to treat a target that exists. An empty folder is always taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExistingTarget {
    /// Leave it and fail.
    Refuse,
    /// Replace it, if it is the directory of an earlier run.
    Replace,
}

/// How to treat the name `latest` beside the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatestPointer {
    /// Let it point at this run.
    Update,
    /// Leave it alone.
    Leave,
}

/// Why a run directory cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RunDirectoryError {
    /// The path does not end in the name of a folder.
    #[error("{0:?} does not end in the name of a run; give one, such as runs/first")]
    NoName(PathBuf),
    /// The target exists.
    #[error("{0:?} exists; choose another name, remove it, or replace it")]
    Occupied(PathBuf),
    /// The target exists, is no run, and is not replaced.
    #[error(
        "{0:?} exists, but is not the directory of a run, which has a {MANIFEST_JSON}; it is not replaced"
    )]
    NotARun(PathBuf),
    /// Another run is writing it.
    #[error("another program is writing {0:?}; choose another name, or wait for it")]
    InUse(PathBuf),
    /// The name `latest` is taken by something that does not point at a run.
    #[error("{0:?} is not a link to the newest run; rename it")]
    LatestOccupied(PathBuf),
    /// The operating system refused.
    #[error("cannot write {path:?}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Its error.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
}

/// The path of a run directory, which no other run can take while this lives.
#[derive(Debug)]
#[must_use = "a path that is not held is anybody's"]
pub struct ClaimedTarget {
    // Invariant: given back before the folders around it may go: fields drop in the order of declaration.
    _name: ClaimedName,
    _new_parents: NewFolders,
    target: PathBuf,
    existing: ExistingTarget,
    latest: LatestPointer,
}

impl ClaimedTarget {
    /// Takes `target`; missing folders above it are made.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if nothing can be written there, if `target` exists and may not be replaced, or if another run
    /// has taken it.
    pub fn claim(
        target: &Path,
        existing: ExistingTarget,
        latest: LatestPointer,
    ) -> Result<Self, RunDirectoryError> {
        let name = target.file_name().ok_or_else(|| RunDirectoryError::NoName(target.into()))?;
        check_target(target, existing)?;
        let parent = folder_of(target);
        // A run that is itself called `latest` needs no pointer.
        let latest = if name == LATEST { LatestPointer::Leave } else { latest };
        if latest == LatestPointer::Update {
            check_latest(&parent.join(LATEST))?;
        }
        let new_parents = NewFolders::create(parent).map_err(refused(parent))?;
        let claimed = ClaimedName::claim(target).map_err(refused(parent))?;
        let name = claimed.ok_or_else(|| RunDirectoryError::InUse(target.into()))?;
        // The run that had it until now may have made something.
        check_target(target, existing)?;
        Ok(Self { _name: name, _new_parents: new_parents, target: target.into(), existing, latest })
    }

    /// Takes `name` in `folder` or, if that is taken or exists, `name-2`, `name-3` and so on.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if nothing can be written there.
    pub fn claim_unused(folder: &Path, name: &str, latest: LatestPointer) -> Result<Self, RunDirectoryError> {
        let names = (2..=MOST_OF_ONE_NAME).map(|number| format!("{name}-{number}"));
        for name in std::iter::once(name.to_owned()).chain(names) {
            let target = folder.join(name);
            if metadata(&target)?.is_some() {
                continue;
            }
            match Self::claim(&target, ExistingTarget::Refuse, latest) {
                Err(RunDirectoryError::InUse(_) | RunDirectoryError::Occupied(_)) => {}
                claimed => return claimed,
            }
        }
        Err(RunDirectoryError::Occupied(folder.join(name)))
    }

    /// Path of the finished run.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// How the name `latest` is treated.
    pub fn latest(&self) -> LatestPointer {
        self.latest
    }

    /// Fails if something was made there meanwhile that may not be replaced.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`].
    pub fn check(&self) -> Result<(), RunDirectoryError> {
        check_target(&self.target, self.existing)
    }
}

/// Turns an error of the operating system about `path` into our error.
pub(crate) fn refused(path: &Path) -> impl FnOnce(io::Error) -> RunDirectoryError {
    let path = path.to_path_buf();
    move |source| RunDirectoryError::Io { path, source }
}

/// Metadata of `path` itself, without following a link; `None` if nothing is there.
pub(crate) fn metadata(path: &Path) -> Result<Option<Metadata>, RunDirectoryError> {
    match std::fs::symlink_metadata(path) {
        Ok(metadata) => Ok(Some(metadata)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(path)(error)),
    }
}

pub(crate) fn is_empty_folder(path: &Path, metadata: &Metadata) -> Result<bool, RunDirectoryError> {
    Ok(metadata.is_dir() && std::fs::read_dir(path).map_err(refused(path))?.next().is_none())
}

/// Fails if `target` exists and may not be replaced.
fn check_target(target: &Path, existing: ExistingTarget) -> Result<(), RunDirectoryError> {
    let Some(metadata) = metadata(target)? else { return Ok(()) };
    if is_empty_folder(target, &metadata)? {
        return Ok(());
    }
    match existing {
        ExistingTarget::Refuse => Err(RunDirectoryError::Occupied(target.into())),
        // A slip of the keyboard must not cost a home directory.
        ExistingTarget::Replace if metadata.is_dir() && target.join(MANIFEST_JSON).is_file() => Ok(()),
        ExistingTarget::Replace => Err(RunDirectoryError::NotARun(target.into())),
    }
}

/// Fails if `latest` is something that was not put there by a run.
fn check_latest(latest: &Path) -> Result<(), RunDirectoryError> {
    match metadata(latest)? {
        Some(metadata) if cfg!(unix) && !metadata.is_symlink() || metadata.is_dir() => {
            Err(RunDirectoryError::LatestOccupied(latest.into()))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_taken_once() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let claim = || ClaimedTarget::claim(&target, ExistingTarget::Replace, LatestPointer::Leave);
        let first = claim().unwrap();
        assert!(matches!(claim(), Err(RunDirectoryError::InUse(_))));
        drop(first);
        drop(claim().unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_name_that_is_taken_or_there_gets_a_number() {
        let folder = tempfile::tempdir().unwrap();
        let runs = folder.path().join("runs");
        let claim = || ClaimedTarget::claim_unused(&runs, "a", LatestPointer::Update).unwrap();
        let first = claim();
        let second = claim();
        std::fs::create_dir(runs.join("a-3")).unwrap();
        let fourth = claim();
        let targets = [&first, &second, &fourth].map(|it| it.target().to_owned());
        assert_eq!(targets, ["a", "a-2", "a-4"].map(|it| runs.join(it)));
        drop(first);
        assert_eq!(claim().target(), runs.join("a"));
    }

    #[test]
    fn a_path_below_a_file_is_none() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = ClaimedTarget::claim_unused(file.path(), "a", LatestPointer::Leave).unwrap_err();
        assert!(matches!(error, RunDirectoryError::Io { .. }), "{error}");
    }
}
