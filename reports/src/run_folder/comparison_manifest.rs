//! `manifest.json` of a comparison of two collections of scans: how it came about, so that it can be made again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::files::archive::pretty_json;
use crate::run_folder::manifest::{DatasetEntry, GitState};

/// Everything that decides the numbers of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComparisonManifest {
    /// Layout of the files beside it, [`SCHEMA`](crate::files::archive::SCHEMA).
    pub schema: u32,
    /// Version of the program.
    pub scanbench_version: String,
    /// When the comparison began, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The command line, the program's name first.
    pub argv: Vec<String>,
    /// The judged scans.
    pub left: ComparedScans,
    /// The scans that they are judged by.
    pub right: ComparedScans,
    /// The state of the source, where it is known.
    pub git: Option<GitState>,
    /// The compiler.
    pub rustc_version: String,
}

/// The scans of one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComparedScans {
    /// The data sets, whose scans are put together.
    pub datasets: Vec<DatasetEntry>,
    /// The seeds of the simulated ones, by their ids.
    pub seeds: BTreeMap<String, u64>,
}

impl ComparisonManifest {
    /// The content of `manifest.json`.
    pub fn to_json(&self) -> String {
        pretty_json(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::archive::{SCHEMA, read_json};

    #[test]
    fn a_manifest_reads_back_as_it_was() {
        let scans = |seed| ComparedScans {
            datasets: Vec::new(),
            seeds: BTreeMap::from([("street".to_owned(), seed)]),
        };
        let manifest = ComparisonManifest {
            schema: SCHEMA,
            scanbench_version: "0.1.0".to_owned(),
            created: "2026-03-02T09:30:00Z".to_owned(),
            argv: vec!["scanbench".to_owned(), "data".to_owned(), "realism".to_owned()],
            left: scans(1),
            right: scans(u64::MAX),
            git: None,
            rustc_version: "1.95.0".to_owned(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.json");
        std::fs::write(&path, manifest.to_json()).unwrap();
        assert_eq!(read_json::<ComparisonManifest>(&path).unwrap(), manifest);
    }
}
