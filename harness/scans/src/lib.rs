//! Labelled scans: what is annotated, data sets of every format, results of other programs on them, conversion between formats, and what can be wrong
//! with them.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

pub mod annotation;
pub mod dataset;
pub mod object_cloud;
pub mod foreign;
pub mod conversion;
pub mod data_check;
