//! How objects are regrouped.

use serde::Deserialize;

/// Tuning of [`Regrouping`](super::regrouping::Regrouping).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegroupingParams {
    /// Whether objects are regrouped at all.
    pub enabled: bool,
    /// Objects as long as this are cut across, in metres: longer than a car.
    pub min_length_m: f32,
    /// Objects as wide as this are cut along, in metres: wider than a van.
    pub min_width_m: f32,
    /// Cuts are at least this far from both ends, in metres.
    pub min_end_m: f32,
    /// How many places are tried along each axis, those with the fewest points first.
    pub n_places: usize,
    /// A part has at least this many points.
    pub min_points: usize,
    /// By how much more the model has to like one part than the whole if it does not like the other.
    pub lone_part_margin: f32,
    /// Objects no farther apart than this may be joined, in metres.
    pub max_gap_m: f32,
    /// Longer objects are not joined with others, in metres.
    pub max_joined_length_m: f32,
}
