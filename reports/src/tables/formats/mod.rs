//! Formats that tables, verdicts and reports are written in: one trait, a file for each format or kind of them, and one list
//! of each kind.

pub mod format;
pub mod terminal;
pub mod csv;
pub mod markdown;
pub mod latex;
pub mod json;
pub mod junit;
pub mod services;
pub mod lists;
