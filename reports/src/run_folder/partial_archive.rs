//! A result of `scanbench partial` as it is read back from its directory.

use std::path::Path;

use crate::files::archive::ArchiveError;
use crate::files::csv_rows::read_rows;
use crate::rows::partial_row::PartialRow;
use crate::run_folder::partial_manifest::PartialManifest;
use crate::run_folder::run_directory::PARTIAL_CSV;
use crate::run_folder::run_target::MANIFEST_JSON;

/// Everything that tables, page and verdicts are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialArchive {
    /// How it came about.
    pub manifest: PartialManifest,
    /// A row for every object, step and method.
    pub rows: Vec<PartialRow>,
}

impl PartialArchive {
    /// Whether `directory` holds such a result.
    pub fn is_partial(directory: &Path) -> bool {
        directory.join(PARTIAL_CSV).is_file()
    }

    /// Reads the result in `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if a file is missing or damaged.
    pub fn read(directory: &Path) -> Result<Self, ArchiveError> {
        Ok(Self {
            manifest: PartialManifest::read(&directory.join(MANIFEST_JSON))?,
            rows: read_rows(&directory.join(PARTIAL_CSV))?,
        })
    }
}
