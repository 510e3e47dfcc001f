//! What the journal of a shard holds: everything about a scan that its files are made of.

use std::collections::BTreeMap;

use reports::rows::agreement_row::AgreementRow;
use reports::rows::official_rows::OfficialLines;
use reports::run_folder::shard_record::ShardRecording;
use reports::worst::points::Patch;
use serde::{Deserialize, Serialize};

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShardEntry {
    /// The program began, or began again, on this processor.
    Began {
        /// The processor's own name.
        cpu_model: String,
    },
    /// A scan was judged.
    Scan(Box<ShardScan>),
    /// A scan was left out because it is damaged.
    Skipped {
        /// Index of its data set in the run.
        dataset_idx: usize,
        /// Which it is.
        scan: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Boxes of a detector are suspect.
    Doubt {
        /// Its name.
        detector: String,
        /// On which data set, and why.
        doubt: String,
    },
    /// A recording was completed.
    Recorded(ShardRecording),
}

/// A scan that was judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShardScan {
    /// Index of its data set in the run.
    pub dataset_idx: usize,
    /// Its index among the scans of the data set that were selected.
    pub place: usize,
    /// Its number among all scans of the run.
    pub number: u64,
    /// Whether its labels say something, if only that nothing stands there.
    pub is_labeled: bool,
    /// Annotations of any kind.
    pub n_labels: u64,
    /// Points without a position.
    pub n_points_left_out: u64,
    /// Lines of `scans.csv`.
    pub scans: String,
    /// How many these are.
    pub n_scan_rows: u64,
    /// Lines of `matches.csv`.
    pub matches: String,
    /// Lines of `stages.csv`.
    pub stages: String,
    /// Lines of the files of protocols of others.
    pub official: OfficialLines,
    /// How far detectors agree; nothing of a labelled scan.
    pub agreement: Vec<AgreementRow>,
    /// What the sensor saw around those of its mistakes that may be among the worst.
    pub patches: Vec<Patch>,
}

/// How far a shard is.
#[derive(Debug, Clone, Default)]
pub struct ShardProgress {
    /// Of each data set that has been begun, the index behind its last scan that was judged.
    pub next_indices: BTreeMap<usize, usize>,
    /// Scans that were judged.
    pub n_scans: usize,
    /// How often it was begun.
    pub n_starts: usize,
}

impl ShardProgress {
    /// Takes in what happened.
    pub fn add(&mut self, entry: &ShardEntry) {
        match entry {
            ShardEntry::Began { .. } => self.n_starts += 1,
            ShardEntry::Scan(scan) => {
                self.n_scans += 1;
                self.next_indices.insert(scan.dataset_idx, scan.place + 1);
            }
            ShardEntry::Skipped { .. } | ShardEntry::Doubt { .. } | ShardEntry::Recorded(_) => {}
        }
    }
}
