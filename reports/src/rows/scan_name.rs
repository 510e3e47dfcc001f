//! Names of scans among those of a run.

use serde::{Deserialize, Serialize};

use crate::files::shown_text::printable_name;

/// A scan. Sorted by the names of data sets and drives, so that nothing depends on the order in which scans were seen.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ScanName {
    /// Id of the data set.
    #[serde(deserialize_with = "printable_name")]
    pub dataset: String,
    /// The drive the scan belongs to.
    #[serde(deserialize_with = "printable_name")]
    pub sequence: String,
    /// Number of the scan within the drive.
    pub scan: u32,
}
