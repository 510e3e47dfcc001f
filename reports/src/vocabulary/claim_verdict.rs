//! Verdicts on claims of the papers.

use serde::{Deserialize, Serialize};

/// What comes of a claim; the later, the less is left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ClaimVerdict {
    /// It holds in good faith.
    Holds,
    /// It holds under a reading that the text leaves open: to the letter, with printed ν and γ, by another criterion, or under some of the
    /// settings; not in good faith.
    #[serde(alias = "holds_under_some_readings")]
    HoldsWithReadings,
    /// It holds only with steps that are not in the text.
    HoldsWithSteps,
    /// It holds if the rival gets less than the method.
    HoldsIfRivalDenied,
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
            Self::HoldsWithReadings => "holds with readings that the text leaves open",
            Self::HoldsWithSteps => "holds only with steps that are not in the text",
            Self::HoldsIfRivalDenied => "holds if the rival is denied something",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTestedHere => "cannot be tested here",
        }
    }
}
