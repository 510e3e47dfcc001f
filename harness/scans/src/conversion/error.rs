//! Why scans cannot be converted.

use std::path::PathBuf;

use reports::files::archive::ArchiveError;

use crate::dataset::DatasetError;

/// Why scans cannot be converted.
#[derive(Debug, thiserror::Error)]
pub enum ConversionError {
    /// They cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A file cannot be written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// Something cannot be written.
    #[error("cannot write {path:?}")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A recording cannot be written.
    #[error("cannot write {path:?}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: mcap::McapError,
    },
    /// There is something already.
    #[error("{path:?} exists; choose another name or remove it")]
    Occupied {
        /// The file or folder.
        path: PathBuf,
    },
    /// Somebody else is writing it.
    #[error("another program is writing {path:?}; choose another name, or wait for it")]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// A drive with more objects than the format has numbers for.
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
    /// The format cannot hold it.
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
