//! Training of models on labelled scans, and their quality on held-out streets.

pub mod model_kind;
pub mod candidate_kind;
pub mod vehicle_labels;
pub mod candidates;
pub mod held_out;
pub mod prototypes;
pub mod selection;
pub mod described_object;
pub mod operating_curves;
pub mod evaluation;
pub mod example_weights;
pub mod group_examples;
pub mod model_odds;
pub mod boosting;
pub mod refinement_training;
pub mod grouping_training;
pub mod cluster_training;
pub mod box_training;

/// The last of every so many drives is held out.
pub const HOLD_OUT_EVERY: u32 = 4;
/// Number of other training objects for each vehicle.
pub const OTHERS_PER_VEHICLE: f64 = 1.5;
/// Number of side profiles of each kind of vehicle.
pub const PROTOTYPES: u32 = 2;
/// Seed of all random choices.
pub const CHOICE_SEED: u64 = 1;
