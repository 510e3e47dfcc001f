//! Reproduction of the claims of the papers: readings of their text, and the values that they leave open.

pub mod open_values;
pub mod settings;
pub mod coordinate_search;
pub mod observed_scans;
