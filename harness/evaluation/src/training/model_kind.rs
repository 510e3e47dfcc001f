//! Kinds of vehicle models, and the default parameters of their training.

use detector::classify::nu_svc_solver::Tolerance;

use crate::object_box::ObjectBox;

/// A vehicle model that is a support vector machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelKind {
    /// With the eight values of the paper (VM section 5).
    Paper,
    /// With the shapes of the neighbourhoods of points (VM section 6, the rival).
    Pca,
}

impl ModelKind {
    /// The detector that it is trained for, whose clusters are the examples.
    pub fn detector(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Pca => "pca",
        }
    }

    /// The box that it puts around its clusters.
    pub fn object_box(self) -> ObjectBox {
        match self {
            Self::Paper => ObjectBox::ConvexHull,
            Self::Pca => ObjectBox::PrincipalAxes,
        }
    }

    /// Width of the Gaussian kernel, as printed.
    pub fn gamma(self) -> f32 {
        0.1078
    }

    /// Bound of the share of objects inside the margin: as printed, or chosen by held-out simulated drives. At the paper's
    /// 0.0377 there is next to no margin between objects as mixed as these.
    pub fn nu(self) -> f64 {
        match self {
            Self::Paper => 0.0377,
            Self::Pca => 0.2,
        }
    }

    /// Tolerance at which training stops: decision values are then close to their final ones. At the paper's ν it cannot
    /// be reached, so its model is trained to the default of the paper's library (VM section 5, reference 15).
    pub fn tolerance(self) -> Tolerance {
        match self {
            Self::Pca => Tolerance::OfMargin(0.1),
            Self::Paper => Tolerance::OfGradients(0.001),
        }
    }
}
