//! A run as it is read back from its directory.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::files::archive::{ArchiveError, read_json};
use crate::files::csv_rows::{each_row, read_rows};
use crate::numbers::run_report::RunReport;
use crate::numbers::tally::Tally;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::rows::match_row::MatchRow;
use crate::rows::partial_row::PartialRow;
use crate::rows::scan_row::ScanRow;
use crate::run_folder::manifest::Manifest;
use crate::run_folder::run_directory::{
    KITTI_OBJECT_CSV, MATCHES_CSV, PARTIAL_CSV, POSES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_FILES,
    PROTOCOL_LABELS_CSV, REPORT_JSON, REPRODUCTION_JSON, SCANS_CSV,
};
use crate::run_folder::run_target::MANIFEST_JSON;
use crate::vocabulary::claim_verdict::ClaimVerdict;

/// Everything in the directory of a run but pictures and recordings.
#[derive(Debug, Clone)]
pub struct RunArchive {
    /// How it came about.
    pub manifest: Manifest,
    /// Its numbers.
    pub report: RunReport,
    /// One row for every scan, detector and task.
    pub scans: Vec<ScanRow>,
    /// One row for every pair, and for every annotation and detection that is in none. A sweep keeps none.
    pub matches: Vec<MatchRow>,
    /// The predicted classes of partly seen objects, of a result of `partial`: it has nothing else but its manifest.
    pub objects: Vec<PartialRow>,
    /// Its rows under protocols of others.
    pub protocols: ProtocolTally,
    /// The verdicts on the claims of the papers, of a run by `reproduce`.
    pub claims: Vec<ClaimRecord>,
    /// Files that only some runs have, and that this was read from.
    pub more_files: Vec<PathBuf>,
}

/// The verdict on a claim.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ClaimRecord {
    /// The claim.
    pub claim: ClaimName,
    /// The verdict.
    pub verdict: ClaimVerdict,
}

/// The name of a claim.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ClaimName {
    /// The letters of the paper.
    pub paper: String,
    /// Section, table and figure.
    pub place: String,
    /// The claim, in our words.
    pub says: String,
}

#[derive(Deserialize)]
struct Reproduction {
    claims: Vec<ClaimRecord>,
}

impl RunArchive {
    /// Reads the run in `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if a file is missing or damaged.
    pub fn read(directory: &Path) -> Result<Self, ArchiveError> {
        let manifest = Manifest::read(&directory.join(MANIFEST_JSON))?;
        if manifest.partial.is_some() {
            return Ok(Self::of_partial(manifest, read_rows(&directory.join(PARTIAL_CSV))?));
        }
        let has_matches = manifest.sweep.is_none();
        Ok(Self {
            manifest,
            report: RunReport::read(&directory.join(REPORT_JSON))?,
            scans: read_rows(&directory.join(SCANS_CSV))?,
            matches: if has_matches { read_rows(&directory.join(MATCHES_CSV))? } else { Vec::new() },
            objects: Vec::new(),
            protocols: Self::protocol_tally(directory)?,
            claims: claims(&directory.join(REPRODUCTION_JSON))?,
            more_files: more_files(directory),
        })
    }

    /// A result of `partial` with these rows.
    pub(crate) fn of_partial(manifest: Manifest, objects: Vec<PartialRow>) -> Self {
        Self {
            manifest,
            report: RunReport::default(),
            scans: Vec::new(),
            matches: Vec::new(),
            objects,
            protocols: ProtocolTally::default(),
            claims: Vec::new(),
            more_files: Vec::new(),
        }
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

    /// The names of its detectors, in the order of its tables.
    pub fn detector_names(&self) -> Vec<&str> {
        self.manifest.detectors.iter().map(|it| it.name.as_str()).collect()
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

fn claims(path: &Path) -> Result<Vec<ClaimRecord>, ArchiveError> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    read_json(path).map(|it: Reproduction| it.claims)
}

/// The files of rows under protocols of others, of claims, and of poses, that `directory` has.
fn more_files(directory: &Path) -> Vec<PathBuf> {
    let names = PROTOCOL_FILES.into_iter().chain([REPRODUCTION_JSON, POSES_CSV]);
    names.map(|it| directory.join(it)).filter(|it| it.is_file()).collect()
}
