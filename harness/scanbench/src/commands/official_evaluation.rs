//! `--protocol`: what comes of a scan under protocols of others.

use std::collections::BTreeSet;

use evaluation::protocols::chosen_protocols::{ChosenProtocols, have_ground};
use evaluation::run::sink::{JudgedScan, WatchedDataset};
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::protocol::Protocol;

use crate::commands::failure::Failure;
use crate::commands::standard_streams::print_diagnostic;

/// Evaluates scans under some protocols.
pub struct OfficialEvaluation {
    chosen: ChosenProtocols,
    // Those that did not predict ground in some scan of the data set.
    without_ground: BTreeSet<&'static str>,
}

impl OfficialEvaluation {
    /// By `protocols`; `None` if there are none.
    pub fn of(protocols: &[Protocol]) -> Option<Self> {
        Some(Self { chosen: ChosenProtocols::of(protocols)?, without_ground: BTreeSet::new() })
    }

    /// Begins a data set.
    pub fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.without_ground.clear();
        Ok(self.chosen.check(watched.dataset)?)
    }

    /// The rows of a scan.
    pub fn rows(&mut self, judged: &JudgedScan<'_>) -> Result<OfficialRows, Failure> {
        let results = judged.results;
        let scan = self.chosen.scan(judged.watched.dataset, judged.scan_idx(), results.scan)?;
        let mut rows = OfficialRows::default();
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let of_detector = scan.rows(result.detector, &**detector, &result.output);
            if self.chosen.ask_for_ground() && !have_ground(&of_detector) {
                self.without_ground.insert(result.detector);
            }
            rows.append(of_detector);
        }
        Ok(rows)
    }

    /// Says which detectors did not predict what a protocol asks for.
    pub fn end_dataset(&self) {
        for name in &self.without_ground {
            print_diagnostic(warning_of_no_ground(name));
        }
    }
}

/// That a detector has no numbers of ground.
pub fn warning_of_no_ground(detector: &str) -> String {
    format!(
        "warning: {detector:?} does not predict which points are ground: it has no numbers under the protocol ground"
    )
}
