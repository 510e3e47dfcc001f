//! How much worse a number may become before a gate closes.

use std::path::PathBuf;

use crate::verdicts::rule_problems::{RulePlace, RuleProblem, RuleTable};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::named::named;
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// What is gated, and how tightly.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    /// Where they come from.
    pub origin: Origin,
    /// Rules about what is deterministic; the first that is about a number decides.
    pub quality: Vec<QualityRule>,
    /// Rules about numbers under protocols of others; the first that is about a number decides.
    pub protocols: Vec<ProtocolRule>,
    /// The rule about times; without it they are not gated.
    pub speed: Option<SpeedRule>,
    /// The rule about results that changed.
    pub drift: DriftRule,
    /// What is wrong with the file. A judge refuses it, together with what is wrong for the runs.
    pub problems: Vec<RuleProblem>,
}

/// Where tolerances come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// From the program, made for the baseline.
    BuiltIn,
    /// From this file.
    File(PathBuf),
}

named! {
    /// What becomes of a run whose results changed though no number is surely worse.
    pub enum DriftRule {
        /// It fails: somebody has to look at it, and accept it.
        Fail = "fail",
        /// It passes, and what changed is told.
        Warn = "warn",
    }
}

/// How much worse some metrics may become.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityRule {
    /// Its line in the file; `None` if it stands in none.
    pub line: Option<usize>,
    /// The metrics.
    pub metrics: Vec<Metric>,
    /// Names of slices; a name that ends in `*` stands for all that begin so.
    pub slices: Vec<String>,
    /// The tasks; all, if left out.
    pub tasks: Option<Vec<Task>>,
    /// Names of detectors; all, if left out.
    pub detectors: Option<Vec<String>>,
    /// In the unit of the metric.
    pub absolute: f64,
    /// As a share of the baseline's value.
    pub relative: f64,
}

/// How much worse some numbers under a protocol of others may become.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolRule {
    /// Its line in the file; `None` if it stands in none.
    pub line: Option<usize>,
    /// The protocol.
    pub protocol: Protocol,
    /// Names of metrics; a name that ends in `*` stands for all that begin so.
    pub metrics: Vec<String>,
    /// Names of classes, in the same way.
    pub classes: Vec<String>,
    /// Names of detectors; all, if left out.
    pub detectors: Option<Vec<String>>,
    /// In the unit of the metric.
    pub absolute: f64,
    /// As a share of the baseline's value.
    pub relative: f64,
}

/// How much slower detectors may become, beside the reference that is timed in turns with them.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedRule {
    /// Its line in the file; `None` if it stands in none.
    pub line: Option<usize>,
    /// What times are divided by: [`SPEED_REFERENCE`](crate::vocabulary::metric::SPEED_REFERENCE).
    pub reference: String,
    /// Of which detectors; of all if left out.
    pub detectors: Option<Vec<String>>,
    /// As a share of the baseline's ratio.
    pub relative: f64,
}

/// What a number is of that may be gated.
#[derive(Debug, Clone, Copy)]
pub struct GatedPlace<'a> {
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: &'a str,
    /// The slice.
    pub slice: Slice,
}

impl Tolerances {
    /// The file they come from.
    pub fn path(&self) -> Option<PathBuf> {
        match &self.origin {
            Origin::BuiltIn => None,
            Origin::File(path) => Some(path.clone()),
        }
    }

    /// Place of the rule that decides about `metric` of `place`; `None` if it is not gated.
    pub fn rule_about(&self, metric: &Metric, place: GatedPlace<'_>) -> Option<usize> {
        self.quality.iter().position(|rule| rule.metrics.contains(metric) && rule.is_about(place))
    }

    /// All metrics that some rule is about, in the order of a report.
    pub fn metrics(&self) -> Vec<Metric> {
        let mut metrics: Vec<Metric> = self.quality.iter().flat_map(|it| &it.metrics).cloned().collect();
        metrics.sort();
        metrics.dedup();
        metrics
    }
}

impl QualityRule {
    /// Where it stands, as rule number `rule_idx`.
    pub(super) fn place(&self, rule_idx: usize) -> RulePlace {
        RulePlace { line: self.line, table: RuleTable::Quality(rule_idx) }
    }

    /// How much worse a number may become from `before`.
    pub fn tolerance(&self, before: f64) -> f64 {
        self.absolute.max(self.relative * before.abs())
    }

    /// Whether it is about numbers of `place`.
    pub fn is_about(&self, place: GatedPlace<'_>) -> bool {
        self.slices.iter().any(|it| is_meant(it, place.slice))
            && self.tasks.as_ref().is_none_or(|it| it.contains(&place.task))
            && self.detectors.as_ref().is_none_or(|it| it.iter().any(|it| it == place.detector))
    }

    /// Whether it names the slice and the task of `place`, so that a number is expected there.
    pub fn names(&self, place: GatedPlace<'_>) -> bool {
        let slice = place.slice.name();
        self.slices.contains(&slice) && self.tasks.as_ref().is_some_and(|it| it.contains(&place.task))
    }
}

impl ProtocolRule {
    /// Where it stands, as rule number `rule_idx`.
    pub(super) fn place(&self, rule_idx: usize) -> RulePlace {
        RulePlace { line: self.line, table: RuleTable::Protocol(rule_idx) }
    }

    /// How much worse a number may become from `before`.
    pub fn tolerance(&self, before: f64) -> f64 {
        self.absolute.max(self.relative * before.abs())
    }

    /// Whether it is about this metric of this class.
    pub fn is_about(&self, (protocol, detector): (Protocol, &str), class: &str, metric: &str) -> bool {
        self.protocol == protocol
            && self.metrics.iter().any(|it| names_meant(it, metric))
            && self.classes.iter().any(|it| names_meant(it, class))
            && self.detectors.as_ref().is_none_or(|it| it.iter().any(|name| name == detector))
    }
}

impl SpeedRule {
    /// Whether the times of `detector` are held to this.
    pub fn is_about(&self, detector: &str) -> bool {
        self.detectors.as_ref().is_none_or(|it| it.iter().any(|name| name == detector))
    }
}

/// Whether `pattern` stands for `slice`: it is its name, or a beginning of it and a `*`.
pub fn is_meant(pattern: &str, slice: Slice) -> bool {
    names_meant(pattern, &slice.name())
}

/// Whether `pattern` stands for `name`.
pub fn names_meant(pattern: &str, name: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == name, |beginning| name.starts_with(beginning))
}
