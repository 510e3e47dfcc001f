//! The record of a shard in a manifest: its scans, and the files that it left.

use serde::{Deserialize, Serialize};

use crate::vocabulary::shard::{Shard, ShardError};
use crate::vocabulary::study::Study;

/// A part of a run or of a study that was made by itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShardRecord {
    /// Which one, from 1.
    pub index: u32,
    /// How many there are.
    pub count: u32,
    /// When it was begun, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The verb that it is a part of.
    pub study: Study,
    /// SHA-256 of the program.
    pub program: String,
    /// By what the work was shared out.
    pub cut_by: WorkMeasure,
    /// Its scans, in the order of the data sets of the run; of `partial` its objects.
    pub parts: Vec<ShardPart>,
    /// Where it ran: the processors in the order of its rows, more than one if it was continued elsewhere.
    pub processors: Vec<ProcessorRows>,
    /// Its log, of which everything is made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<ShardFile>,
    /// Its recordings, in the order of their scans.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<ShardRecording>,
}

/// By what the work of scans is measured before they are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum WorkMeasure {
    /// The sizes of their files, which go with the number of points.
    FileSizes,
    /// Each scan is as much as any other.
    Scans,
    /// Each object is as much as any other.
    Objects,
}

/// What a shard has of a data set, or of a set of objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShardPart {
    /// Its first scan, as an index among those that were selected, from 0.
    pub first: u64,
    /// The index behind its last one.
    pub end: u64,
    /// SHA-256 of the names and times of all scans that were selected; of objects, of their names and classes.
    pub selected: String,
    /// Annotations of any kind in its scans.
    pub n_labels: u64,
    /// Scans whose labels say something, if only that nothing stands there.
    #[serde(default)]
    pub n_labeled_scans: u64,
}

/// How many rows of `scans.csv` were made on a processor; of a sweep, how many scans were timed on it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ProcessorRows {
    /// The processor's own name.
    pub cpu_model: String,
    /// Rows.
    pub n_scan_rows: u64,
}

/// A file of a shard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShardFile {
    /// Its name.
    pub name: String,
    /// Its size in bytes.
    pub n_bytes: u64,
    /// SHA-256 of its content.
    pub sha256: String,
}

/// A recording of some scans of a shard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShardRecording {
    /// The name of its folder.
    pub file: String,
    /// The first scan that may be in it, counted from 0 over all scans of the run.
    pub first: u64,
    /// The number behind the last one.
    pub end: u64,
    /// Every so many scans are in it: those whose number this divides.
    pub every: u64,
}

impl ShardRecording {
    /// Whether the scan of this number is in it.
    pub fn holds(&self, number: u64) -> bool {
        (self.first..self.end).contains(&number) && number.is_multiple_of(self.every)
    }
}

impl ShardRecord {
    /// The shard that it records.
    ///
    /// # Errors
    ///
    /// [`ShardError`] if there is none like it.
    pub fn shard(&self) -> Result<Shard, ShardError> {
        Shard::new(self.index, self.count)
    }

    /// Number of its scans, or of its objects.
    pub fn n_scans(&self) -> u64 {
        self.parts.iter().map(|it| it.end.saturating_sub(it.first)).sum()
    }
}

/// The different processors of `shards`, in order.
pub fn processors_of<'a>(shards: impl IntoIterator<Item = &'a ShardRecord>) -> Vec<&'a str> {
    let mut models: Vec<&str> = Vec::new();
    for model in shards.into_iter().flat_map(|it| &it.processors).map(|it| it.cpu_model.as_str()) {
        if !models.contains(&model) {
            models.push(model);
        }
    }
    models
}
