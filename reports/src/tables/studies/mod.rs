//! Tables of the findings of studies, for people and as CSV.

pub mod ablation_score;
pub mod ablation_table;
pub mod sweep_table;
pub mod sweep_rates;
pub mod sweep_recommendation;
pub mod swept_protocol_table;
pub mod fitness_table;
pub mod gap_table;
pub mod box_error_row;
pub mod box_table;
pub mod robustness_table;
pub mod streaming_table;
pub mod curve_row;
pub mod agreement;
pub mod partial_findings;
pub mod partial_table;
pub mod claims_table;
pub mod open_values_table;
pub mod rate_table;
pub mod step_table;
pub mod background_table;
