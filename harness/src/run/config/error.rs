//! What can be wrong with a configuration.

use std::path::PathBuf;

/// Why a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The operating system refused.
    #[error("cannot read the configuration {path:?}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// The file is not text.
    #[error("{path:?} is not text: invalid UTF-8 at byte {byte_offset}")]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first bad byte, counted from 0.
        byte_offset: usize,
    },
    /// The file is not TOML.
    #[error("{path:?}, line {line}: {problem}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// A parameter that nothing reads.
    #[error("{path:?}, line {line}: unknown parameter {key}; there are {known}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// The parameters there are in its table.
        known: String,
    },
    /// A parameter of the wrong type.
    #[error("{path:?}, line {line}: {key} is of type {found}, expected {expected}")]
    WrongType {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// The type of its value.
        found: &'static str,
        /// The type it should have.
        expected: &'static str,
    },
    /// A value that cannot be worked with.
    #[error("{path:?}, line {line}: {key}{problem}")]
    Value {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// What is wrong with it, as a continuation.
        problem: String,
    },
}
