//! How the program ends when something is wrong.

use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use reports::files::archive::ArchiveError;
use reports::run_folder::run_target::RunDirectoryError;
use reports::verdicts::accept::AcceptError;
use reports::verdicts::comparability::NotComparable;
use reports::verdicts::tolerances::TolerancesError;
use reports::verdicts::verdict::{Conclusion, JudgeError};

use crate::commands::interruption::interruption_exit_code;
use crate::commands::standard_streams::print_error;
use crate::conversion::ConversionError;
use crate::dataset::DatasetError;
use crate::realism::survey::SurveyError;
use crate::run::config::ConfigError;
use crate::run::detector_list::DetectorListError;
use crate::run::side_by_side::RunError;
use crate::run::single_scan;
use crate::sweep::journal::JournalError;
use crate::sweep::quality_pass::SweepError;
use crate::sweep::sweep_plan::SweepPlanError;

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
    /// Two runs that cannot be compared.
    NotComparable = 5,
    /// Surely worse than the baseline.
    Regression = 100,
    /// Not surely worse, but judged otherwise than the baseline.
    Drift = 101,
    /// Ended by the user; what shells report for Ctrl-C. After a request to terminate it is 143.
    Interrupted = 130,
}

/// There was nothing to evaluate.
#[derive(Debug, thiserror::Error)]
#[error("nothing was evaluated: {reason}")]
pub struct NothingEvaluated {
    /// Why.
    pub reason: String,
}

/// A run is not as it was accepted; the verdict has been printed.
#[derive(Debug, thiserror::Error)]
#[error("the gate is closed: {}", .0.name())]
pub struct GateClosed(pub Conclusion);

/// The directory of a run lacks a file, or a file is damaged.
#[derive(Debug, thiserror::Error)]
#[error("the run {} cannot be read", .directory.display())]
pub struct DamagedRun {
    /// Where it lies.
    pub directory: PathBuf,
}

/// What was asked for makes no sense.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Does `work` and returns the exit code, having told stderr why if it is not 0.
///
/// A panic is an internal error; left alone it would end the program with 101, which means something else.
pub fn exit_code_of(work: impl FnOnce() -> anyhow::Result<()>) -> u8 {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => 0,
        Ok(Err(error)) => {
            print_error(format_args!("error: {error:#}"));
            match Failure::of(&error) {
                Failure::Interrupted => interruption_exit_code(),
                failure => failure as u8,
            }
        }
        // The panic has been reported where it happened.
        Err(_) => Failure::Internal as u8,
    }
}

impl Failure {
    /// What kind of ending `error` is.
    pub fn of(error: &anyhow::Error) -> Self {
        if error.is::<Usage>() {
            return Self::Usage;
        }
        let of_dataset = |error: &DatasetError| if error.is_usage_error() { Self::Usage } else { Self::Data };
        if let Some(error) = error.downcast_ref::<DatasetError>() {
            return of_dataset(error);
        }
        match error.downcast_ref::<RunError>() {
            Some(RunError::Dataset(error)) => return of_dataset(error),
            Some(RunError::Interrupted { .. }) => return Self::Interrupted,
            None => {}
        }
        match error.downcast_ref::<SurveyError>() {
            Some(SurveyError::Dataset(error)) => return of_dataset(error),
            Some(SurveyError::Interrupted { .. }) => return Self::Interrupted,
            None => {}
        }
        match error.downcast_ref::<ConversionError>() {
            Some(ConversionError::Dataset(error)) => return of_dataset(error),
            Some(
                ConversionError::Occupied { .. }
                | ConversionError::InUse { .. }
                | ConversionError::Unwritable { .. }
                | ConversionError::TooManyObjects { .. },
            ) => return Self::Usage,
            Some(_) | None => {}
        }
        if let Some(error) = error.downcast_ref::<SweepError>() {
            return match error {
                SweepError::Dataset(error) => of_dataset(error),
                SweepError::Journal(error) => Self::of_journal(error),
                SweepError::Threads { .. } => Self::Internal,
                SweepError::Interrupted { .. } | SweepError::InterruptedWhileTimed => Self::Interrupted,
            };
        }
        if let Some(error) = error.downcast_ref::<JournalError>() {
            return Self::of_journal(error);
        }
        if error.is::<single_scan::Interrupted>() {
            return Self::Interrupted;
        }
        if let Some(failure) = Self::of_comparison(error) {
            return failure;
        }
        if error.is::<NothingEvaluated>() {
            return Self::NothingEvaluated;
        }
        if error.is::<ConfigError>() || error.is::<DetectorListError>() || error.is::<SweepPlanError>() {
            return Self::Usage;
        }
        if let Some(error) = error.downcast_ref::<RunDirectoryError>() {
            return Self::of_run_directory(error);
        }
        if let Some(error) = error.downcast_ref::<ArchiveError>() {
            return Self::of_archive(error);
        }
        Self::of_stream(error)
    }

    /// `None` if `error` is none of comparing runs.
    fn of_comparison(error: &anyhow::Error) -> Option<Self> {
        if let Some(GateClosed(conclusion)) = error.downcast_ref::<GateClosed>() {
            return Some(Self::of_conclusion(*conclusion));
        }
        if error.is::<NotComparable>() {
            return Some(Self::NotComparable);
        }
        if let Some(error) = error.downcast_ref::<JudgeError>() {
            return Some(match error {
                JudgeError::NotComparable(_) => Self::NotComparable,
                JudgeError::Rules(_) => Self::Usage,
            });
        }
        if error.is::<DamagedRun>() {
            return Some(Self::Data);
        }
        if error.is::<TolerancesError>() {
            return Some(Self::Usage);
        }
        error.downcast_ref::<AcceptError>().map(|error| match error {
            AcceptError::Directory(error) => Self::of_run_directory(error),
            AcceptError::Archive(error) => Self::of_archive(error),
            AcceptError::History { .. } => Self::Data,
            AcceptError::Dirty { .. } => Self::Usage,
            AcceptError::NoSuccessor { .. } => Self::NotComparable,
        })
    }

    fn of_conclusion(conclusion: Conclusion) -> Self {
        match conclusion {
            Conclusion::Regression => Self::Regression,
            Conclusion::Incomparable => Self::NotComparable,
            Conclusion::Drift => Self::Drift,
            Conclusion::Same => unreachable!("a gate is not closed where all is the same"),
        }
    }

    fn of_run_directory(error: &RunDirectoryError) -> Self {
        match error {
            RunDirectoryError::NoName { .. }
            | RunDirectoryError::Occupied { .. }
            | RunDirectoryError::InUse { .. }
            | RunDirectoryError::NotARun { .. }
            | RunDirectoryError::LatestOccupied { .. } => Self::Usage,
            RunDirectoryError::Io { source, .. } => Self::of_writing(source.kind()),
            RunDirectoryError::Archive(error) => Self::of_archive(error),
        }
    }

    fn of_archive(error: &ArchiveError) -> Self {
        match error {
            ArchiveError::Write { source, .. } => Self::of_writing(source.kind()),
            _ => Self::Internal,
        }
    }

    fn of_journal(error: &JournalError) -> Self {
        match error {
            JournalError::Another { .. } | JournalError::NoJournal { .. } | JournalError::Locked { .. } => {
                Self::Usage
            }
            JournalError::Io { source, .. } => Self::of_writing(source.kind()),
        }
    }

    /// Whether the place to write to was badly chosen, or fails although it was not.
    fn of_writing(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::NotFound
            | ErrorKind::NotADirectory
            | ErrorKind::IsADirectory
            | ErrorKind::AlreadyExists
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::InvalidFilename => Self::Usage,
            _ => Self::Internal,
        }
    }

    #[cfg(feature = "rerun")]
    fn of_stream(error: &anyhow::Error) -> Self {
        use crate::stream::StreamError;
        match error.downcast_ref::<StreamError>() {
            Some(
                StreamError::BadUrl { .. }
                | StreamError::SwitchedOff
                | StreamError::ViewerNotInstalled { .. }
                | StreamError::ViewerFailed { .. },
            ) => Self::Usage,
            Some(StreamError::Create { source, .. }) => Self::of_writing(source.kind()),
            _ => Self::Internal,
        }
    }

    #[cfg(not(feature = "rerun"))]
    fn of_stream(_: &anyhow::Error) -> Self {
        Self::Internal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::side_by_side::RunError;

    #[track_caller]
    fn check(error: impl Into<anyhow::Error>, expected: Failure) {
        let error = error.into();
        assert_eq!(Failure::of(&error), expected, "{error:#}");
        assert_eq!(exit_code_of(|| Err(error)), expected as u8);
    }

    fn not_written(kind: ErrorKind) -> RunDirectoryError {
        RunDirectoryError::Io { path: "runs".into(), source: kind.into() }
    }

    #[test]
    fn a_full_disk_is_not_the_users_mistake_and_a_bad_place_is() {
        check(not_written(ErrorKind::StorageFull), Failure::Internal);
        check(not_written(ErrorKind::NotADirectory), Failure::Usage);
        let table = |kind: ErrorKind| ArchiveError::Write { path: "a.csv".into(), source: kind.into() };
        check(table(ErrorKind::StorageFull), Failure::Internal);
        check(RunDirectoryError::from(table(ErrorKind::PermissionDenied)), Failure::Usage);
    }

    #[test]
    fn data_that_are_missing_and_data_that_do_not_exist_differ() {
        let missing = || DatasetError::NoScans { path: "velodyne".into() };
        let unknown = || DatasetError::UnknownDataset { name: "kity".to_owned(), known: Vec::new() };
        check(missing(), Failure::Data);
        check(RunError::from(missing()), Failure::Data);
        check(unknown(), Failure::Usage);
        check(RunError::from(unknown()), Failure::Usage);
        check(SurveyError::from(missing()), Failure::Data);
        check(anyhow::Error::from(missing()).context(Usage("bad catalogue".to_owned())), Failure::Usage);
    }

    #[test]
    fn interrupted_and_empty_runs_have_codes_of_their_own() {
        check(RunError::Interrupted { n_done: 1, n_scans: 2 }, Failure::Interrupted);
        check(SurveyError::Interrupted { dataset: "street".to_owned(), n_scans: 2 }, Failure::Interrupted);
        check(single_scan::Interrupted { n_done: 1, n_repeats: 2 }, Failure::Interrupted);
        check(NothingEvaluated { reason: "no cars".to_owned() }, Failure::NothingEvaluated);
    }

    #[test]
    fn a_panic_is_an_internal_error() {
        assert_eq!(exit_code_of(|| panic!("on purpose")), 1);
        assert_eq!(exit_code_of(|| Ok(())), 0);
    }
}
