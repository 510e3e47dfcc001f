//! From labelled scans to a trained vehicle model, and how good it is on streets it has not seen.

pub mod candidates;
pub mod held_out;
pub mod prototypes;
pub mod selection;
pub mod operating_curves;
pub mod evaluation;

/// Width of the Gaussian kernel.
///
/// Paper: VM section 6.
pub const PAPER_GAMMA: f32 = 0.1078;
/// Bound of the share of objects inside the margin.
///
/// Paper: VM section 6.
pub const PAPER_NU: f64 = 0.0377;
