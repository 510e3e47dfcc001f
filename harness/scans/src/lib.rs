//! Labelled scans: annotations, data sets of every format, results of other programs on them, conversion between formats,
//! and checks of the data.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.
//!
//! The types of errors list all that can go wrong: [`dataset::DatasetError`] and [`conversion::error::ConversionError`]. An
//! error that is a `String` says what is wrong as the rest of a sentence about the file.

#![expect(clippy::missing_errors_doc, reason = "the types of errors say it once for all functions")]

pub mod annotation;
pub mod dataset;
pub mod object_cloud;
pub mod foreign;
pub mod conversion;
pub mod data_check;
