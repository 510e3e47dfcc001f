//! Events of a run: lines of its journal, and of the log of a shard.

use std::collections::BTreeMap;
use std::ops::Range;

use reports::files::csv_rows::csv_text;
use reports::rows::agreement_row::AgreementRow;
use reports::rows::match_row::MatchRow;
use reports::rows::official_rows::OfficialRows;
use reports::rows::pose_row::PoseRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::shard_record::ShardRecording;
use reports::worst::points::Patch;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunEvent {
    /// The program began, or began again, on this processor.
    Began {
        /// The processor's own name.
        cpu_model: String,
    },
    /// A scan was judged.
    Scan(Box<ScanEvent>),
    /// A scan was left out because it is damaged.
    Skipped {
        /// Index of its data set in the run.
        dataset_idx: usize,
        /// Its id.
        scan: String,
        /// Why it is damaged.
        reason: String,
    },
    /// Boxes of a detector are suspect.
    Doubt {
        /// Name of the detector.
        detector: String,
        /// On which data set, and why.
        doubt: String,
    },
    /// A recording was completed.
    Recorded(ShardRecording),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScanEvent {
    /// Index of its data set in the run.
    pub dataset_idx: usize,
    /// Its index among the scans of the data set that were selected.
    pub place: usize,
    /// Its number among all scans of the run.
    pub number: u64,
    /// Whether it is labelled, if only to say that nothing stands there.
    pub is_labeled: bool,
    /// Annotations of any kind.
    pub n_labels: u64,
    /// Points without a position.
    pub n_points_left_out: u64,
    /// Rows of `scans.csv`.
    #[serde(with = "csv_text")]
    pub scans: Vec<ScanRow>,
    /// Rows of `matches.csv`.
    #[serde(with = "csv_text")]
    pub matches: Vec<MatchRow>,
    /// Rows of `stages.csv`.
    #[serde(with = "csv_text")]
    pub stages: Vec<StageRow>,
    /// Row of `poses.csv`, if the pose is known.
    #[serde(with = "csv_text", default)]
    pub pose: Vec<PoseRow>,
    /// Rows under protocols of others.
    pub official: OfficialRows,
    /// How far detectors agree; empty for a labelled scan.
    pub agreement: Vec<AgreementRow>,
    /// Points around those of its mistakes that may be among the worst.
    pub patches: Vec<Patch>,
}

/// How far a run or a shard is.
#[derive(Debug, Clone, Default)]
pub struct EventProgress {
    /// By data set that has been begun, the index behind its last scan that was judged.
    pub next_indices: BTreeMap<usize, usize>,
    /// Scans that were judged.
    pub n_scans: usize,
    /// How often it was begun.
    pub n_starts: usize,
}

impl EventProgress {
    /// Whether `event` can come next; `parts` are the scans of each data set that are to be done.
    pub fn allows(&self, event: &RunEvent, parts: &[Range<usize>]) -> bool {
        match event {
            RunEvent::Began { .. } | RunEvent::Doubt { .. } | RunEvent::Recorded(_) => true,
            RunEvent::Skipped { dataset_idx, .. } => *dataset_idx < parts.len(),
            RunEvent::Scan(scan) => {
                let is_new = self.next_indices.get(&scan.dataset_idx).is_none_or(|it| scan.place >= *it);
                is_new && parts.get(scan.dataset_idx).is_some_and(|it| it.contains(&scan.place))
            }
        }
    }

    pub fn add(&mut self, event: &RunEvent) {
        match event {
            RunEvent::Began { .. } => self.n_starts += 1,
            RunEvent::Scan(scan) => {
                self.n_scans += 1;
                self.next_indices.insert(scan.dataset_idx, scan.place + 1);
            }
            RunEvent::Skipped { .. } | RunEvent::Doubt { .. } | RunEvent::Recorded(_) => {}
        }
    }
}
