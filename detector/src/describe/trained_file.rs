//! What all files that training writes have in common.

use serde::{Deserialize, Serialize};

/// What a file was made of: enough to make it again.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The command that makes it.
    pub command: String,
    /// Data sets it was trained on.
    pub data: Vec<String>,
    /// The seed of everything random.
    pub seed: u64,
    /// What was held out.
    pub split: String,
}
