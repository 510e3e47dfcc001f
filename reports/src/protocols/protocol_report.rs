//! `protocols.json`: the numbers of a run under protocols of others.

use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;

use super::protocol_number::ProtocolNumber;
use crate::files::archive::{ArchiveError, SCHEMA, read_json};

/// The numbers of a run under protocols of others.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProtocolReport {
    #[serde(rename = "schema")]
    _schema: u32,
    /// The numbers, in the order of tables.
    pub rows: Vec<ProtocolNumber>,
}

impl ProtocolReport {
    /// Of these numbers.
    pub fn new(rows: Vec<ProtocolNumber>) -> Self {
        Self { _schema: SCHEMA, rows }
    }

    /// The content of the file: one number a line.
    pub fn to_json(&self) -> String {
        let mut json = format!("{{\n  \"schema\": {SCHEMA},\n  \"rows\": [");
        for (place, row) in self.rows.iter().enumerate() {
            let separator = if place == 0 { "" } else { "," };
            let row = serde_json::to_string(row).expect("a row has text keys and finite numbers");
            write!(json, "{separator}\n    {row}").expect("a string takes all that is written");
        }
        json.push_str("\n  ]\n}\n");
        json
    }

    /// Reads the file.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if it cannot be read or is damaged.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        read_json(path)
    }
}
