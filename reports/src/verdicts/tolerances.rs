//! How much worse a number may become before a gate fails.

use std::path::PathBuf;

use crate::verdicts::rule_problems::RuleProblem;
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::named::named;
use crate::vocabulary::slice::Slice;

/// The numbers that are gated, and how tightly.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    /// Where they come from.
    pub origin: Origin,
    /// Rules about what is deterministic; the first that is about a number decides.
    pub quality: Vec<Rule>,
    /// Rules about numbers under protocols of others; the first that is about a number decides.
    pub protocols: Vec<Rule>,
    /// Rules about rates as they stream; each decides by itself.
    pub streams: Vec<StreamRule>,
    /// The rule about times; without it they are not gated.
    pub speed: Option<Rule>,
    /// The rule about results that changed.
    pub drift: DriftRule,
    /// Problems of the file. A judge refuses it, together with the problems for the runs.
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
        /// It passes, and what changed is reported.
        Warn = "warn",
    }
}

/// How much worse some numbers may become.
///
/// Names of metrics under protocols of others and those of parts may end in `*`, and then stand for all that begin so.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Its line in the file; `None` if it stands in none.
    pub line: Option<usize>,
    /// Ids of the metrics. Of times it is that of the time over the time of the reference.
    pub metrics: Vec<String>,
    /// Names of slices, or of classes under a protocol.
    pub parts: Vec<String>,
    /// Names of tasks, or that of the protocol; all tasks, if left out.
    pub tasks: Option<Vec<String>>,
    /// Names of detectors; all, if left out.
    pub detectors: Option<Vec<String>>,
    /// In the unit of the metric; none of times.
    pub absolute: f64,
    /// As a share of the baseline's value.
    pub relative: f64,
}

/// How much worse rates may become as they stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamRule {
    /// The rule about the F-rate, or about recall where false detections are unknown.
    pub rule: Rule,
    /// What boxes are compared by.
    pub criterion: CriterionKind,
    /// How late answers are.
    pub lateness: Lateness,
}

/// How late the answers of both runs are taken to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lateness {
    /// Every detector takes this long for every scan, in milliseconds: the same on every machine.
    Fixed(f64),
    /// As measured, on the machine of the baseline: times of a later run are scaled to it, by how long the reference took in
    /// the baseline, divided by how long it took in that run.
    Measured,
}

impl StreamRule {
    /// The words behind the name of a task.
    pub fn in_words(&self) -> String {
        let criterion = self.criterion.name();
        match self.lateness {
            Lateness::Fixed(latency_ms) => format!("streaming by {criterion}, {latency_ms} ms late"),
            Lateness::Measured => format!("streaming by {criterion}, as late as measured"),
        }
    }
}

/// The subject of a number that may be gated.
#[derive(Debug, Clone, Copy)]
pub struct GatedSubject<'a> {
    /// Name of the task, or of the protocol.
    pub task: &'a str,
    /// Name of the detector.
    pub detector: &'a str,
    /// Name of the slice, or of the class.
    pub part: &'a str,
}

impl Tolerances {
    /// The file they come from.
    pub fn path(&self) -> Option<PathBuf> {
        match &self.origin {
            Origin::BuiltIn => None,
            Origin::File(path) => Some(path.clone()),
        }
    }

    /// Index of the rule that decides about `metric` of `subject`; `None` if it is not gated.
    pub fn rule_about(&self, metric: &Metric, subject: GatedSubject<'_>) -> Option<usize> {
        self.quality.iter().position(|rule| rule.is_about(&metric.id(), subject))
    }

    /// All metrics that some rule is about, in the order of a report.
    pub fn metrics(&self) -> Vec<Metric> {
        let ids = self.quality.iter().flat_map(|it| &it.metrics);
        let mut metrics: Vec<Metric> = ids.filter_map(|it| Metric::from_id(it)).collect();
        metrics.sort();
        metrics.dedup();
        metrics
    }
}

impl Rule {
    /// The rule about the times of all detectors, which may become longer by this share.
    pub(super) fn of_times(relative: f64) -> Self {
        let (metrics, parts) = (vec![Metric::TimeRatio.id()], vec![Slice::All.name()]);
        Self { line: None, metrics, parts, tasks: None, detectors: None, absolute: 0.0, relative }
    }

    /// A rule about the rates of all detectors and tasks as they stream, which may fall by this much.
    pub(super) fn of_streams(absolute: f64) -> Self {
        let metrics = [Metric::FRate, Metric::Recall].map(|it| it.id()).to_vec();
        let parts = vec![Slice::All.name()];
        Self { line: None, metrics, parts, tasks: None, detectors: None, absolute, relative: 0.0 }
    }

    /// A rule about a metric of all parts, which may become worse by this much in its unit.
    pub(super) fn of_all_parts(metric: &str, absolute: f64) -> Self {
        let (metrics, parts) = (vec![metric.to_owned()], vec!["*".to_owned()]);
        Self { line: None, metrics, parts, tasks: None, detectors: None, absolute, relative: 0.0 }
    }

    /// How much worse `metric` may become from `before`. Times are compared by the share by which they become longer.
    pub fn tolerance(&self, metric: &Metric, before: f64) -> f64 {
        if metric.is_time() { self.relative } else { self.absolute.max(self.relative * before.abs()) }
    }

    /// Whether it is about this metric of `subject`.
    pub fn is_about(&self, metric_id: &str, subject: GatedSubject<'_>) -> bool {
        self.metrics.iter().any(|it| names_meant(it, metric_id))
            && self.parts.iter().any(|it| names_meant(it, subject.part))
            && self.is_within(subject.task)
            && self.is_of_detector(subject.detector)
    }

    /// Whether it is about the detector of this name.
    pub fn is_of_detector(&self, detector: &str) -> bool {
        has(self.detectors.as_ref(), detector)
    }

    /// Whether it is about the task or protocol of this name.
    pub fn is_within(&self, task: &str) -> bool {
        has(self.tasks.as_ref(), task)
    }

    /// Whether it names the part and the task of `subject`, so that a number is expected there.
    pub fn names(&self, subject: GatedSubject<'_>) -> bool {
        self.parts.iter().any(|it| it == subject.part) && self.tasks.is_some() && self.is_within(subject.task)
    }
}

/// Whether `name` is one of `names`; all are if these are left out.
fn has(names: Option<&Vec<String>>, name: &str) -> bool {
    names.is_none_or(|it| it.iter().any(|it| it == name))
}

/// Whether `pattern` stands for `name`: it is its name, or a beginning of it and a `*`.
pub fn names_meant(pattern: &str, name: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == name, |beginning| name.starts_with(beginning))
}
