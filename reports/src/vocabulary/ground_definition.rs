//! What others call ground where they judge programs that tell ground points from others.

use serde::{Deserialize, Serialize};

/// Which labels of SemanticKITTI are ground, and which points are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GroundDefinition {
    /// Low vegetation is ground, too; unlabelled points and outliers are left out. Lim et al. 2021.
    Patchwork,
    /// Vegetation is left out like unlabelled points and outliers. Steinke et al. 2024.
    #[serde(rename = "groundgrid")]
    GroundGrid,
    /// Vegetation and outliers are no ground; unlabelled points are left out. Reich et al. 2024, after TRAVEL, Oh et al. 2022.
    ContinuousClustering,
}

impl GroundDefinition {
    /// All definitions, in the order in which tables list them.
    pub const ALL: [Self; 3] = [Self::Patchwork, Self::GroundGrid, Self::ContinuousClustering];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Patchwork => "patchwork",
            Self::GroundGrid => "groundgrid",
            Self::ContinuousClustering => "continuous-clustering",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn definitions_are_read_by_the_names_they_are_written_with() {
        check_names(&GroundDefinition::ALL, GroundDefinition::name);
    }
}
