//! How the program ends when something is wrong.
//!
//! Every error that a verb can meet is turned into a [`Failure`] by `?`. There is no way for errors of any kind: a new one
//! does not compile until it is said here what kind of ending it is.

use std::error::Error;
use std::fmt;
use std::io::ErrorKind;
use std::path::Path;

use evaluation::journal::JournalError;
use evaluation::process::problem::{DetectorFailure, DetectorProblem};
use evaluation::protocols::chosen_protocols::ProtocolError;
use evaluation::run::ablation::AblationError;
use evaluation::run::config::ConfigError;
use evaluation::run::detector_list::DetectorListError;
use evaluation::run::foreign_files::ForeignFileError;
use evaluation::run::side_by_side::RunError;
use evaluation::run::single_scan::SingleScanError;
use evaluation::scan_pass::ScanPassError;
use evaluation::sweep::quality_pass::SweepError;
use evaluation::sweep::sweep_plan::SweepPlanError;
use reports::files::archive::ArchiveError;
use reports::files::causes::with_causes;
use reports::history::since::SinceError;
use reports::numbers::run_report::RunReportError;
use reports::run_folder::run_target::RunDirectoryError;
use reports::run_folder::shard_check::ShardMismatch;
use reports::tables::task_table::TableError;
use reports::verdicts::accept::AcceptError;
use reports::verdicts::comparability::NotComparable;
use reports::verdicts::tolerances_file::TolerancesError;
use reports::verdicts::verdict::{Conclusion, JudgeError};
use scans::conversion::ConversionError;
use scans::dataset::DatasetError;

/// The reason of a failure: an error with all that caused it.
pub type Reason = Box<dyn Error + Send + Sync>;

/// Expected endings, with their documented exit codes.
#[derive(Debug)]
pub enum Failure {
    /// 1: a bug.
    Internal(Reason),
    /// 2: wrong usage or configuration.
    Usage(Reason),
    /// 3: data missing or damaged.
    Data(Reason),
    /// 4: nothing was evaluated.
    NothingEvaluated(Reason),
    /// 5: two runs that cannot be compared.
    NotComparable(Reason),
    /// 6: a detector that is not built in failed.
    Detector(Reason),
    /// 7: results that the machine does not take, such as a full disk.
    Unwritten(Reason),
    /// 100: surely worse than the baseline.
    Regression(Reason),
    /// 101: not surely worse than the baseline, but results changed.
    Drift(Reason),
    /// 130, what shells report for Ctrl-C; 143 after a request to terminate.
    Interrupted(Reason),
}

#[derive(Debug, thiserror::Error)]
#[error("nothing was evaluated: {reason}")]
pub struct NothingEvaluated {
    pub reason: String,
}

/// A run is not as it was accepted; the verdict has been printed.
#[derive(Debug, thiserror::Error)]
#[error("gate {}", .0.in_words())]
pub struct GateClosed(pub Conclusion);

impl From<SinceError> for Failure {
    fn from(error: SinceError) -> Self {
        match error {
            SinceError::Unknown { .. } => Usage(format!("--since: {error}")).into(),
            SinceError::NotComparable { .. } => Self::NotComparable(error.into()),
        }
    }
}

/// A run that is to be accepted is worse than the one before; the verdict has been printed.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} worse than tolerated, compared with the accepted run{}; --worse accepts the run all the same",
    if *n_worse == 1 { "1 number is".to_owned() } else { format!("{n_worse} numbers are") },
    match n_worse - n_sure {
        0 => String::new(),
        n => format!(" ({n_sure} surely, {n} inconclusive)"),
    }
)]
pub struct WorseThanAccepted {
    /// How many numbers are worse than tolerated.
    pub n_worse: usize,
    /// How many of them surely, as `gate` judges.
    pub n_sure: usize,
}

/// A request that makes no sense.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// A problem in words, and its cause.
#[derive(Debug, thiserror::Error)]
#[error("{what}")]
struct Because {
    what: String,
    source: Reason,
}

impl Failure {
    /// `what` could not be done because of `reason`.
    pub fn internal(what: &str, reason: impl Into<Reason>) -> Self {
        Self::Internal(Because { what: what.to_owned(), source: reason.into() }.into())
    }

    /// `what` was badly chosen because of `reason`.
    pub fn usage(what: String, reason: impl Into<Reason>) -> Self {
        Self::Usage(Because { what, source: reason.into() }.into())
    }

    /// The directory of a run lacks a file, or a file is damaged.
    pub fn damaged_run(directory: &Path, reason: impl Into<Reason>) -> Self {
        let what = format!("the run {} cannot be read", directory.display());
        Self::Data(Because { what, source: reason.into() }.into())
    }

    /// A path that cannot be written: a wrong choice of the user, or a failure of the machine.
    pub fn of_writing(kind: ErrorKind, reason: impl Into<Reason>) -> Self {
        match kind {
            ErrorKind::NotFound
            | ErrorKind::NotADirectory
            | ErrorKind::IsADirectory
            | ErrorKind::AlreadyExists
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::InvalidFilename => Self::Usage(reason.into()),
            _ => Self::Unwritten(reason.into()),
        }
    }

    /// `what` could not be written because of `reason`.
    pub fn unwritten(what: &str, reason: impl Into<Reason>) -> Self {
        Self::Unwritten(Because { what: what.to_owned(), source: reason.into() }.into())
    }

    pub fn reason(&self) -> &(dyn Error + 'static) {
        match self {
            Self::Internal(reason)
            | Self::Usage(reason)
            | Self::Data(reason)
            | Self::NothingEvaluated(reason)
            | Self::NotComparable(reason)
            | Self::Detector(reason)
            | Self::Unwritten(reason)
            | Self::Regression(reason)
            | Self::Drift(reason)
            | Self::Interrupted(reason) => &**reason,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&with_causes(self.reason()))
    }
}

/// Errors that always end the program in the same way.
macro_rules! endings {
    ($($ending:ident: $($error:ty),+;)+) => {$($(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::$ending(error.into())
            }
        }
    )+)+};
}

endings! {
    // Rows of a file that does not exist yet come from this program.
    Internal: TableError, RunReportError, csv::Error;
    Usage: Usage, AblationError, ConfigError, DetectorListError, ForeignFileError, SweepPlanError,
        TolerancesError;
    NothingEvaluated: NothingEvaluated;
    NotComparable: NotComparable, ShardMismatch;
    Regression: WorseThanAccepted;
}

impl From<DetectorFailure> for Failure {
    fn from(error: DetectorFailure) -> Self {
        match error.problem {
            // Files are data, whether they are found to be damaged before the run or within it.
            DetectorProblem::Unreadable(_) => Self::Data(error.into()),
            DetectorProblem::Unusable(_) => Self::Usage(error.into()),
            DetectorProblem::Ended(_)
            | DetectorProblem::Silent { .. }
            | DetectorProblem::Deaf
            | DetectorProblem::Reported(_)
            | DetectorProblem::WrongAnswer(_)
            | DetectorProblem::Interrupted
            | DetectorProblem::Machine(_) => Self::Detector(error.into()),
        }
    }
}

impl From<DatasetError> for Failure {
    fn from(error: DatasetError) -> Self {
        if error.is_usage_error() { Self::Usage(error.into()) } else { Self::Data(error.into()) }
    }
}

impl From<ConversionError> for Failure {
    fn from(error: ConversionError) -> Self {
        match error {
            ConversionError::Dataset(error) => error.into(),
            ConversionError::Archive(error) => error.into(),
            ConversionError::Write { ref source, .. } => Self::of_writing(source.kind(), error),
            ConversionError::Recording { .. } => Self::Unwritten(error.into()),
            ConversionError::Occupied { .. }
            | ConversionError::InUse { .. }
            | ConversionError::Unwritable { .. }
            | ConversionError::TooManyObjects { .. } => Self::Usage(error.into()),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Dataset(error) => error.into(),
            RunError::Detector(error) => error.into(),
            RunError::Interrupted { .. } => Self::Interrupted(error.into()),
        }
    }
}

impl From<ScanPassError> for Failure {
    fn from(error: ScanPassError) -> Self {
        match error {
            ScanPassError::Dataset(error) => error.into(),
            ScanPassError::Interrupted { .. } => Self::Interrupted(error.into()),
        }
    }
}

impl From<SingleScanError> for Failure {
    fn from(error: SingleScanError) -> Self {
        match error {
            SingleScanError::Interrupted { .. } => Self::Interrupted(error.into()),
            SingleScanError::Detector(error) => error.into(),
        }
    }
}

impl From<ProtocolError> for Failure {
    fn from(error: ProtocolError) -> Self {
        match error {
            ProtocolError::Dataset(error) => error.into(),
            ProtocolError::Lacks { .. } | ProtocolError::NoLabels { .. } => Self::Usage(error.into()),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Dataset(error) => error.into(),
            SweepError::Scans(error) => error.into(),
            SweepError::Protocol(error) => error.into(),
            SweepError::Detector(error) => error.into(),
            SweepError::Journal(error) => error.into(),
            SweepError::Threads { .. } => Self::Internal(error.into()),
            SweepError::Interrupted { .. } | SweepError::InterruptedWhileTimed => {
                Self::Interrupted(error.into())
            }
        }
    }
}

impl From<JournalError> for Failure {
    fn from(error: JournalError) -> Self {
        match &error {
            JournalError::Another { .. } | JournalError::NoJournal { .. } | JournalError::Locked { .. } => {
                Self::Usage(error.into())
            }
            JournalError::Io { source, .. } => Self::of_writing(source.kind(), error),
        }
    }
}

impl From<RunDirectoryError> for Failure {
    fn from(error: RunDirectoryError) -> Self {
        match error {
            RunDirectoryError::NoName { .. }
            | RunDirectoryError::Occupied { .. }
            | RunDirectoryError::InUse { .. }
            | RunDirectoryError::NotARun { .. }
            | RunDirectoryError::LatestOccupied { .. } => Self::Usage(error.into()),
            RunDirectoryError::Io { ref source, .. } => Self::of_writing(source.kind(), error),
            RunDirectoryError::Archive(error) => error.into(),
        }
    }
}

impl From<ArchiveError> for Failure {
    fn from(error: ArchiveError) -> Self {
        match &error {
            ArchiveError::Write { source, .. } => Self::of_writing(source.kind(), error),
            // A run can read the files that it has just written: an error is a bug.
            ArchiveError::Read { .. }
            | ArchiveError::Schema { .. }
            | ArchiveError::Json { .. }
            | ArchiveError::Csv { .. }
            | ArchiveError::Contradiction { .. }
            | ArchiveError::Columns { .. } => Self::Internal(error.into()),
        }
    }
}

impl From<GateClosed> for Failure {
    fn from(error: GateClosed) -> Self {
        match error.0 {
            Conclusion::Regression | Conclusion::WorseSince => Self::Regression(error.into()),
            Conclusion::Incomparable => Self::NotComparable(error.into()),
            Conclusion::Drift => Self::Drift(error.into()),
            Conclusion::AllowedDrift | Conclusion::Same => unreachable!("a run that passes is no failure"),
        }
    }
}

impl From<JudgeError> for Failure {
    fn from(error: JudgeError) -> Self {
        match error {
            JudgeError::NotComparable(_) => Self::NotComparable(error.into()),
            JudgeError::Rules(_) => Self::Usage(error.into()),
        }
    }
}

impl From<AcceptError> for Failure {
    fn from(error: AcceptError) -> Self {
        match error {
            AcceptError::Directory(error) => error.into(),
            AcceptError::Archive(error) => error.into(),
            AcceptError::History { .. } => Self::Data(error.into()),
            AcceptError::Dirty { .. } => Self::Usage(error.into()),
            AcceptError::NoSuccessor { .. } => Self::NotComparable(error.into()),
        }
    }
}
