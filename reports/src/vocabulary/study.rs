//! The verbs that make results.

use crate::vocabulary::named::named;

named! {
    /// A verb that goes over scans or objects, most of which can be made in parts.
    pub enum Study {
        /// Detectors on scans.
        Run = "run",
        /// Detectors with one combination of values after the other on the same scans.
        Sweep = "sweep",
        /// A method without each of its parts.
        Ablation = "ablation",
        /// Detectors on simulated streets under one condition after the other.
        Robustness = "robustness",
        /// Objects of which a part has been seen.
        Partial = "partial",
        /// Pairs of objects with growing gaps.
        Gaps = "gaps",
        /// The methods of the papers and their rivals.
        Reproduce = "reproduce",
    }
}

impl Study {
    /// Whether its directory is called after the data sets, unless it is named: not that of a verb that makes its own data.
    pub fn is_called_after_data(self) -> bool {
        !matches!(self, Self::Robustness | Self::Partial | Self::Gaps)
    }
}
