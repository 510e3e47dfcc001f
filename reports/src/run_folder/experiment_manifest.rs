//! `manifest.json` of an experiment on simulated scans: how it came about, so that it can be made again.

use serde::{Deserialize, Serialize};

use crate::run_folder::manifest::GitState;

/// Everything that decides the numbers of an experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExperimentManifest {
    /// Layout of the files beside it, [`SCHEMA`](crate::files::archive::SCHEMA).
    pub schema: u32,
    /// Version of the rules by which the detections were judged.
    pub scoring_version: u32,
    /// Version of the program.
    pub scanbench_version: String,
    /// When the experiment began, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The command line, the program's name first.
    pub argv: Vec<String>,
    /// Always `true`: the scans are simulated.
    pub simulated: bool,
    /// Bumped whenever the simulator gives other scans.
    pub simulator_version: u32,
    /// The seed of everything that was drawn.
    pub seed: u64,
    /// The detectors, in the order of the tables.
    pub detectors: Vec<String>,
    /// The configuration after files, defaults and command line were put together.
    pub config: serde_json::Value,
    /// What was put up, as the experiment itself describes it.
    pub experiment: serde_json::Value,
    /// The state of the source, where it is known.
    pub git: Option<GitState>,
    /// The compiler.
    pub rustc_version: String,
}

impl ExperimentManifest {
    /// The content of `manifest.json`.
    pub fn to_json(&self) -> String {
        let mut json = serde_json::to_string_pretty(self).expect("a manifest has text keys only");
        json.push('\n');
        json
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::archive::{SCHEMA, read_json};

    #[test]
    fn a_manifest_reads_back_as_it_was() {
        let manifest = ExperimentManifest {
            schema: SCHEMA,
            scoring_version: 1,
            scanbench_version: "0.1.0".to_owned(),
            created: "2026-01-02T03:04:05Z".to_owned(),
            argv: vec!["scanbench".to_owned(), "gaps".to_owned()],
            simulated: true,
            simulator_version: 1,
            seed: 7,
            detectors: vec!["kd-tree".to_owned()],
            config: serde_json::json!({ "matching": { "min_iou": 0.5 } }),
            experiment: serde_json::json!({ "n_pairs": 3 }),
            git: None,
            rustc_version: "rustc 1.95.0".to_owned(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.json");
        std::fs::write(&path, manifest.to_json()).unwrap();
        assert_eq!(read_json::<ExperimentManifest>(&path).unwrap(), manifest);
    }
}
