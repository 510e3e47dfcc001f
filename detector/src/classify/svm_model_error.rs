//! What can be wrong with a trained classifier.

use crate::describe::trained_file::TrainedFileError;

/// Why a model cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SvmModelError {
    /// Not TOML, or not a model.
    #[error(transparent)]
    File(#[from] TrainedFileError),
    /// A model for other values.
    #[error("the model was trained on the features {found:?}, but needs {expected:?}")]
    Features {
        /// What it says.
        found: Vec<String>,
        /// What it is wanted for.
        expected: Vec<&'static str>,
    },
    /// A model for values that were taken in another way.
    #[error(
        "the features of the model were computed with {found}, but this program computes them with {expected}"
    )]
    Describer {
        /// What it says.
        found: String,
        /// What it is wanted for.
        expected: String,
    },
    /// A list that is too short or too long.
    #[error("{list} holds {found} values instead of {expected}")]
    Length {
        /// Which list.
        list: String,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Something else where a line of one of the long lists belongs.
    #[error("expected {expected}, found {found:?}")]
    Layout {
        /// What belongs there.
        expected: &'static str,
        /// The beginning of the line.
        found: String,
    },
    /// An entry of a list that is none.
    #[error("{text:?} in {list} is not a number")]
    NoNumber {
        /// Which list.
        list: String,
        /// The entry.
        text: String,
    },
    /// A value that no training gives.
    #[error("{name} = {value} is not within {allowed}")]
    OutOfRange {
        /// Which value.
        name: String,
        /// The value.
        value: f64,
        /// What is possible.
        allowed: &'static str,
    },
}
