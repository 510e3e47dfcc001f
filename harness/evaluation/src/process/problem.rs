//! Problems of a foreign detector.

use std::fmt;
use std::time::Duration;

use reports::files::shown_text::{shown, shown_lines};

/// The problem.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectorProblem {
    /// It ended, crashed, or closed the pipe.
    #[error("it {0}")]
    Ended(Ending),
    /// It did not answer in time.
    #[error("it gave no whole answer to {to} within {} s ({})", .limit.as_secs_f64(), limit_name(to))]
    Silent {
        /// Name of the message that was not answered.
        to: &'static str,
        /// The time limit.
        limit: Duration,
    },
    /// It does not take messages.
    #[error("it does not read messages")]
    Deaf,
    /// It answered `error`.
    #[error("it reports an error: {0}")]
    Reported(String),
    /// It breaks the protocol.
    #[error("its answer is wrong: {0}")]
    WrongAnswer(String),
    /// Its results, which it left in files, cannot be read.
    #[error("its results cannot be read: {0}")]
    Unreadable(String),
    /// Its results need information that the user has not given, such as the meaning of a class name.
    #[error("its results cannot be used: {0}")]
    Unusable(String),
    /// It cannot be asked: the machine prevents it, or the data lack what it asks for.
    #[error("{0}")]
    Machine(String),
    /// The user has interrupted the run before it could be asked.
    #[error("the run was interrupted")]
    Interrupted,
}

/// Name of the time limit of the message `to` in a configuration.
fn limit_name(to: &str) -> &'static str {
    if to == "scan" { "time_limit_s, or a minute for the first scan" } else { "start_limit_s" }
}

/// How a program ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// By itself.
    Exit(i32),
    /// By a signal.
    Signal(i32),
    /// It could not be started, for this reason.
    NeverBegan(String),
    /// Its pipe is closed; nothing else is known.
    ClosedPipe,
}

impl fmt::Display for Ending {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exit(code) => write!(formatter, "ended with exit code {code}"),
            Self::Signal(signal) => write!(formatter, "was ended by signal {signal}"),
            Self::NeverBegan(reason) => write!(formatter, "cannot be started: {reason}"),
            Self::ClosedPipe => formatter.write_str("closed its pipe"),
        }
    }
}

/// A problem of a detector at a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetectorFailure {
    /// Name of the detector.
    pub detector: String,
    /// The scan it was asked for; `None` before the first.
    pub scan: Option<String>,
    /// The problem.
    pub problem: DetectorProblem,
    /// The last lines that it printed.
    pub last_words: Vec<String>,
    /// Whether it must not be asked for further scans.
    pub is_final: bool,
}

impl std::error::Error for DetectorFailure {}

impl fmt::Display for DetectorFailure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "the detector {:?} failed", self.detector)?;
        if let Some(scan) = &self.scan {
            write!(formatter, " at scan {scan}")?;
        }
        let problem = self.problem.to_string();
        let problem = match &self.problem {
            // Lines of our own, in which the words of others are quoted.
            DetectorProblem::Unusable(_) => shown_lines(&problem),
            _ => shown(&problem),
        };
        write!(formatter, ": {problem}")?;
        if !self.last_words.is_empty() {
            formatter.write_str("\nlast lines that it printed:")?;
        }
        self.last_words.iter().try_for_each(|it| write!(formatter, "\n  {}", shown(it)))?;
        if self.last_words.iter().any(|it| it.contains("No module named 'scanbench'")) {
            formatter.write_str("\nThe Python that it runs in lacks the package: pip install ./harness/python in a checkout of scanbench, or a wheel of it")?;
        }
        Ok(())
    }
}
