//! What an object to train with shows.

use detector::OrientedBox;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

/// What a candidate is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateKind {
    /// A cluster that shows an annotated vehicle.
    Vehicle {
        /// What it is.
        class: AnnotationClass,
        /// The box around all of it, front forward.
        whole: Option<OrientedBox>,
        /// How much of it is hidden.
        occlusion: Option<Occlusion>,
    },
    /// A cluster that shows none.
    Cluster,
    /// A cluster of a part of a vehicle, of several, or of a vehicle and other things, that shows none of them well enough.
    Fragment,
    /// What lies in a rectangle put anywhere over the foreground.
    CutRegion,
}

impl CandidateKind {
    /// The name used in files and on screens.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vehicle { class, .. } => class.name(),
            Self::Cluster => "other cluster",
            Self::Fragment => "fragment",
            Self::CutRegion => "cut region",
        }
    }

    /// Whether it should be classified as a vehicle.
    pub fn is_vehicle(&self) -> bool {
        matches!(self, Self::Vehicle { .. })
    }
}
