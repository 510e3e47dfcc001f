//! Registry of unfinished files and folders on the disk, so that they can be removed when the program is interrupted.
//!
//! They are made, named and removed one at a time under one lock, so that its holder sees all of them, each either
//! unfinished or finished. Nothing that takes long belongs under the lock.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

/// All unfinished files and folders, in the order in which they were begun.
static UNFINISHED: Mutex<Vec<Entry>> = Mutex::new(Vec::new());
static N_BEGUN: AtomicU64 = AtomicU64::new(0);

/// Longest that removing waits for a thread that makes or names something: only a disk that hangs takes longer.
const LONGEST_WAIT: Duration = Duration::from_secs(5);
/// How often a folder is emptied again, because another thread has made a file in it meanwhile.
const MOST_ATTEMPTS: usize = 100;

#[derive(Debug)]
struct Entry {
    number: u64,
    path: PathBuf,
    kind: Kind,
}

/// Kind of an unfinished entry, and so how it is removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A file.
    File,
    /// A file in memory that another program maps, and no part of a result.
    Memory,
    /// A folder with its content.
    Folder,
    /// A folder if it is empty.
    EmptyFolder,
}

/// An unfinished file or folder, registered for as long as this lives.
#[derive(Debug)]
#[must_use = "what is not registered is not removed"]
pub struct Unfinished {
    number: u64,
}

impl Unfinished {
    /// Makes something and registers it as unfinished, in one step; `path_of` returns its path.
    ///
    /// # Errors
    ///
    /// The error of `make`, or if the path cannot be made absolute.
    pub fn begin<T>(
        kind: Kind,
        make: impl FnOnce() -> io::Result<T>,
        path_of: impl FnOnce(&T) -> PathBuf,
    ) -> io::Result<(Self, T)> {
        let mut entries = lock();
        let made = make()?;
        // A program may change its working folder.
        let path = std::path::absolute(path_of(&made))?;
        let number = N_BEGUN.fetch_add(1, Ordering::Relaxed);
        entries.push(Entry { number, path, kind });
        Ok((Self { number }, made))
    }

    /// Runs `step`, such as writing or renaming; nothing is removed meanwhile.
    pub fn undisturbed<T>(&self, step: impl FnOnce() -> T) -> T {
        let _entries = lock();
        step()
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        lock().retain(|it| it.number != self.number);
    }
}

fn lock() -> MutexGuard<'static, Vec<Entry>> {
    // The list is complete even after a panic under the lock.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Paths of all parts of results that are unfinished.
pub fn unfinished_results() -> Vec<PathBuf> {
    lock().iter().filter(|it| it.kind != Kind::Memory).map(|it| it.path.clone()).collect()
}

/// Removes everything unfinished, the latest first. From then on nothing can be begun or finished: a thread that tries
/// waits for the end of the program.
pub fn remove_for_good() {
    let Some(mut entries) = lock_before(Instant::now() + LONGEST_WAIT) else { return };
    while let Some(entry) = entries.pop() {
        entry.remove();
    }
    std::mem::forget(entries);
}

/// Leaves everything as it is for good: a later call of [`remove_for_good`] does nothing.
pub fn keep_for_good() {
    std::mem::forget(lock());
}

fn lock_before(deadline: Instant) -> Option<MutexGuard<'static, Vec<Entry>>> {
    loop {
        match UNFINISHED.try_lock() {
            Ok(entries) => return Some(entries),
            Err(TryLockError::Poisoned(entries)) => return Some(entries.into_inner()),
            Err(TryLockError::WouldBlock) if Instant::now() > deadline => return None,
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

impl Entry {
    /// Removes the entry. Errors are not reported: the program is about to end.
    fn remove(&self) {
        match self.kind {
            Kind::File | Kind::Memory => {
                let _ = std::fs::remove_file(&self.path);
            }
            Kind::EmptyFolder => {
                let _ = std::fs::remove_dir(&self.path);
            }
            // Other threads still write to it.
            Kind::Folder => {
                for _ in 0..MOST_ATTEMPTS {
                    match std::fs::remove_dir_all(&self.path) {
                        Err(error) if error.kind() != io::ErrorKind::NotFound => {
                            std::thread::sleep(Duration::from_millis(1));
                        }
                        _ => break,
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Whether something at `path` would be removed.
    fn is_registered(path: &Path) -> bool {
        lock().iter().any(|it| it.path == path)
    }

    #[test]
    fn shared_memory_is_no_result() {
        let begin = |kind, path: &str| Unfinished::begin(kind, || Ok(()), |()| path.into()).unwrap().0;
        let [points, out] = ["/nowhere/points", "/nowhere/out"];
        let _begun = [begin(Kind::Memory, points), begin(Kind::File, out)];
        let results = unfinished_results();
        assert!(results.contains(&out.into()) && !results.contains(&points.into()), "{results:?}");
        assert!(is_registered(Path::new(points)));
    }

    #[test]
    fn what_is_dropped_is_not_registered() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let make = || std::fs::write(&path, "");
        let (unfinished, ()) = Unfinished::begin(Kind::File, make, |()| path.clone()).unwrap();
        assert!(is_registered(&path));
        assert_eq!(unfinished.undisturbed(|| 7), 7);
        drop(unfinished);
        assert!(!is_registered(&path));
    }

    #[test]
    fn what_cannot_be_made_is_not_registered() {
        let path = Path::new("/nowhere");
        let made = Unfinished::begin(
            Kind::File,
            || Err::<(), _>(io::ErrorKind::NotFound.into()),
            |()| path.to_path_buf(),
        );
        assert!(made.is_err() && !is_registered(path));
    }

    #[test]
    fn a_folder_goes_although_somebody_writes_to_it() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("partial");
        std::fs::create_dir(&folder).unwrap();
        let entry = Entry { number: 0, path: folder.clone(), kind: Kind::Folder };
        std::thread::scope(|scope| {
            scope.spawn(|| {
                // Ends when the folder is gone.
                for number in 0.. {
                    if std::fs::write(folder.join(number.to_string()), "").is_err() {
                        break;
                    }
                }
            });
            entry.remove();
        });
        assert!(!folder.exists());
    }
}
