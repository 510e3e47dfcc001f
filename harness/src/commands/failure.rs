//! How the program ends when something is wrong.

use reports::run_directory::RunDirectoryError;

use crate::dataset::DatasetError;
use crate::run::config::ConfigError;
use crate::run::detector_list::DetectorListError;
use crate::run::side_by_side::RunError;

/// Expected endings, with their documented exit codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Failure {
    /// A bug, or a machine that gave up, such as a full disk.
    Internal = 1,
    /// Wrong usage or configuration.
    Usage = 2,
    /// Data missing or damaged.
    Data = 3,
    /// Nothing was evaluated.
    NothingEvaluated = 4,
    /// Ended by the user; what shells report for Ctrl-C.
    Interrupted = 130,
}

/// There was nothing to evaluate.
#[derive(Debug, thiserror::Error)]
#[error("nothing was evaluated: {reason}")]
pub struct NothingEvaluated {
    /// Why.
    pub reason: String,
}

/// What was asked for makes no sense.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

impl Failure {
    /// What kind of ending `error` is.
    pub fn of(error: &anyhow::Error) -> Self {
        let of_dataset = |error: &DatasetError| if error.is_usage_error() { Self::Usage } else { Self::Data };
        if let Some(error) = error.downcast_ref::<DatasetError>() {
            return of_dataset(error);
        }
        match error.downcast_ref::<RunError>() {
            Some(RunError::Dataset(error)) => return of_dataset(error),
            Some(RunError::Interrupted { .. }) => return Self::Interrupted,
            None => {}
        }
        if error.is::<NothingEvaluated>() {
            return Self::NothingEvaluated;
        }
        if error.is::<ConfigError>()
            || error.is::<DetectorListError>()
            || error.is::<Usage>()
            || error.is::<RunDirectoryError>()
            || is_stream_usage(error)
        {
            return Self::Usage;
        }
        Self::Internal
    }
}

#[cfg(feature = "rerun")]
fn is_stream_usage(error: &anyhow::Error) -> bool {
    use crate::stream::StreamError;
    matches!(
        error.downcast_ref::<StreamError>(),
        Some(
            StreamError::BadUrl { .. }
                | StreamError::Create { .. }
                | StreamError::ViewerNotInstalled { .. }
                | StreamError::ViewerFailed { .. }
        )
    )
}

#[cfg(not(feature = "rerun"))]
fn is_stream_usage(_: &anyhow::Error) -> bool {
    false
}
