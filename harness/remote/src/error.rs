//! Errors between this machine and an object store.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

/// Answers of servers are quoted up to this many characters.
const LONGEST_REASON: usize = 200;

/// Error with the address, and with the way out where there is one. Addresses are shown without their queries, which may be
/// secret.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// The text is no address to fetch from.
    #[error("{address:?} is no address to fetch from: {problem}")]
    Address {
        /// As it was given.
        address: String,
        /// The problem with it, as the end of the sentence.
        problem: String,
    },
    /// The server has no such object.
    #[error("nothing is at {url}{remedy}")]
    Nothing {
        /// Its address.
        url: String,
        /// Another thing to try, as the end of the sentence.
        remedy: &'static str,
    },
    /// The server wants credentials, or refuses those that it got.
    #[error("{url} may not be read ({reason}); {remedy}")]
    Refused {
        /// Its address.
        url: String,
        /// Reason that the server gives.
        reason: String,
        /// How to be let in.
        remedy: &'static str,
    },
    /// No answer, or one that makes no sense, even after several attempts.
    #[error(
        "cannot fetch {url}: {reason}; what has arrived is kept, and the same command goes on from there"
    )]
    Unreachable {
        /// Its address.
        url: String,
        /// Reason why it failed.
        reason: String,
    },
    /// The object has changed since it was listed.
    #[error(
        "{url} changed while it was fetched: {expected} were expected, {found} found; run the same command again"
    )]
    Changed {
        /// Its address.
        url: String,
        /// The object as it was listed.
        expected: String,
        /// The object as it is now.
        found: String,
    },
    /// An object arrived with the wrong checksum.
    #[error(
        "{url} has the wrong checksum: SHA-256 {expected} was expected ({stated}), {found} found; it was thrown away. \
         Fetch it again; if the sum stays wrong, ask whoever publishes it"
    )]
    Checksum {
        /// Its address.
        url: String,
        /// The checksum that it should have.
        expected: String,
        /// Where that checksum is stated.
        stated: String,
        /// The checksum that it has.
        found: String,
    },
    /// A file of checksums that cannot be read.
    #[error(
        "{path}, line {line}, is no line of checksums: 64 hexadecimal digits, two spaces and the path of a file below"
    )]
    Sums {
        /// The file.
        path: String,
        /// Counted from 1.
        line: usize,
    },
    /// The disk is too small.
    #[error(
        "{folder:?} has room for {free}, but {needed} are missing; free some, or choose another folder with {option}",
        free = in_bytes(*.n_free_bytes), needed = in_bytes(*.n_needed_bytes)
    )]
    NoRoom {
        /// The folder that the files should go to.
        folder: PathBuf,
        /// How much has to arrive, in bytes.
        n_needed_bytes: u64,
        /// How much fits, in bytes.
        n_free_bytes: u64,
        /// The option that chooses a folder.
        option: &'static str,
    },
    /// A file or folder cannot be written.
    #[error(
        "cannot write {path:?}: {source}; what has arrived is kept, and the same command goes on from there"
    )]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An archive that cannot be unpacked.
    #[error("cannot unpack {path:?}: {reason}; remove it, and fetch it again")]
    Archive {
        /// The archive.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// An archive that would become far larger than archives of scans do.
    #[error(
        "{path:?} has {}, and would become {} where at most {} are taken; if that is right, add --unpack-at-most {}",
        in_bytes(*.n_archive_bytes), in_bytes(*.n_bytes), in_bytes(*.n_most_bytes),
        .n_bytes.div_ceil(1_000_000_000)
    )]
    Growth {
        /// The archive.
        path: PathBuf,
        /// Its size in bytes.
        n_archive_bytes: u64,
        /// The size of its files in bytes.
        n_bytes: u64,
        /// The most that its files may have, in bytes.
        n_most_bytes: u64,
    },
    /// The user interrupted the work.
    #[error("interrupted after {n_done} of {n_files} files; the same command goes on from there")]
    Interrupted {
        /// How many files are whole.
        n_done: usize,
        /// How many were asked for.
        n_files: usize,
    },
}

impl RemoteError {
    /// `path` cannot be written.
    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Self::Write { path: path.to_path_buf(), source }
    }

    /// The environment has no credentials for `url`.
    pub(crate) fn without_credentials(url: &str) -> Self {
        let reason = "there are no credentials in the environment".to_owned();
        Self::Refused { url: url.to_owned(), reason, remedy: HOW_TO_SIGN }
    }

    /// Error for `error` of the store about the object that is shown as `url`.
    pub(crate) fn of_store(url: &str, error: &object_store::Error) -> Self {
        let url = url.to_owned();
        let reason = innermost(error);
        match error {
            object_store::Error::NotFound { .. } => Self::Nothing { url, remedy: "" },
            object_store::Error::PermissionDenied { .. } | object_store::Error::Unauthenticated { .. } => {
                let remedy = if url.starts_with("http") {
                    "a link may have expired: get a new one"
                } else {
                    HOW_TO_SIGN
                };
                Self::Refused { url, reason, remedy }
            }
            object_store::Error::Precondition { .. } => {
                let found = "another object".to_owned();
                Self::Changed { url, expected: "the bytes of the listing".to_owned(), found }
            }
            _ => Self::Unreachable { url, reason },
        }
    }
}

/// How to get access to a bucket.
const HOW_TO_SIGN: &str = "give credentials by AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_REGION (s3) or \
                           GOOGLE_APPLICATION_CREDENTIALS (gs); for a bucket that is open to everybody set \
                           AWS_SKIP_SIGNATURE or GOOGLE_SKIP_SIGNATURE to true";

/// Message of the innermost cause, on one line.
fn innermost(error: &dyn Error) -> String {
    let mut last: &dyn Error = error;
    while let Some(source) = last.source() {
        last = source;
    }
    let text = last.to_string();
    let words: Vec<&str> = text.split(|it: char| it.is_whitespace() || it.is_control()).collect();
    let line = words.into_iter().filter(|it| !it.is_empty()).collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(LONGEST_REASON) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.trim_end_matches([':', ' ']).to_owned(),
    }
}

/// A number of bytes as people say it, in powers of a thousand: `1.5 GB`.
pub fn in_bytes(n_bytes: u64) -> String {
    let mut size = n_bytes as f64;
    for unit in ["bytes", "kB", "MB", "GB"] {
        if size < 999.5 {
            let decimals = usize::from(unit != "bytes" && size < 9.95);
            return format!("{size:.decimals$} {unit}");
        }
        size /= 1000.0;
    }
    format!("{size:.1} TB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_said_in_two_or_three_digits() {
        for (n_bytes, expected) in [
            (0, "0 bytes"),
            (999, "999 bytes"),
            (1_000, "1.0 kB"),
            (12_345, "12 kB"),
            (999_600, "1.0 MB"),
            (1_500_000_000, "1.5 GB"),
            (81_000_000_000, "81 GB"),
            (5_250_000_000_000, "5.2 TB"),
        ] {
            assert_eq!(in_bytes(n_bytes), expected);
        }
    }

    #[test]
    fn answers_of_servers_are_cut_to_a_line() {
        let error = io::Error::other(format!("<html>\n\u{1b}[31m {}", "x".repeat(500)));
        let reason = innermost(&error);
        assert!(reason.starts_with("<html> [31m xxx") && reason.ends_with('…'), "{reason}");
        assert_eq!(reason.chars().count(), LONGEST_REASON + 1);
    }
}
