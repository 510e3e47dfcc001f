//! Transfer of one object into one file.
//!
//! Bytes that arrive go to `.NAME.partial-ID` beside the file, where the ID stands for the object as it was listed. The next
//! attempt goes on at its end, also after an interruption, but never with another object. The file gets its name once it is
//! on the disk, its size is right, and so is its checksum if one is known.

use std::fs::{File, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use futures_util::StreamExt as _;

use crate::RemoteError;
use crate::local_file::open_to_add;
use crate::store::{RemoteFile, Store};
use crate::sums::{RunningSum, sha256_of};

/// This many more attempts follow one that brings nothing.
const N_ATTEMPTS: u32 = 4;
/// The first pause between two attempts; each is twice as long as the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
/// Parts of errors about servers that do not send files from the middle on.
const WITHOUT_RANGES: [&str; 3] = ["Range request not supported", "non-partial response", "416 "];
/// How often to look whether another program that fetches the same object is done.
const PATIENCE: Duration = Duration::from_millis(200);

/// When a file that is there is taken to be the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freshness {
    /// It has the size of the object.
    Size,
    /// It has the size of the object, and its time if the server states one.
    SizeAndTime,
}

/// A checksum that a file must have, and where it is stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpectedSum {
    pub sha256: String,
    pub stated: String,
}

/// A plan to fetch one object into a file.
pub(crate) struct Transfer<'a> {
    pub store: &'a Store,
    pub file: &'a RemoteFile,
    pub path: PathBuf,
    pub freshness: Freshness,
    pub expected: Option<ExpectedSum>,
    /// Whether its checksum is computed in any case.
    pub is_summed: bool,
    /// Told of every byte that arrives and was never there before.
    pub on_bytes: &'a (dyn Fn(u64) + Sync),
}

/// Whether `path` is the file that `file` becomes.
pub(crate) fn is_there(file: &RemoteFile, path: &Path, freshness: Freshness) -> bool {
    let Ok(found) = std::fs::metadata(path) else { return false };
    let has_time = || match (file.modified, found.modified()) {
        // Disks keep fractions of a second differently.
        (Some(listed), Ok(written)) => seconds_of(listed) == seconds_of(written),
        _ => true,
    };
    found.is_file() && found.len() == file.n_bytes && (freshness == Freshness::Size || has_time())
}

fn seconds_of(time: SystemTime) -> Option<u64> {
    time.duration_since(SystemTime::UNIX_EPOCH).ok().map(|it| it.as_secs())
}

/// How many bytes of `file` have arrived in its partial file.
pub(crate) fn n_bytes_kept(store: &Store, file: &RemoteFile, path: &Path) -> u64 {
    std::fs::metadata(partial_path(store, file, path)).map_or(0, |it| it.len()).min(file.n_bytes)
}

/// The partial file of `file`.
fn partial_path(store: &Store, file: &RemoteFile, path: &Path) -> PathBuf {
    let mut id = RunningSum::default();
    let modified = file.modified.and_then(seconds_of).unwrap_or(0);
    let e_tag = file.e_tag.as_deref().unwrap_or_default();
    id.add(format!("{} {e_tag} {modified} {}", store.shown(&file.location), file.n_bytes).as_bytes());
    let id = &id.finish()[..12];
    path.with_file_name(format!("{}{id}", beginning_of_partials(path)))
}

fn beginning_of_partials(path: &Path) -> String {
    format!(".{}.partial-", path.file_name().unwrap_or_default().to_string_lossy())
}

impl Transfer<'_> {
    /// Fetches the file, and returns its checksum if it was computed.
    pub(crate) async fn run(&self) -> Result<Option<String>, RemoteError> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|error| RemoteError::write(folder, error))?;
        let partial = partial_path(self.store, self.file, &self.path);
        let mut lock = self.locked(&partial).await?;
        if is_there(self.file, &self.path, self.freshness) {
            // Another program has fetched it meanwhile; our partial file may be empty.
            remove_if_empty(&partial);
            return self.sum_of(self.path.clone()).await;
        }
        self.remove_stale_partials(&partial);
        self.fill(&mut lock, &partial).await?;
        let sum = self.finish(lock, partial).await?;
        Ok(sum)
    }

    /// Opens the partial file and locks it, once no other program writes to it.
    async fn locked(&self, partial: &Path) -> Result<File, RemoteError> {
        loop {
            let file = open_to_add(partial);
            let file = file.map_err(|error| RemoteError::write(partial, error))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    let _busy = self.store.progress.busy();
                    tokio::time::sleep(PATIENCE).await;
                }
                // Some disks know no locks.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(file),
            }
        }
    }

    /// Removes the bytes of older versions of the object, which are of no use.
    fn remove_stale_partials(&self, partial: &Path) {
        let begin = beginning_of_partials(&self.path);
        let folder = self.path.parent().into_iter().filter_map(|it| std::fs::read_dir(it).ok());
        for entry in folder.flatten().flatten() {
            if entry.path() != partial && entry.file_name().to_string_lossy().starts_with(&begin) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Appends the missing bytes to `partial`, with as many attempts as get further than all before, and a few more.
    async fn fill(&self, file: &mut File, partial: &Path) -> Result<(), RemoteError> {
        let write = |error| RemoteError::write(partial, error);
        let (mut n_in_vain, mut pause) = (0, FIRST_PAUSE);
        // A longer file is none of the object.
        let n_kept = file.metadata().map_err(write)?.len();
        let mut n_most = if n_kept > self.file.n_bytes { 0 } else { n_kept };
        let mut begins_anew = false;
        loop {
            let (n_before, n_most_before) = (file.metadata().map_err(write)?.len(), n_most);
            let error = match self.attempt(file, partial, (n_before, &mut n_most)).await {
                Ok(()) => return Ok(()),
                Err(error) => error,
            };
            if n_most > n_most_before {
                (n_in_vain, pause) = (0, FIRST_PAUSE);
            }
            n_in_vain += 1;
            let RemoteError::Unreachable { url, reason } = error else { return Err(error) };
            if n_before > 0 && WITHOUT_RANGES.iter().any(|it| reason.contains(it)) {
                file.set_len(0).map_err(write)?;
                begins_anew = true;
            }
            if n_in_vain > N_ATTEMPTS {
                let reason = if begins_anew {
                    let n_bytes = self.file.n_bytes;
                    format!(
                        "it sends the file from its beginning alone, and never got beyond byte {n_most} of {n_bytes}"
                    )
                } else {
                    reason
                };
                return Err(RemoteError::Unreachable { url, reason });
            }
            tokio::time::sleep(pause).await;
            pause *= 2;
        }
    }

    /// Fetches the bytes behind the `n_kept` that are there; `n_most` is how far any attempt got.
    async fn attempt(
        &self,
        file: &mut File,
        partial: &Path,
        (n_kept, n_most): (u64, &mut u64),
    ) -> Result<(), RemoteError> {
        let write = |error| RemoteError::write(partial, error);
        let url = || self.store.shown(&self.file.location);
        let mut n_kept = n_kept;
        if n_kept > self.file.n_bytes {
            file.set_len(0).map_err(write)?;
            n_kept = 0;
        }
        if n_kept == self.file.n_bytes {
            return Ok(());
        }
        let of_store = |error: &object_store::Error| RemoteError::of_store(&url(), error);
        let result = self.store.get_from(self.file, n_kept).await.map_err(|it| of_store(&it))?;
        if result.meta.size != self.file.n_bytes {
            let (expected, found) = (self.file.n_bytes, result.meta.size);
            return Err(RemoteError::Changed {
                url: url(),
                expected: format!("{expected} bytes"),
                found: format!("{found} bytes"),
            });
        }
        let mut stream = result.into_stream();
        while let Some(bytes) = stream.next().await {
            let bytes = bytes.map_err(|it| of_store(&it))?;
            file.write_all(&bytes).map_err(write)?;
            n_kept += bytes.len() as u64;
            let n_new = n_kept.saturating_sub(*n_most);
            *n_most += n_new;
            self.store.progress.bytes(n_new);
            (self.on_bytes)(n_new);
        }
        let n_bytes = file.metadata().map_err(write)?.len();
        if n_bytes == self.file.n_bytes {
            return Ok(());
        }
        let reason = format!("it ended after {n_bytes} of {} bytes", self.file.n_bytes);
        Err(RemoteError::Unreachable { url: url(), reason })
    }

    /// Checks the partial file, and gives it its name.
    async fn finish(&self, file: File, partial: PathBuf) -> Result<Option<String>, RemoteError> {
        let sum = self.sum_of(partial.clone()).await?;
        let (modified, path) = (self.file.modified, self.path.clone());
        let _busy = self.store.progress.busy();
        let named = in_background(move || {
            if let Some(modified) = modified {
                // The next run recognises the object by this time; without it, the file would be fetched again.
                let _ = file.set_modified(modified);
            }
            file.sync_all()?;
            std::fs::rename(&partial, &path)
        });
        named.await.map_err(|error| RemoteError::write(&self.path, error))?;
        Ok(sum)
    }

    /// The checksum of the file at `path`, if it is wanted; if it is wrong, the file is removed, and that is an error.
    async fn sum_of(&self, path: PathBuf) -> Result<Option<String>, RemoteError> {
        if self.expected.is_none() && !self.is_summed {
            return Ok(None);
        }
        let of_path = path.clone();
        let _busy = self.store.progress.busy();
        let found = in_background(move || sha256_of(&of_path)).await;
        let found = found.map_err(|error| RemoteError::write(&path, error))?;
        let Some(ExpectedSum { sha256, stated }) = self.expected.clone().filter(|it| it.sha256 != found)
        else {
            return Ok(Some(found));
        };
        std::fs::remove_file(&path).map_err(|error| RemoteError::write(&path, error))?;
        let url = self.store.shown(&self.file.location);
        Err(RemoteError::Checksum { url, expected: sha256, stated, found })
    }
}

/// Runs `work`, which keeps the disk or a processor busy, while other files arrive.
async fn in_background<T: Send + 'static>(
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> io::Result<T> {
    tokio::task::spawn_blocking(work).await.map_err(io::Error::other)?
}

fn remove_if_empty(path: &Path) {
    if std::fs::metadata(path).is_ok_and(|it| it.len() == 0) {
        let _ = std::fs::remove_file(path);
    }
}
