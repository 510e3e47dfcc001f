//! Kinds of training candidates.

use detector::OrientedBox;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

/// Kind of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateKind {
    /// A cluster that shows an annotated vehicle.
    Vehicle {
        /// Class of the vehicle.
        class: AnnotationClass,
        /// The box around all of it, front forward.
        whole: Option<OrientedBox>,
        /// How much of it is hidden, if the labels say so.
        occlusion: Option<Occlusion>,
    },
    /// A cluster that shows no vehicle.
    Cluster,
    /// A cluster of a part of a vehicle, of several vehicles, or of a vehicle and other things, that shows no vehicle well
    /// enough.
    Fragment,
    /// Points in a rectangle put anywhere over the foreground.
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
