//! What a run is on disk: numbers, their tables, and the folder they are kept in.
//!
//! This crate knows numbers, never points: it depends on no detector and on no data set.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

// What everything here is about, and how files are written.
pub mod vocabulary;
pub mod files;

// From what was seen to what it means.
pub mod rows;
pub mod worst;
pub mod numbers;
pub mod uncertainty;
pub mod streaming;
pub mod protocols;
pub mod partial_study;
pub mod run_folder;
pub mod verdicts;
pub mod history;
pub mod reproduction;

// How it is shown.
pub mod tables;
pub mod plots;
pub mod facts;
pub mod pages;

// What programs of others may rely on.
#[cfg(feature = "schemas")]
pub mod schemas;
#[cfg(feature = "schemas")]
pub use schemars;
