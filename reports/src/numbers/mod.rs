//! Numbers made of rows: sums and ratios of runs, and those of each study.

// Of a run.
pub mod blocks;
pub mod shard_cut;
pub mod sums;
pub(crate) mod block_sums;
pub mod latencies;
pub(crate) mod times;
pub mod average_precision;
pub mod calibration;
pub mod precision_recall_row;
pub mod pools;
pub(crate) mod gathered;
pub mod confusion;
pub mod tally;
pub(crate) mod number_record;
pub mod run_report;
pub mod processor_time_row;

// Of a study.
pub mod operating_curve;
pub mod rank_correlation;
pub mod curve_pair;
pub mod gap_curve;
pub mod box_errors;
pub mod box_points;
pub mod sweep_score;
pub mod sweep_curve;
