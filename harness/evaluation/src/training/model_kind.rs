//! Whose vehicle model is trained, and with which parameters unless others are asked for.

use crate::object_box::ObjectBox;

/// A detector with a vehicle model of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelKind {
    /// By the shape of its clusters (VM sections 4 and 5).
    Hierarchical,
    /// By how points lie in their neighbourhoods (VM section 6, the rival).
    Pca,
}

impl ModelKind {
    /// The detector.
    pub fn detector(self) -> &'static str {
        match self {
            Self::Hierarchical => "hierarchical",
            Self::Pca => "pca",
        }
    }

    /// The box that it puts around its clusters.
    pub fn object_box(self) -> ObjectBox {
        match self {
            Self::Hierarchical => ObjectBox::ConvexHull,
            Self::Pca => ObjectBox::PrincipalAxes,
        }
    }

    /// Width of the Gaussian kernel, chosen by held-out simulated drives.
    pub fn gamma(self) -> f32 {
        match self {
            Self::Hierarchical => 0.054,
            Self::Pca => 0.1078,
        }
    }

    /// Bound of the share of objects inside the margin, chosen likewise; at the paper's 0.0377 there is none between objects
    /// as mixed as these.
    pub fn nu(self) -> f64 {
        match self {
            Self::Hierarchical => 0.12,
            Self::Pca => 0.2,
        }
    }
}
