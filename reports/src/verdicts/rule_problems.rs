//! Problems of tolerances: all of them at once, and each once.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;

/// A problem of a file of tolerances.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct RuleProblem {
    /// The part of the file that has it.
    pub position: RulePosition,
    /// The problem, in words.
    pub what: String,
}

/// A part of a file of tolerances.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct RulePosition {
    /// Line of the file, from 1 on; `None` of rules that stand in no file.
    pub line: Option<usize>,
    /// The table.
    pub table: RuleTable,
}

/// A table of a file of tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RuleTable {
    /// None: the part outside of the known tables.
    Top,
    /// A rule about quality, by its index among them.
    Quality(usize),
    /// A rule about a protocol of others, by its index among them.
    Protocol(usize),
    /// A rule about rates as they stream, by its index among them.
    Streaming(usize),
    /// The rule about times.
    Speed,
}

impl fmt::Display for RuleProblem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.position.line.map(|it| format!("line {it}"));
        let table = match self.position.table {
            RuleTable::Top => None,
            RuleTable::Quality(rule_idx) => Some(format!("[[quality]] {}", rule_idx + 1)),
            RuleTable::Protocol(rule_idx) => Some(format!("[[protocol]] {}", rule_idx + 1)),
            RuleTable::Streaming(rule_idx) => Some(format!("[[streaming]] {}", rule_idx + 1)),
            RuleTable::Speed => Some("[speed]".to_owned()),
        };
        let position: Vec<String> = line.into_iter().chain(table).collect();
        write!(formatter, "{}: {}", position.join(", "), self.what)
    }
}

/// All problems of tolerances.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct RuleProblems {
    /// The file; `None` of rules that stand in no file.
    pub path: Option<PathBuf>,
    /// The problems, one or more.
    pub problems: Vec<RuleProblem>,
}

impl RuleProblems {
    /// Fails with all of `problems`, if any, in the order of the file, each once.
    ///
    /// # Errors
    ///
    /// The problems, if there are any.
    pub(super) fn check(
        path: Option<PathBuf>,
        problems: impl IntoIterator<Item = RuleProblem>,
    ) -> Result<(), Self> {
        let mut seen = BTreeSet::new();
        let mut problems: Vec<RuleProblem> =
            problems.into_iter().filter(|it| seen.insert((it.position.table, it.what.clone()))).collect();
        problems.sort_by_key(|it| (it.position.table, it.position.line));
        if problems.is_empty() { Ok(()) } else { Err(Self { path, problems }) }
    }
}

impl fmt::Display for RuleProblems {
    /// One problem stands in the line; several have a line each.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("bad tolerances")?;
        if let Some(path) = &self.path {
            write!(formatter, " {path:?}")?;
        }
        match self.problems.as_slice() {
            [only] => write!(formatter, ": {only}"),
            several => {
                write!(formatter, ", {} problems:", several.len())?;
                several.iter().try_for_each(|it| write!(formatter, "\n  {it}"))
            }
        }
    }
}
