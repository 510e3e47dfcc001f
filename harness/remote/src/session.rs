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

/// This many files arrive at a time.
const N_AT_A_TIME: usize = 16;
/// How often to look whether the user asks for an end.
const GLANCE: Duration = Duration::from_millis(50);

/// How checksums are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SumPolicy {
    /// Checks files against the checksums that the server states.
    Check,
    /// Checks them also against the `SHA256SUMS` in the folder, and writes the checksums of all files there.
    CheckAndKeep,
}

/// How files are fetched.
pub struct FetchPlan<'a> {
    /// The folder that they go to.
    pub into: &'a Path,
    /// When a file that is there need not be fetched.
    pub freshness: Freshness,
    /// How checksums are used.
    pub sums: SumPolicy,
    /// The option of the program that chooses the folder, for errors.
    pub folder_option: &'static str,
    /// Told of every byte that arrives and was never there before.
    pub on_bytes: &'a (dyn Fn(u64) + Sync),
    /// Told of a server that is slow.
    pub on_slow: OnSlow<'a>,
}

/// Files that are missing in a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Missing {
    /// Number of files.
    pub n_files: usize,
    /// Bytes that have yet to arrive.
    pub n_bytes: u64,
}

/// A conversation with stores.
pub struct Session<'a> {
    // Invariant: `None` only while it is dropped.
    runtime: Option<Runtime>,
    interrupted: &'a AtomicBool,
    patience: Patience,
}

impl<'a> Session<'a> {
    /// Begins a session, which ends once `interrupted` is set, or when a server takes more than `patience`.
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
    /// [`RemoteError::Nothing`] if there are none, and errors of the server.
    pub fn all(&self, store: &Store, on_slow: OnSlow<'_>) -> Result<Vec<RemoteFile>, RemoteError> {
        self.run(store, store.all(), &Going { on_slow, ..Going::default() })
    }

    /// The names of the folders at the address of `store`, sorted.
    ///
    /// # Errors
    ///
    /// Errors of the server.
    pub fn folders(&self, store: &Store, on_slow: OnSlow<'_>) -> Result<Vec<String>, RemoteError> {
        self.run(store, store.folders(), &Going { on_slow, ..Going::default() })
    }

    /// The files at `names` below the address of `store`, sorted by name; of a name that ends in `/`, all below that folder.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Nothing`] if one is not there, and errors of the server.
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
    /// [`RemoteError::NoRoom`] before anything arrives; otherwise the first error. The bytes that have arrived are kept.
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
            // Also the checksums of files that arrived before an error.
            write_sums(plan.into, &found)?;
        }
        fetched
    }

    /// Runs `work` with `store`, as long as there is progress.
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
            // A plain drop would wait for the checksum of a large file.
            runtime.shutdown_background();
        }
    }
}

/// Called with a sentence about a slow server.
pub type OnSlow<'a> = &'a dyn Fn(&str);

/// Files that are done, of how many, and the callback for slow servers.
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

/// State that is shared while files arrive.
struct SoFar<'a> {
    /// Checksums from earlier runs.
    known: &'a Sums,
    /// Those of `known`, and of the files that are done.
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

/// Files, and bytes of them, that are missing in `folder`.
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

/// Removes files in `folder` of a cache that are none of `files`: the server has them no more. Hidden files stay, as they
/// may be on their way.
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

/// The transfer that `file` needs; `None` if it is there, and its checksum is known or does not matter.
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
