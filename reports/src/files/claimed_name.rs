//! Names that are claimed before a file or folder has them.

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::files::new_file::{has_no_locks, open_to_add};
use crate::files::unfinished::{Kind, Unfinished};
use crate::files::whole_file::folder_of;

/// A name in a folder that no other program can claim while this lives.
///
/// It is a lock on a hidden file beside the name. The system lifts it however the program ends. The file is removed when
/// this is dropped.
#[derive(Debug)]
#[must_use = "a name is claimed for as long as this lives"]
pub struct ClaimedName {
    lock_file: PathBuf,
    unfinished: Unfinished,
    // Unlocked after the file has been removed.
    _locked: File,
}

impl ClaimedName {
    /// Claims the name of `target`, whose folder must exist; `None` if it is already claimed.
    ///
    /// # Errors
    ///
    /// If nothing can be written there.
    pub fn claim(target: &Path) -> io::Result<Option<Self>> {
        let name = target.file_name().unwrap_or_default();
        let lock_file = folder_of(target).join(format!(".{}.lock", name.to_string_lossy()));
        match Unfinished::begin(Kind::File, || locked(&lock_file), |_| lock_file.clone()) {
            Ok((unfinished, locked)) => Ok(Some(Self { lock_file, unfinished, _locked: locked })),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

impl Drop for ClaimedName {
    fn drop(&mut self) {
        // If this fails, only an empty hidden file stays.
        let _ = self.unfinished.undisturbed(|| std::fs::remove_file(&self.lock_file));
    }
}

/// The file `path`, made if it is not there, and locked.
fn locked(path: &Path) -> io::Result<File> {
    loop {
        let file = open_to_add(path)?;
        match file.try_lock() {
            // Not every file system knows locks.
            Err(TryLockError::Error(error)) if !has_no_locks(&error) => return Err(error),
            Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::WouldBlock.into()),
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        // The previous holder of the lock may have removed the file: then this locks nothing.
        if is_at(&file, path)? {
            return Ok(file);
        }
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;

    let ours = file.metadata()?;
    match std::fs::metadata(path) {
        Ok(there) => Ok((there.dev(), there.ino()) == (ours.dev(), ours.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// On other systems an open file keeps its name.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_claimed_once_until_it_is_given_back() {
        let folder = tempfile::tempdir().unwrap();
        let claim = |name: &str| ClaimedName::claim(&folder.path().join(name)).unwrap();
        let first = claim("a");
        assert!(first.is_some() && claim("a").is_none());
        assert!(claim("b").is_some());
        drop(first);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(claim("a").is_some());
    }

    #[test]
    fn what_a_killed_program_leaves_claims_nothing() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(".a.lock"), "").unwrap();
        assert!(ClaimedName::claim(&folder.path().join("a")).unwrap().is_some());
    }

    #[test]
    fn of_many_who_claim_at_once_one_has_it() {
        use std::sync::atomic::{AtomicUsize, Ordering};

        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let [n_holding, n_had] = [AtomicUsize::new(0), AtomicUsize::new(0)];
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..500 {
                        let Some(claim) = ClaimedName::claim(&target).unwrap() else { continue };
                        assert_eq!(n_holding.fetch_add(1, Ordering::SeqCst), 0, "two have it");
                        n_had.fetch_add(1, Ordering::SeqCst);
                        n_holding.fetch_sub(1, Ordering::SeqCst);
                        drop(claim);
                    }
                });
            }
        });
        assert!(n_had.into_inner() > 0);
    }
}
