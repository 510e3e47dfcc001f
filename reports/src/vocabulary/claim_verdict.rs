//! What comes of a claim of a paper.

use serde::{Deserialize, Serialize};

/// What comes of a claim; the later, the less is left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ClaimVerdict {
    /// It holds in good faith.
    Holds,
    /// It holds to the letter, by another criterion, or under some of the settings; not in good faith.
    HoldsUnderSomeReadings,
    /// It holds under none.
    DoesNotHold,
    /// These scans say nothing about it.
    CannotBeTestedHere,
}

impl ClaimVerdict {
    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::HoldsUnderSomeReadings => "holds under some readings",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTestedHere => "cannot be tested here",
        }
    }
}
