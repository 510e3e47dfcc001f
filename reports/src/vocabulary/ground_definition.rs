//! Definitions of ground by which others judge programs that distinguish ground points from others.

use crate::vocabulary::named::named;

named! {
    /// Which labels of SemanticKITTI are ground, and which points are left out.
    pub enum GroundDefinition {
        /// Low vegetation is ground, too; unlabelled points and outliers are left out. Lim et al. 2021.
        Patchwork = "patchwork",
        /// Vegetation is left out like unlabelled points and outliers. Steinke et al. 2024.
        GroundGrid = "groundgrid",
        /// Vegetation and outliers are no ground; unlabelled points are left out. Reich et al. 2024, after TRAVEL, Oh et al.
        /// 2022.
        ContinuousClustering = "continuous-clustering",
    }
}
