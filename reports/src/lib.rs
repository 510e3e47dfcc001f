//! What a run is on disk: numbers, their tables, and the folder they are kept in.
//!
//! This crate knows numbers, never points: it depends on no detector and on no data set.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

pub mod palette;

// Numbers.
pub mod blocks;
pub mod counts;
pub mod metric;
pub mod curve_pair;
pub mod wilson_interval;
pub mod rank_correlation;
pub mod average_precision;
pub mod latencies;
pub mod gap_curve;
pub mod box_errors;
pub mod condition_scores;
mod fixed_decimals;

// Files.
pub mod archive;
pub mod unfinished;
pub mod whole_file;
pub mod claimed_name;
pub mod new_folders;
pub mod csv_rows;
pub mod run_report;
pub mod manifest;
pub mod comparison_manifest;
pub mod scan_row;
pub mod stage_row;
pub mod match_outcome;
pub mod match_row;
pub mod worst;
pub mod curve_row;
pub mod box_row;
pub mod cluster_of_point;
pub mod gap_row;
pub mod box_error_row;
pub mod condition_row;
pub mod precision_recall_row;
pub mod operating_curve;
pub mod training_row;
mod run_target;
mod folder_in_place;
pub mod run_directory;

// From rows to numbers.
pub mod slice;
pub mod sums;
pub mod bootstrap;
mod times;
pub mod tally;
pub mod estimates;
mod time_estimates;
pub mod run_archive;
pub mod worst_places;
pub mod worst_points;

// Tables.
pub mod paper_figures;
pub mod table;

// Verdicts.
pub mod gate;

// Who leads.
pub mod standing;

// Pictures.
pub mod plot;

// Pages.
pub mod html;
