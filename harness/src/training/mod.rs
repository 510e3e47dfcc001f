//! From labelled scans to a trained vehicle model, and how good it is on streets it has not seen.

pub mod candidates;
pub mod held_out;
pub mod prototypes;
pub mod selection;
pub mod operating_curves;
pub mod evaluation;

/// The last of so many drives is held out.
pub const HOLD_OUT_EVERY: u32 = 4;
/// Side profiles of each kind of vehicle.
pub const PROTOTYPES: u32 = 2;
/// Seed of all that is drawn.
pub const CHOICE_SEED: u64 = 1;
/// Width of the Gaussian kernel, chosen by held-out simulated drives; the paper's 0.1078 does a little worse there.
pub const GAMMA: f32 = 0.5;
/// Bound of the share of objects inside the margin, chosen likewise; at the paper's 0.0377 there is none between objects as
/// mixed as these.
pub const NU: f64 = 0.2;
