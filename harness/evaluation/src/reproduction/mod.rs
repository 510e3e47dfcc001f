//! What the claims of the papers rest on: readings of what they print, and the values that they leave open.

pub mod open_values;
pub mod settings;
pub mod coordinate_search;
pub mod observed_scans;
