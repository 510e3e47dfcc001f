//! The entry of a sweep in a manifest: parameters and their values.

use serde::{Deserialize, Serialize};

/// What was swept, and how often it was timed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweepEntry {
    /// The swept parameters by their full names; the first is the axis of plots.
    pub swept: Vec<SweptParameter>,
    /// Full names of the parameters that go with a swept one.
    pub tied: Vec<String>,
    /// Of each combination of values, that of each swept parameter, and then of each tied one.
    pub points: Vec<Vec<String>>,
    /// The value of the first swept parameter where it is not swept.
    pub configured: Option<String>,
    /// Scans of each data set that were timed.
    pub n_timed_scans_per_data_set: u32,
    /// Timed detections of each of these at each point.
    pub n_timed_detections_per_scan_and_point: u32,
}

/// A swept parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweptParameter {
    /// Its full name.
    pub name: String,
    /// Its values.
    pub values: Vec<String>,
}

impl SweepEntry {
    /// Full names of the parameters that differ from point to point, in the order of the values of [`Self::points`].
    pub fn parameters(&self) -> Vec<String> {
        self.swept.iter().map(|it| it.name.clone()).chain(self.tied.iter().cloned()).collect()
    }
}
