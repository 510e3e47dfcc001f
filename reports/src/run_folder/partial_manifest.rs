//! `manifest.json` of a result of `scanbench partial`: how it came about.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::archive::{ArchiveError, pretty_json, read_json};
use crate::run_folder::manifest::GitState;
use crate::run_folder::shard_record::ShardRecord;

/// How partly seen objects were classified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialManifest {
    /// Layout of the files, [`SCHEMA`](crate::files::archive::SCHEMA).
    pub schema: u32,
    /// Version of the program.
    pub scanbench_version: String,
    /// When it began, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The command line, the program's name first.
    pub argv: Vec<String>,
    /// The objects, in the order of the tables.
    pub sets: Vec<PartialSet>,
    /// Methods whose results are those of another program, with the SHA-256 of their files.
    pub peers: BTreeMap<String, String>,
    /// The state of the source, where it is known.
    pub git: Option<GitState>,
    /// The compiler.
    pub rustc_version: String,
    /// What else was asked for; `None` of results of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<PartialSettings>,
    /// Which part of a result it is; `None` of a whole one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardRecord>,
    /// The parts that it was put together of; none of a result in one piece.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shards: Vec<ShardRecord>,
}

/// What was asked for beside objects and models.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialSettings {
    /// Whether objects that are none of the four are judged, too.
    pub others: bool,
    /// Whether objects are shown as a drive does, and not step by step.
    pub drives: bool,
    /// Whether the method is compared with itself without each part, instead of with rivals.
    pub ablation: bool,
    /// What methods learned from, in turn.
    pub trained_on: Vec<String>,
}

/// Objects that were judged, and what methods have learned from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialSet {
    /// The objects.
    pub judged: ObjectSetEntry,
    /// Objects that were learned from; none if a model was taken.
    pub learned_from: Option<ObjectSetEntry>,
    /// Whether both are the same recorded objects: half of them learned from, and the others judged.
    pub halves: bool,
    /// The model that was taken.
    pub model: Option<ModelEntry>,
}

/// A set of objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSetEntry {
    /// The name used in tables.
    pub id: String,
    /// Whether a simulator made them.
    pub simulated: bool,
    /// What the simulator was asked for.
    pub simulation: Option<serde_json::Value>,
    /// How many there are of each class.
    pub objects: BTreeMap<String, usize>,
}

/// A model that had learned before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelEntry {
    /// `shipped`, or the file that was named.
    pub name: String,
    /// The command that made it.
    pub made_by: String,
    /// What it was made of.
    pub data: Vec<String>,
}

impl ObjectSetEntry {
    fn named(&self) -> String {
        let simulated = if self.simulated { " (simulated)" } else { "" };
        format!("{}{simulated}", self.id)
    }
}

impl PartialManifest {
    /// Reads `path`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if it cannot be read, or is of another version or damaged.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        read_json(path)
    }

    /// The file.
    pub fn to_json(&self) -> String {
        pretty_json(self)
    }

    /// What was done, in words.
    pub fn title(&self) -> String {
        let of_set = |it: &PartialSet| {
            let judged = it.judged.named();
            let half = if it.halves { ", the other half of it" } else { "" };
            match (&it.learned_from, &it.model) {
                (Some(learned_from), _) => format!("{judged}, learned from {}{half}", learned_from.named()),
                (None, Some(model)) if model.name == SHIPPED => {
                    format!("{judged}, classified by the shipped model")
                }
                (None, Some(model)) => format!("{judged}, classified by the model {}", model.name),
                (None, None) => judged,
            }
        };
        format!("Partial clouds: {}.", self.sets.iter().map(of_set).collect::<Vec<_>>().join("; "))
    }
}

/// The name of the model that comes with the program.
pub const SHIPPED: &str = "shipped";

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::files::archive::SCHEMA;

    /// Of the rows that tests have, classified by the shipped model.
    pub(crate) fn manifest() -> PartialManifest {
        let judged = ObjectSetEntry {
            id: "street".to_owned(),
            simulated: true,
            simulation: None,
            objects: [("tree".to_owned(), 2), ("pole".to_owned(), 1)].into_iter().collect(),
        };
        let model = ModelEntry { name: SHIPPED.to_owned(), made_by: "train".to_owned(), data: Vec::new() };
        PartialManifest {
            schema: SCHEMA,
            scanbench_version: "0.1.0".to_owned(),
            created: "2026-01-01T00:00:00Z".to_owned(),
            argv: ["scanbench", "partial", "it's <here>"].map(str::to_owned).to_vec(),
            sets: vec![PartialSet { judged, learned_from: None, halves: false, model: Some(model) }],
            peers: BTreeMap::new(),
            git: None,
            rustc_version: "rustc".to_owned(),
            settings: None,
            shard: None,
            shards: Vec::new(),
        }
    }

    #[test]
    fn a_manifest_is_read_back_and_titles_say_what_is_simulated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.json");
        let mut manifest = manifest();
        std::fs::write(&path, manifest.to_json()).unwrap();
        assert_eq!(PartialManifest::read(&path).unwrap(), manifest);
        assert_eq!(manifest.title(), "Partial clouds: street (simulated), classified by the shipped model.");
        let set = &mut manifest.sets[0];
        set.learned_from = Some(ObjectSetEntry { simulated: false, ..set.judged.clone() });
        (set.halves, set.model) = (true, None);
        let title = "Partial clouds: street (simulated), learned from street, the other half of it.";
        assert_eq!(manifest.title(), title);
    }
}
