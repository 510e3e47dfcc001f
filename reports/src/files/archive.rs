//! Shared parts of the files of a run: their version, and the errors of reading and writing them.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::regular_file::read_text;

/// Version of the layout of `report.json`, `manifest.json` and the CSV files; raised when a reader of the old layout
/// would misread the new one.
pub const SCHEMA: u32 = 1;

/// The largest JSON file of a run, in bytes: that of a year of drives has some megabytes.
const MOST_OF_JSON: u64 = 1 << 28;

/// Error of reading or writing a file of a run.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    /// The operating system refused to read.
    #[error("cannot read {path:?}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The operating system refused to write.
    #[error("cannot write {path:?}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file was written by another version of this program.
    #[error("{path:?} has schema {found}, but this program reads schema {expected}")]
    Schema {
        /// The file.
        path: PathBuf,
        /// The schema this program reads, [`SCHEMA`].
        expected: u32,
        /// The schema of the file.
        found: u32,
    },
    /// The file is not JSON, or not the JSON it should be; the source says at which line and column.
    #[error("{path:?} is damaged")]
    Json {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// Rows contradict each other.
    #[error("the rows of {path:?} contradict each other: {problem}")]
    Contradiction {
        /// The file.
        path: PathBuf,
        /// Where and how.
        problem: String,
    },
    /// A row cannot be written or read; the source says which and why.
    #[error("bad row in {path:?}")]
    Csv {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: csv::Error,
    },
    /// The columns of a CSV file are not the expected ones.
    #[error("{path:?} has the columns {found:?}, expected {expected:?}")]
    Columns {
        /// The file.
        path: PathBuf,
        /// The columns this program reads.
        expected: String,
        /// The columns of the file.
        found: String,
    },
}

/// The content of a JSON file that people read, too.
pub fn pretty_json(value: &(impl Serialize + ?Sized)) -> String {
    serde_json::to_string_pretty(value).expect("keys are text and numbers finite") + "\n"
}

/// Reads a JSON file that names the version of its layout as `schema` at its top level.
///
/// # Errors
///
/// [`ArchiveError`] if the file cannot be read, has another schema than [`SCHEMA`], or does not hold a `T`.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, ArchiveError> {
    #[derive(Deserialize)]
    struct SchemaOnly {
        schema: u32,
    }

    let damaged = |source| ArchiveError::Json { path: path.to_path_buf(), source };
    let text = read_text(path, MOST_OF_JSON)
        .map_err(|source| ArchiveError::Read { path: path.to_path_buf(), source })?;
    // The version is checked first, so that a newer file is called newer and not damaged.
    let SchemaOnly { schema } = serde_json::from_str(&text).map_err(damaged)?;
    if schema != SCHEMA {
        return Err(ArchiveError::Schema { path: path.to_path_buf(), expected: SCHEMA, found: schema });
    }
    serde_json::from_str(&text).map_err(damaged)
}
