//! Errors of a configuration.

use std::fmt;
use std::path::PathBuf;

/// Why a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The operating system refused.
    #[error("cannot read the configuration {path:?}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Its error.
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
    /// The text is not TOML.
    #[error("{position}: {problem}")]
    Syntax {
        /// Position of the error.
        position: ConfigPosition,
        /// Description of the error.
        problem: String,
    },
    /// A parameter that does not exist.
    #[error("{position}: unknown parameter {key}; {remedy}")]
    Unknown {
        /// Position of the error.
        position: ConfigPosition,
        /// The parameter, in a file with its tables.
        key: String,
        /// The parameters of its table, or those that may be meant.
        remedy: String,
    },
    /// A short name that several parameters have.
    #[error("{position}: {name} is ambiguous; write one of {}", meanings.join(", "))]
    Ambiguous {
        /// Position of the error.
        position: ConfigPosition,
        /// The name.
        name: String,
        /// The full names of the parameters.
        meanings: Vec<String>,
    },
    /// A parameter that was given two values on the command line.
    #[error("{position}: {key} is set twice")]
    Twice {
        /// Position of the second value.
        position: ConfigPosition,
        /// The full name of the parameter.
        key: String,
    },
    /// A parameter of the wrong type.
    #[error("{position}: {key} is of type {found}, but must be {expected}")]
    WrongType {
        /// Position of the error.
        position: ConfigPosition,
        /// The parameter with its tables.
        key: String,
        /// The type of its value.
        found: &'static str,
        /// The type it should have.
        expected: &'static str,
    },
    /// A value that cannot be used.
    #[error("{position}: {key}{problem}")]
    Value {
        /// Position of the error.
        position: ConfigPosition,
        /// The parameter with its tables.
        key: String,
        /// The problem, as a continuation of the name.
        problem: String,
    },
}

/// Where a parameter was given a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ConfigPosition {
    /// In a file.
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// On the command line, as these `NAME=VALUE`.
    Options(Vec<String>),
}

impl fmt::Display for ConfigPosition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { path, line } => {
                fmt::Debug::fmt(path, formatter)?;
                write!(formatter, ", line {line}")
            }
            Self::Options(written) => {
                let options: Vec<String> = written.iter().map(|it| format!("-P {it}")).collect();
                formatter.write_str(&options.join(" "))
            }
        }
    }
}
