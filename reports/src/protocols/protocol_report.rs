//! `protocols.json`: the numbers of a run under protocols of others.

use std::fmt::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

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
    /// The report of these numbers.
    pub fn new(rows: Vec<ProtocolNumber>) -> Self {
        Self { _schema: SCHEMA, rows }
    }

    /// The content of the file: one number a line.
    pub fn to_json(&self) -> String {
        json_of_rows(self.rows.iter())
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

/// Text of a file with these rows, one a line.
pub(super) fn json_of_rows(rows: impl Iterator<Item = impl Serialize>) -> String {
    let mut json = format!("{{\n  \"schema\": {SCHEMA},\n  \"rows\": [");
    for (index, row) in rows.enumerate() {
        let separator = if index == 0 { "" } else { "," };
        let row = serde_json::to_string(&row).expect("a row has text keys and finite numbers");
        write!(json, "{separator}\n    {row}").expect("a string takes all that is written");
    }
    json.push_str("\n  ]\n}\n");
    json
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::protocols::protocol_number::ProtocolMetric;
    use crate::vocabulary::metric::Direction;
    use crate::vocabulary::protocol::Protocol;

    fn number(value: Option<f64>) -> ProtocolNumber {
        let blocks = BlockCount::of_dataset(3, BlockKind::Seconds);
        ProtocolNumber {
            protocol: Protocol::Nuscenes,
            dataset: "street".to_owned(),
            detector: "mine".to_owned(),
            metric: ProtocolMetric {
                class: "car".to_owned(),
                id: "ate_m".to_owned(),
                unit: "m",
                direction: Direction::LowerIsBetter,
                n: 12,
            },
            value,
            interval: value.map(|it| Interval { ends: [it - 0.1, it + 0.1], blocks }),
        }
    }

    fn read(text: &str) -> Result<ProtocolReport, ArchiveError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("protocols.json");
        std::fs::write(&path, text).unwrap();
        ProtocolReport::read(&path)
    }

    #[test]
    fn a_report_reads_back_as_it_was() {
        let report = ProtocolReport::new(vec![number(Some(0.25)), number(None)]);
        assert_eq!(read(&report.to_json()).unwrap(), report);
        assert!(report.to_json().contains("\"caveat\":\"interval from only 3 blocks of scans\""));
    }

    #[test]
    fn damage_is_refused() {
        let json = ProtocolReport::new(vec![number(Some(0.25))]).to_json();
        for (from, to) in
            [("\"m\"", "\"mile\""), ("nuscenes", "newscenes"), ("\"n\"", "\"m\""), ("seconds", "hours")]
        {
            assert!(read(&json.replacen(from, to, 1)).is_err(), "{to}");
        }
    }
}
