//! Labelled scans: what is annotated, data sets of every format, results of other programs on them, conversion between
//! formats, and what can be wrong with them.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.
//!
//! What can go wrong is said by the types of errors, [`dataset::DatasetError`] and [`conversion::error::ConversionError`].
//! An error that is a `String` says what is wrong as the rest of a sentence about the file.

#![expect(clippy::missing_errors_doc, reason = "the types of errors say it once for all functions")]

pub mod annotation;
pub mod dataset;
pub mod object_cloud;
pub mod foreign;
pub mod conversion;
pub mod data_check;
