//! Many objects at a time, until the user asks for an end.

use std::collections::BTreeSet;
use std::fs::FileType;
use std::future::Future;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use futures_util::{StreamExt as _, TryStreamExt as _};
use tokio::runtime::Runtime;

use crate::RemoteError;
use crate::local_file::create;
use crate::patience::{Look, Patience, Wait};
use crate::space::check_space;
use crate::store::{RemoteFile, Store};
use crate::sums::{SUMS_FILE, Sums, read_sums, sums_text};
use crate::transfer::{ExpectedSum, Freshness, Transfer, is_there, n_bytes_kept};

/// So many files arrive at a time.
const N_AT_A_TIME: usize = 16;
/// How often to look whether the user asks for an end.
const GLANCE: Duration = Duration::from_millis(50);

/// What becomes of checksums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SumPolicy {
    /// Those that the server states are checked.
    Check,
    /// So are those of the `SHA256SUMS` in the folder, and those of all files are written there.
    CheckAndKeep,
}

/// How files are fetched.
pub struct FetchPlan<'a> {
    /// The folder that they go to.
    pub into: &'a Path,
    /// When a file that is there need not be fetched.
    pub freshness: Freshness,
    /// What becomes of checksums.
    pub sums: SumPolicy,
    /// The option of the program that chooses the folder, for errors.
    pub folder_option: &'static str,
    /// Told of every byte that arrives and was never there before.
    pub on_bytes: &'a (dyn Fn(u64) + Sync),
    /// Told of a server that is slow.
    pub on_slow: OnSlow<'a>,
}

/// What is missing of some files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Missing {
    /// Files.
    pub n_files: usize,
    /// Bytes that have yet to arrive.
    pub n_bytes: u64,
}

/// A conversation with stores.
pub struct Session<'a> {
    // Nothing but None while it is dropped.
    runtime: Option<Runtime>,
    interrupted: &'a AtomicBool,
    patience: Patience,
}

impl<'a> Session<'a> {
    /// Begins one, which ends once `interrupted` is set, or when a server takes more than `patience`.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Unreachable`] if the system gives no thread for it.
    pub fn new(interrupted: &'a AtomicBool, patience: Patience) -> Result<Self, RemoteError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| RemoteError::Unreachable {
            url: "the network".to_owned(),
            reason: error.to_string(),
        })?;
        Ok(Self { runtime: Some(runtime), interrupted, patience })
    }

    /// All files at the address of `store`, sorted by name: those below it, or the one that it names.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Nothing`] if there are none, and what servers say.
    pub fn all(&self, store: &Store, on_slow: OnSlow<'_>) -> Result<Vec<RemoteFile>, RemoteError> {
        self.run(store, store.all(), &Going { on_slow, ..Going::default() })
    }

    /// The names of the folders at the address of `store`, sorted.
    ///
    /// # Errors
    ///
    /// What servers say.
    pub fn folders(&self, store: &Store, on_slow: OnSlow<'_>) -> Result<Vec<String>, RemoteError> {
        self.run(store, store.folders(), &Going { on_slow, ..Going::default() })
    }

    /// The files at `names` below the address of `store`, sorted by name; of a name that ends in `/`, all below that folder.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Nothing`] if one is not there, and what servers say.
    pub fn named(
        &self,
        store: &Store,
        names: &[String],
        on_slow: OnSlow<'_>,
    ) -> Result<Vec<RemoteFile>, RemoteError> {
        self.run(store, store.named(names), &Going { on_slow, ..Going::default() })
    }

    /// Fetches those of `files` that are not in the folder yet.
    ///
    /// # Errors
    ///
    /// [`RemoteError::NoRoom`] before anything arrives; the first thing that goes wrong, after which what has arrived is
    /// kept.
    pub fn fetch(
        &self,
        store: &Store,
        files: &[RemoteFile],
        plan: &FetchPlan<'_>,
    ) -> Result<(), RemoteError> {
        let missing = missing(store, files, plan.into, plan.freshness);
        check_space(plan.into, missing.n_bytes, plan.folder_option)?;
        let known = match plan.sums {
            SumPolicy::Check => Sums::new(),
            SumPolicy::CheckAndKeep => read_sums(plan.into)?,
        };
        let found = Mutex::new(known.clone());
        let going = Going { n_done: AtomicUsize::new(0), n_files: files.len(), on_slow: plan.on_slow };
        let so_far = SoFar { known: &known, found: &found, n_done: &going.n_done };
        let transfers = files.iter().map(|file| fetch_one(store, file, plan, &so_far));
        let transfers = futures_util::stream::iter(transfers).buffer_unordered(N_AT_A_TIME);
        let fetched = self.run(store, transfers.try_collect::<()>(), &going);
        let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        if plan.sums == SumPolicy::CheckAndKeep && found != known {
            // Also of what has arrived before something went wrong.
            write_sums(plan.into, &found)?;
        }
        fetched
    }

    /// Does `work` with `store`, as long as that gets on.
    fn run<T>(
        &self,
        store: &Store,
        work: impl Future<Output = Result<T, RemoteError>>,
        going: &Going<'_>,
    ) -> Result<T, RemoteError> {
        let end = async {
            let mut wait = Wait::begin(&store.progress, self.patience, Instant::now());
            loop {
                tokio::time::sleep(GLANCE).await;
                if self.interrupted.load(Ordering::Relaxed) {
                    let n_done = going.n_done.load(Ordering::Relaxed);
                    return RemoteError::Interrupted { n_done, n_files: going.n_files };
                }
                match wait.look(Instant::now()) {
                    Look::Well => {}
                    Look::Slow(sentence) => (going.on_slow)(&sentence),
                    Look::Over(reason) => {
                        return RemoteError::Unreachable { url: store.address().shown(), reason };
                    }
                }
            }
        };
        let runtime = self.runtime.as_ref().expect("it is there until it is dropped");
        runtime.block_on(async {
            let (work, end) = (std::pin::pin!(work), std::pin::pin!(end));
            match futures_util::future::select(work, end).await {
                futures_util::future::Either::Left((done, _)) => done,
                futures_util::future::Either::Right((error, _)) => Err(error),
            }
        })
    }
}

impl Drop for Session<'_> {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            // A checksum of a large file would be waited for.
            runtime.shutdown_background();
        }
    }
}

/// Told of a server that is slow, in a sentence.
pub type OnSlow<'a> = &'a dyn Fn(&str);

/// How far work is, and who is told that it is slow.
struct Going<'a> {
    n_done: AtomicUsize,
    n_files: usize,
    on_slow: OnSlow<'a>,
}

impl Default for Going<'_> {
    fn default() -> Self {
        Self { n_done: AtomicUsize::new(0), n_files: 0, on_slow: &|_| {} }
    }
}

/// What is known while files arrive.
struct SoFar<'a> {
    /// Checksums from before.
    known: &'a Sums,
    /// These, and those of the files that are done.
    found: &'a Mutex<Sums>,
    n_done: &'a AtomicUsize,
}

async fn fetch_one(
    store: &Store,
    file: &RemoteFile,
    plan: &FetchPlan<'_>,
    so_far: &SoFar<'_>,
) -> Result<(), RemoteError> {
    if let Some(transfer) = transfer_of(store, file, plan, so_far.known)
        && let Some(sum) = transfer.run().await?
    {
        so_far.found.lock().unwrap_or_else(PoisonError::into_inner).insert(file.name.clone(), sum);
    }
    store.progress.answer();
    so_far.n_done.fetch_add(1, Ordering::Relaxed);
    Ok(())
}

/// What of `files` is not in `folder` yet.
pub fn missing(store: &Store, files: &[RemoteFile], folder: &Path, freshness: Freshness) -> Missing {
    let mut missing = Missing::default();
    for file in files {
        let path = folder.join(&file.name);
        if !is_there(file, &path, freshness) {
            missing.n_files += 1;
            missing.n_bytes += file.n_bytes - n_bytes_kept(store, file, &path);
        }
    }
    missing
}

/// Removes what is in `folder` of a cache, and is none of `files`: it was removed where it came from. What is hidden
/// stays, as it may be on its way.
///
/// # Errors
///
/// [`RemoteError::Write`].
pub fn prune(folder: &Path, files: &[RemoteFile]) -> Result<(), RemoteError> {
    let wanted: BTreeSet<PathBuf> = files.iter().map(|it| folder.join(&it.name)).collect();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(inner) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&inner) else { continue };
        for entry in entries.flatten() {
            let (path, kind) = (entry.path(), entry.file_type());
            if kind.as_ref().is_ok_and(FileType::is_dir) {
                folders.push(path);
            } else if !wanted.contains(&path) && !entry.file_name().to_string_lossy().starts_with('.') {
                std::fs::remove_file(&path).map_err(|error| RemoteError::write(&path, error))?;
            }
        }
    }
    Ok(())
}

/// What has to be done for `file`; nothing if it is there, and its checksum is known or does not matter.
fn transfer_of<'a>(
    store: &'a Store,
    file: &'a RemoteFile,
    plan: &'a FetchPlan<'a>,
    known: &Sums,
) -> Option<Transfer<'a>> {
    let path = plan.into.join(&file.name);
    let is_kept = plan.sums == SumPolicy::CheckAndKeep && file.name != SUMS_FILE;
    let known = known.get(&file.name).filter(|_| is_kept);
    if is_there(file, &path, plan.freshness) && (!is_kept || known.is_some()) {
        return None;
    }
    let stated = |sha256: &String, stated: String| ExpectedSum { sha256: sha256.clone(), stated };
    let by_server = file.sha256.as_ref().map(|it| stated(it, format!("{SUMS_FILE} of the server")));
    let by_folder = known.map(|it| stated(it, plan.into.join(SUMS_FILE).display().to_string()));
    Some(Transfer {
        store,
        file,
        path,
        freshness: plan.freshness,
        expected: by_server.or(by_folder),
        is_summed: is_kept,
        on_bytes: plan.on_bytes,
    })
}

/// Writes the checksums of a folder, whole or not at all.
pub(crate) fn write_sums(folder: &Path, sums: &Sums) -> Result<(), RemoteError> {
    let path = folder.join(SUMS_FILE);
    let partial = folder.join(format!(".{SUMS_FILE}.partial-{}", std::process::id()));
    let written = create(&partial)
        .and_then(|mut it| it.write_all(sums_text(sums).as_bytes()))
        .and_then(|()| std::fs::rename(&partial, &path));
    written.map_err(|error| RemoteError::write(&path, error))
}
