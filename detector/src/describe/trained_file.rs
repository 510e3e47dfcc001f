//! The provenance of all files that training writes.

use serde::{Deserialize, Serialize};

/// Provenance of a trained file: enough to make it again.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The command that makes it.
    pub command: String,
    /// Data sets it was trained on.
    pub data: Vec<String>,
    /// The seed of everything random.
    pub seed: u64,
    /// The part of the data that was held out.
    pub split: String,
}
