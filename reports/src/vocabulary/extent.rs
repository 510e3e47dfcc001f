//! Extent of a number: one data set or several together.

use crate::vocabulary::origin::Origin;

/// Stands for a data set in numbers about all data sets together.
pub const OVERALL: &str = "overall";

/// The extent of a row. Recorded and simulated data sets are never put together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// The data set of this id.
    Dataset(String),
    /// All data sets, which are of one origin: counts and times summed, then the ratio.
    Overall,
    /// All data sets of this origin, summed likewise, where there are others.
    OverallOf(Origin),
}

impl Extent {
    /// The name used in files and on screens.
    pub fn name(&self) -> &str {
        match self {
            Self::Dataset(id) => id,
            Self::Overall => OVERALL,
            Self::OverallOf(Origin::Recorded) => "overall-recorded",
            Self::OverallOf(Origin::Simulated | Origin::PartlySimulated) => "overall-simulated",
        }
    }

    /// Whether `name` is that of several data sets together.
    pub fn is_name_of_several(name: &str) -> bool {
        let of_origins = [Origin::Recorded, Origin::Simulated].map(Self::OverallOf);
        name == OVERALL || of_origins.iter().any(|it| it.name() == name)
    }

    /// Whether it is about several data sets together.
    pub fn is_overall(&self) -> bool {
        !matches!(self, Self::Dataset(_))
    }
}
