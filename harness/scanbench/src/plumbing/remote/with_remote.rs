//! Fetches data sets.

use std::path::{Path, PathBuf};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use remote::RemoteError;
use remote::address::Address;
use remote::error::in_bytes;
use remote::patience::Patience;
use remote::session::{FetchPlan, Missing, Session, SumPolicy, missing, prune};
use remote::space::free_bytes;
use remote::store::{Access, RemoteFile, Store};
use remote::transfer::Freshness;
use remote::unpack::{UnpackPlan, is_unpacked, unpack};
use scans::dataset::download::{Download, DownloadDrives};

use super::{GetPlan, Got};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::interruption::{interruption_flag, set_last_words};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_diagnostic;

/// Fetches the files at `address` that are not yet in a folder of `cache`, and returns the path of the file or folder.
pub fn fetched(address: &str, cache: &Path) -> Result<PathBuf, Failure> {
    let address = Address::parse(address)?;
    let store = Store::open(&address, &Access::default())?;
    let session = Session::new(interruption_flag(), patience()?)?;
    let files = session.all(&store, &say_slow(&address.shown()))?;
    let path = cache.join(address.cache_folder());
    let is_file = files.iter().any(|it| it.is_at(&address));
    let folder = if is_file { path.parent().unwrap_or(cache) } else { &path };
    if !is_file {
        prune(folder, &files)?;
    }
    let plan = Fetching {
        label: &address.shown(),
        folder,
        freshness: Freshness::SizeAndTime,
        sums: SumPolicy::Check,
    };
    let missing = plan.fetch(&session, &store, &files, "--cache")?;
    let shown = address.shown();
    if missing.n_files == 0 {
        print_diagnostic(format_args!("{shown}: {} files as they are in {}", files.len(), path.display()));
    } else {
        let (n_missing, n_files, size) = (missing.n_files, files.len(), in_bytes(missing.n_bytes));
        let path = path.display();
        print_diagnostic(format_args!(
            "{shown}: fetched {n_missing} of {n_files} files, {size}, into {path}"
        ));
    }
    Ok(path)
}

/// Fetches a data set from its makers, and unpacks it.
pub fn get(plan: &GetPlan<'_>) -> Result<Got, Failure> {
    let session = Session::new(interruption_flag(), patience()?)?;
    let (store, mut files) = match (plan.link, plan.download) {
        (Some(link), _) => {
            let store = Store::open(&Address::parse_link(link)?, &Access::default())?;
            let files = session.all(&store, &say_slow(&store.address().shown()))?;
            (store, files)
        }
        (None, Some(download)) => listed(&session, download, plan)?,
        (None, None) => return Err(Usage(format!("{:?} has nothing to fetch", plan.id)).into()),
    };
    for file in files.iter_mut().filter(|it| is_zip(&it.name)) {
        // Not in a folder of its own: the files in it have one.
        file.name = file.name.rsplit('/').next().unwrap_or_default().to_owned();
    }
    let n_bytes = files.iter().map(|it| it.n_bytes).sum();
    let got = Got { n_files: files.len(), size: in_bytes(n_bytes), packed: packed(&files, plan.into) };
    files.retain(|it| !(is_zip(&it.name) && is_unpacked(&plan.into.join(&it.name), it.n_bytes)));
    say_how_much(plan, &missing(&store, &files, plan.into, Freshness::Size));
    if plan.is_dry_run {
        return Ok(got);
    }
    set_last_words("What has arrived is kept: the same command goes on from there.".to_owned());
    let fetching = Fetching {
        label: plan.id,
        folder: plan.into,
        freshness: Freshness::Size,
        sums: SumPolicy::CheckAndKeep,
    };
    fetching.fetch(&session, &store, &files, "--into")?;
    for file in files.iter().filter(|it| is_zip(&it.name)) {
        print_diagnostic(format_args!("unpacking {}", file.name));
        let wanted = plan.download.map_or(&[][..], |it| &it.unpack);
        let how = UnpackPlan {
            into: plan.into,
            wanted,
            folder_option: "--into",
            n_most_bytes: plan.unpack_at_most_gb.map(|it| it.saturating_mul(1_000_000_000)),
            interrupted: interruption_flag(),
        };
        unpack(&plan.into.join(&file.name), &how)?;
    }
    Ok(got)
}

/// The bucket or server, and the files in it that the catalogue names.
fn listed(
    session: &Session<'_>,
    download: &Download,
    plan: &GetPlan<'_>,
) -> Result<(Store, Vec<RemoteFile>), Failure> {
    let access = Access { is_public: true, region: download.region.clone() };
    let store = Store::open(&Address::parse(&download.from)?, &access)?;
    let drives = match (download.drives(), plan.drives) {
        (DownloadDrives::None, []) => Vec::new(),
        (DownloadDrives::None, _) => {
            return Err(Usage(format!("{:?} is fetched as a whole; leave --drive away", plan.id)).into());
        }
        (DownloadDrives::Listed(all), []) => all.into_iter().collect(),
        (DownloadDrives::Listed(all), chosen) => {
            if let Some(unknown) = chosen.iter().find(|it| !all.contains(*it)) {
                let known = all.into_iter().collect::<Vec<_>>().join(", ");
                return Err(Usage(format!("{:?} has no drive {unknown:?}; it has {known}", plan.id)).into());
            }
            chosen.to_vec()
        }
        (DownloadDrives::Folders, []) => session.folders(&store, &say_slow(plan.id))?,
        (DownloadDrives::Folders, chosen) => chosen.to_vec(),
    };
    let files = session.named(&store, &download.paths_of(&drives), &say_slow(plan.id))?;
    Ok((store, files))
}

/// Variable with the longest wait for a server, in seconds; a minute if it is not set.
const PATIENCE_VARIABLE: &str = "SCANBENCH_PATIENCE_S";

fn patience() -> Result<Patience, Usage> {
    let Some(text) = std::env::var_os(PATIENCE_VARIABLE).filter(|it| !it.is_empty()) else {
        return Ok(Patience { limit: Duration::from_mins(1) });
    };
    let seconds = text.to_str().and_then(|it| it.parse().ok()).filter(|it| (1..=86_400).contains(it));
    let seconds = seconds.ok_or_else(|| {
        Usage(format!("{PATIENCE_VARIABLE}={text:?} is no number of seconds from 1 to 86400"))
    })?;
    Ok(Patience { limit: Duration::from_secs(seconds) })
}

/// Says that the server of `label` is slow.
fn say_slow(label: &str) -> impl Fn(&str) {
    move |sentence| print_diagnostic(format_args!("{label}: {sentence}"))
}

/// Prints how much has yet to arrive, and how much is free on the disk.
fn say_how_much(plan: &GetPlan<'_>, missing: &Missing) {
    let folder = plan.into.display();
    let room =
        free_bytes(plan.into).map_or_else(String::new, |it| format!(", where {} are free", in_bytes(it)));
    print_diagnostic(format_args!(
        "{}: {} in {} files to fetch into {folder}{room}",
        plan.id,
        in_bytes(missing.n_bytes),
        missing.n_files
    ));
}

fn is_zip(name: &str) -> bool {
    has_ending(name, &[".zip"])
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let name = name.to_ascii_lowercase();
    endings.iter().any(|it| name.ends_with(it))
}

/// The archives among `files` that the user has to unpack.
fn packed(files: &[RemoteFile], folder: &Path) -> Vec<PathBuf> {
    let endings = [".tgz", ".tar.gz", ".tar", ".tar.bz2", ".tar.xz", ".tar.zst"];
    files.iter().filter(|it| has_ending(&it.name, &endings)).map(|it| folder.join(&it.name)).collect()
}

/// Files that are fetched behind a bar.
struct Fetching<'a> {
    label: &'a str,
    folder: &'a Path,
    freshness: Freshness,
    sums: SumPolicy,
}

impl Fetching<'_> {
    /// Fetches those of `files` that are missing, and returns how much that was.
    fn fetch(
        &self,
        session: &Session<'_>,
        store: &Store,
        files: &[RemoteFile],
        folder_option: &'static str,
    ) -> Result<Missing, Failure> {
        let missing = missing(store, files, self.folder, self.freshness);
        let bar = progress_over_bytes(missing.n_bytes, self.label);
        let _cleared = Cleared(&bar);
        let plan = FetchPlan {
            into: self.folder,
            freshness: self.freshness,
            sums: self.sums,
            folder_option,
            on_bytes: &|n_bytes| bar.inc(n_bytes),
            on_slow: &|sentence| bar.suspend(|| say_slow(self.label)(sentence)),
        };
        session.fetch(store, files, &plan)?;
        Ok(missing)
    }
}

/// A bar over `n_bytes` bytes of `label` that arrive.
fn progress_over_bytes(n_bytes: u64, label: &str) -> ProgressBar {
    let bar = progress_over_scans(0, label);
    let template =
        "{msg} {wide_bar} {decimal_bytes}/{decimal_total_bytes}, {decimal_bytes_per_sec}, {eta} left";
    bar.set_style(
        ProgressStyle::with_template(template).expect("the template is constant and tested by use"),
    );
    bar.set_length(n_bytes);
    bar
}

/// Takes the bar away before an error is printed, too.
struct Cleared<'a>(&'a ProgressBar);

impl Drop for Cleared<'_> {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

impl From<RemoteError> for Failure {
    fn from(error: RemoteError) -> Self {
        match &error {
            RemoteError::Address { .. } => Self::Usage(error.into()),
            RemoteError::NoRoom { .. } => Self::Unwritten(error.into()),
            RemoteError::Write { source, .. } => Self::of_writing(source.kind(), error),
            RemoteError::Interrupted { .. } => Self::Interrupted(error.into()),
            RemoteError::Nothing { .. }
            | RemoteError::Refused { .. }
            | RemoteError::Unreachable { .. }
            | RemoteError::Changed { .. }
            | RemoteError::Checksum { .. }
            | RemoteError::Sums { .. }
            | RemoteError::Archive { .. }
            | RemoteError::Growth { .. } => Self::Data(error.into()),
        }
    }
}
