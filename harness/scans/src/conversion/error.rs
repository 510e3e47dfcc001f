//! Errors of conversions.

use std::path::PathBuf;

use reports::files::archive::ArchiveError;

use crate::dataset::DatasetError;

/// Why scans cannot be converted.
#[derive(Debug, thiserror::Error)]
pub enum ConversionError {
    /// The scans cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A file cannot be written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// A file or folder cannot be written.
    #[error("cannot write {path:?}")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A recording cannot be written.
    #[error("cannot write {path:?}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// Error of the library.
        source: mcap::McapError,
    },
    /// The file or folder exists already.
    #[error("{path:?} exists; choose another name or remove it")]
    Occupied {
        /// The file or folder.
        path: PathBuf,
    },
    /// Another program is writing the folder.
    #[error("another program is writing {path:?}; choose another name, or wait for it")]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// A drive has more objects than the format has numbers for.
    #[error(
        "drive {drive:?} has at least {n_objects} objects, but {format} has only {max} numbers; objects without a track count once in each scan; take fewer scans with --scans"
    )]
    TooManyObjects {
        /// The drive.
        drive: String,
        /// Its objects, as far as they were counted.
        n_objects: u32,
        /// The format.
        format: &'static str,
        /// The most that it has numbers for.
        max: u32,
    },
    /// The format cannot hold the scan.
    #[error("scan {scan} cannot be written as {format}: {problem}")]
    Unwritable {
        /// The scan.
        scan: String,
        /// The format.
        format: &'static str,
        /// Why not.
        problem: String,
    },
}
