//! How the program ends when something is wrong.

use reports::archive::ArchiveError;

use crate::dataset::DatasetError;
use crate::run::config::ConfigError;
use crate::run::detector_list::DetectorListError;
use crate::run::side_by_side::RunError;

/// Expected endings, with their documented exit codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Failure {
    /// A bug, or a machine that gave up, such as a full disk.
    Internal = 1,
    /// Wrong usage or configuration.
    Usage = 2,
    /// Data missing or damaged.
    Data = 3,
    /// Nothing was evaluated.
    NothingEvaluated = 4,
    /// Ended by the user; what shells report for Ctrl-C.
    Interrupted = 130,
}

/// The data sets hold nothing to evaluate.
#[derive(Debug, thiserror::Error)]
#[error("nothing was evaluated: {reason}")]
pub struct NothingEvaluated {
    /// Why.
    pub reason: String,
}
