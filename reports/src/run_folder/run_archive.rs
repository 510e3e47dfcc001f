//! A run as it is read back from its directory.

use std::path::{Path, PathBuf};

use crate::files::archive::ArchiveError;
use crate::files::csv_rows::{each_row, read_rows};
use crate::numbers::run_report::RunReport;
use crate::numbers::tally::Tally;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::ScanRow;
use crate::run_folder::manifest::Manifest;
use crate::run_folder::run_directory::{
    KITTI_OBJECT_CSV, MATCHES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_FILES, PROTOCOL_LABELS_CSV, REPORT_JSON,
    SCANS_CSV,
};
use crate::run_folder::run_target::MANIFEST_JSON;

/// Everything that a run left behind but pictures and recordings.
#[derive(Debug, Clone)]
pub struct RunArchive {
    /// How it came about.
    pub manifest: Manifest,
    /// Its numbers.
    pub report: RunReport,
    /// One row for every scan, detector and task.
    pub scans: Vec<ScanRow>,
    /// One row for every pair, and for every annotation and detection that is in none.
    pub matches: Vec<MatchRow>,
    /// What came of it under protocols of others.
    pub protocols: ProtocolTally,
    /// The files of rows that this was made of.
    pub protocol_files: Vec<PathBuf>,
}

impl RunArchive {
    /// Reads the run in `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if a file is missing or damaged.
    pub fn read(directory: &Path) -> Result<Self, ArchiveError> {
        Ok(Self {
            manifest: Manifest::read(&directory.join(MANIFEST_JSON))?,
            report: RunReport::read(&directory.join(REPORT_JSON))?,
            scans: read_rows(&directory.join(SCANS_CSV))?,
            matches: read_rows(&directory.join(MATCHES_CSV))?,
            protocols: Self::protocol_tally(directory)?,
            protocol_files: protocol_files(directory),
        })
    }

    fn protocol_tally(directory: &Path) -> Result<ProtocolTally, ArchiveError> {
        let mut tally = ProtocolTally::default();
        let boxes = directory.join(PROTOCOL_BOXES_CSV);
        if boxes.exists() {
            each_row(&boxes, |row| tally.add_ranked_box(&row))?;
        }
        let path = directory.join(KITTI_OBJECT_CSV);
        if path.exists() {
            each_row(&path, |row| tally.add_kitti_object(&row))?;
            tally.check().map_err(|problem| ArchiveError::Contradiction { path, problem })?;
        }
        let labels = directory.join(PROTOCOL_LABELS_CSV);
        if labels.exists() {
            each_row(&labels, |row| tally.add_label_score(&row))?;
        }
        Ok(tally)
    }

    /// Its sums.
    pub fn tally(&self) -> Tally {
        let mut tally = self.manifest.tally();
        for row in &self.scans {
            tally.add_scan(row);
        }
        for row in &self.matches {
            tally.add_match(row);
        }
        tally
    }
}

/// The files of rows under protocols of others that `directory` has.
fn protocol_files(directory: &Path) -> Vec<PathBuf> {
    let files = PROTOCOL_FILES.map(|it| directory.join(it));
    files.into_iter().filter(|it| it.is_file()).collect()
}
