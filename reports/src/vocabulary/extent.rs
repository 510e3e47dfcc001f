//! How much a number covers: one data set or all of them.

/// What stands for a data set in numbers about all of them together.
pub const OVERALL: &str = "overall";

/// How much a row covers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// The data set of this id.
    Dataset(String),
    /// All data sets: counts and times summed, then the ratio.
    Overall,
}

impl Extent {
    /// The name used in files and on screens.
    pub fn name(&self) -> &str {
        match self {
            Self::Dataset(id) => id,
            Self::Overall => OVERALL,
        }
    }
}
