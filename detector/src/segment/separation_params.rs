//! How dense cells are separated.

use serde::Deserialize;

/// Tuning of [`DenseSeparation::separate`](super::dense_separation::DenseSeparation::separate).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenseSeparationParams {
    /// Whether blobs are cut at all; otherwise each stays one object, as a grid without dense cells leaves it.
    pub enabled: bool,
    /// A dense cell with less than this share of the points it could be expected to hold is near-empty.
    pub low_density_share: f32,
    /// What upright objects hold, as a multiple of what all points together put into a dense cell at their range.
    pub object_density_ratio: f32,
    /// Where all points together put this many into a dense cell, a single empty dense cell separates.
    pub single_gap_points: f32,
}
