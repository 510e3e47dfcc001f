//! Data sets from elsewhere: those at addresses, which are read from a cache, and those that `data get` fetches.
//!
//! A program that was built without the feature `remote` has the same items; no other code asks what was built in.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use scans::dataset::download::Download;

use crate::plumbing::failure::{Failure, Usage};

#[cfg(feature = "remote")]
mod with_remote;
#[cfg(feature = "remote")]
use with_remote::fetched;
#[cfg(feature = "remote")]
pub use with_remote::get;
#[cfg(not(feature = "remote"))]
mod without_remote;
#[cfg(not(feature = "remote"))]
use without_remote::fetched;
#[cfg(not(feature = "remote"))]
pub use without_remote::get;

/// Part of a public data set that is fetched, and where to.
#[allow(dead_code, reason = "read where there is something to fetch with")]
pub struct GetPlan<'a> {
    pub id: &'a str,
    /// The download of the catalogue; `None` if only the file of a link is fetched.
    pub download: Option<&'a Download>,
    /// Link of the file that is fetched instead.
    pub link: Option<&'a str>,
    /// The drives; all if there are none.
    pub drives: &'a [String],
    /// The folder that it goes to.
    pub into: &'a Path,
    /// Largest size of the files of an archive, in GB, if one was given.
    pub unpack_at_most_gb: Option<u64>,
    /// Whether it is a dry run, which fetches nothing.
    pub is_dry_run: bool,
}

/// Files that have been fetched.
pub struct Got {
    /// Files that arrived, or were there.
    pub n_files: usize,
    /// Their size in bytes, in words.
    pub size: String,
    /// Archives of a kind that is not unpacked.
    pub packed: Vec<PathBuf>,
}

/// The path or id by which the data set `name` is read: of an address, the folder of the cache that it is fetched into.
pub fn local_name<'a>(name: &'a str, cache: Option<&Path>) -> Result<Cow<'a, str>, Failure> {
    if !name.contains("://") {
        return Ok(Cow::Borrowed(name));
    }
    let path = fetched(name, &cache_folder(cache)?)?;
    match path.into_os_string().into_string() {
        Ok(path) => Ok(Cow::Owned(path)),
        Err(path) => Err(Usage(format!("{path:?} is not Unicode; choose another --cache")).into()),
    }
}

/// The folder in which fetched files are kept.
fn cache_folder(chosen: Option<&Path>) -> Result<PathBuf, Usage> {
    if let Some(chosen) = chosen {
        return Ok(chosen.to_path_buf());
    }
    let folder_in = |variable: &str| {
        let value = std::env::var_os(variable).map(PathBuf::from);
        // The rules of XDG: relative paths count as unset.
        value.filter(|it| it.is_absolute())
    };
    let caches = folder_in("XDG_CACHE_HOME").or_else(|| Some(folder_in("HOME")?.join(".cache")));
    let caches =
        caches.ok_or_else(|| Usage("HOME is not set; say with --cache where to fetch to".to_owned()))?;
    Ok(caches.join("scanbench"))
}
