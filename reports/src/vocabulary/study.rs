//! Which verb a result is of.

use serde::{Deserialize, Serialize};

/// A verb that goes over scans or objects, most of which can be made in parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Study {
    /// Detectors on scans.
    Run,
    /// Detectors with one combination of values after the other on the same scans.
    Sweep,
    /// A method without each of its parts.
    Ablation,
    /// Detectors on simulated streets under one condition after the other.
    Robustness,
    /// Objects of which a part has been seen.
    Partial,
    /// Pairs of objects with growing gaps.
    Gaps,
    /// The methods of the papers and their rivals.
    Reproduce,
}

impl Study {
    /// All, in the order in which help lists them.
    pub const ALL: [Self; 7] = [
        Self::Run,
        Self::Sweep,
        Self::Ablation,
        Self::Robustness,
        Self::Partial,
        Self::Gaps,
        Self::Reproduce,
    ];

    /// The name of the verb, which is that in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Sweep => "sweep",
            Self::Ablation => "ablation",
            Self::Robustness => "robustness",
            Self::Partial => "partial",
            Self::Gaps => "gaps",
            Self::Reproduce => "reproduce",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn studies_are_read_by_the_names_they_are_written_with() {
        check_names(&Study::ALL, Study::name);
    }
}
