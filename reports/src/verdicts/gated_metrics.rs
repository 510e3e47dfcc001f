//! Numbers of a run held to tolerances, one by one.

use std::collections::BTreeSet;

use crate::numbers::tally::Tally;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::finding::Finding;
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::verdicts::rule_problems::{RulePosition, RuleProblem, RuleProblems, RuleTable};
use crate::verdicts::suggestion::did_you_mean;
use crate::verdicts::tolerances::{GatedSubject, Rule, Tolerances, names_meant};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::named::named;
use crate::vocabulary::slice::Slice;

/// A number that is gated.
#[derive(Debug, Clone, PartialEq)]
pub struct GatedMetric {
    /// Name of the data sets that it is about, where recorded and simulated ones are judged apart.
    pub on: Option<String>,
    /// Name of the task, or of the protocol.
    pub task: String,
    /// Name of the detector.
    pub detector: String,
    /// Name of the slice, or of the class under a protocol.
    pub slice: String,
    /// The metric.
    pub metric: Metric,
    /// Index of the rule that decides about it, among those of its kind.
    pub rule_idx: usize,
    /// The numbers before and after, or where one is missing.
    pub difference: Result<PairedDifference, Missing>,
    /// How much worse it may become.
    pub tolerance: f64,
    /// The meaning of the difference.
    pub finding: Finding,
}

impl GatedMetric {
    /// A number of this subject, on these data sets if there are others, held to the rule of this index, which tolerates so
    /// much.
    pub(super) fn new(
        subject: GatedSubject<'_>,
        on: Option<&str>,
        metric: &Metric,
        difference: Result<PairedDifference, Missing>,
        rule_idx: usize,
        tolerance: f64,
    ) -> Self {
        let finding = difference
            .as_ref()
            .map_or(Finding::Incomparable, |it| Finding::of(it.worsening(), it.sure_worsening(), tolerance));
        let [task, detector, slice] = [subject.task, subject.detector, subject.part].map(str::to_owned);
        let (on, metric) = (on.map(str::to_owned), metric.clone());
        Self { on, task, detector, slice, metric, rule_idx, difference, tolerance, finding }
    }

    /// Its task, and its data sets if there are others.
    pub fn about(&self) -> String {
        about(&self.task, self.on.as_deref())
    }
}

/// `what`, and on which data sets if there are others.
pub(crate) fn about(what: &str, on: Option<&str>) -> String {
    on.map_or_else(|| what.to_owned(), |it| format!("{what} on {it}"))
}

named! {
    /// Where a number is missing.
    pub enum Missing {
        /// In the baseline, but not in the run.
        InBaseline = "baseline",
        /// In the run, but not in the baseline.
        InRun = "run",
        /// In both, although a rule names it.
        InBoth = "both",
    }
}

impl Missing {
    /// Where, in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::InBaseline => "missing in the baseline",
            Self::InRun => "missing in the run",
            Self::InBoth => "missing in the baseline and in the run",
        }
    }

    /// Where a number is missing, by whether it is in the baseline and in the run.
    pub(super) fn of(is_there: [bool; 2]) -> Self {
        match is_there {
            [true, _] => Self::InRun,
            [false, true] => Self::InBaseline,
            [false, false] => Self::InBoth,
        }
    }
}

/// A baseline and a run that is judged by it, of the same scans.
pub(super) struct Sides<'a> {
    pub(super) before: &'a Tally,
    pub(super) after: &'a Tally,
    pub(super) draws: &'a [Draw],
}

impl Sides<'_> {
    /// Every number that `tolerances` are about, task by task, detector by detector, slice by slice: over all recorded data
    /// sets together, and over all simulated ones.
    ///
    /// # Errors
    ///
    /// [`RuleProblems`] with all that is wrong: problems of the file, unknown names, rules that decide about nothing.
    pub(super) fn gated_metrics(&self, tolerances: &Tolerances) -> Result<Vec<GatedMetric>, RuleProblems> {
        let slices = self.slices();
        let mut problems = tolerances.problems.clone();
        problems.extend(self.unknown_names(tolerances, &slices));
        let metrics = tolerances.metrics();
        let mut gated = Vec::new();
        for (dataset, on) in judged(self.before) {
            for &task in self.before.tasks() {
                for detector in self.before.detectors() {
                    for &slice in &slices {
                        let question = Question { dataset: &dataset, task, detector, slice };
                        gated.extend(self.held(&tolerances.quality, &metrics, &question, on.as_deref()));
                    }
                }
            }
        }
        let gated = without_gaps(gated);
        // A rule that has a problem has no effect for that reason.
        let is_sound =
            |it: &RuleProblem| problems.iter().all(|known| known.position.table != it.position.table);
        let void = void_rules(&tolerances.quality, RuleTable::Quality, &gated, str::to_owned);
        let void: Vec<RuleProblem> = void.into_iter().filter(is_sound).collect();
        problems.extend(void);
        RuleProblems::check(tolerances.path(), problems)?;
        Ok(gated)
    }

    /// How long every detector of the baseline that `rule` is about takes beside the reference.
    pub(super) fn gated_speeds(&self, rule: &Rule) -> Vec<GatedMetric> {
        let mut gated = Vec::new();
        // Every task has the same times.
        let Some(&task) = self.before.tasks().first() else { return gated };
        for (dataset, on) in judged(self.before) {
            for detector in self.before.detectors() {
                let question = Question { dataset: &dataset, task, detector, slice: Slice::All };
                let rules = std::slice::from_ref(rule);
                gated.extend(self.held(rules, &[Metric::TimeRatio], &question, on.as_deref()));
            }
        }
        gated
    }

    /// The numbers of one subject for those `metrics` that `rules` are about; a number that neither side has is left out
    /// unless its rule names it.
    pub(super) fn held(
        &self,
        rules: &[Rule],
        metrics: &[Metric],
        question: &Question<'_>,
        on: Option<&str>,
    ) -> Vec<GatedMetric> {
        let part = question.slice.name();
        let subject = GatedSubject { task: question.task.name(), detector: question.detector, part: &part };
        let rule_about = |metric: &Metric| rules.iter().position(|it| it.is_about(&metric.id(), subject));
        let wanted = metrics.iter().filter_map(|it| Some((it, rule_about(it)?)));
        let wanted: Vec<(&Metric, usize)> = wanted.collect();
        if wanted.is_empty() {
            return Vec::new();
        }
        let sides = [self.before, self.after].map(|it| it.sample(question, self.draws));
        let of_metric = |(metric, rule_idx): (&Metric, usize)| {
            let rule = &rules[rule_idx];
            let values = sides.each_ref().map(|it| it.as_ref().and_then(|it| it.value(metric)));
            let is_expected = metric.is_time() || rule.names(subject);
            if values == [None, None] && !is_expected {
                return None;
            }
            let both = sides[0].as_ref().zip(sides[1].as_ref());
            let difference = both.and_then(|(before, after)| paired_difference(before, after, metric));
            let difference = difference.ok_or_else(|| Missing::of(values.map(|it| it.is_some())));
            let tolerance = rule.tolerance(metric, values[0].unwrap_or(0.0));
            Some(GatedMetric::new(subject, on, metric, difference, rule_idx, tolerance))
        };
        wanted.into_iter().filter_map(of_metric).collect()
    }

    /// All slices of both sides, in the order of a report.
    fn slices(&self) -> BTreeSet<Slice> {
        let mut slices = BTreeSet::new();
        for tally in [self.before, self.after] {
            for &task in tally.tasks() {
                slices.extend(tally.detectors().iter().flat_map(|detector| tally.slices(task, detector)));
            }
        }
        slices
    }

    /// Names in the rules that neither side knows.
    fn unknown_names(&self, tolerances: &Tolerances, slices: &BTreeSet<Slice>) -> Vec<RuleProblem> {
        let sides = || [self.before, self.after].into_iter();
        let tasks: BTreeSet<String> = sides().flat_map(Tally::tasks).map(|it| it.name().to_owned()).collect();
        let detectors: BTreeSet<String> = sides().flat_map(Tally::detectors).cloned().collect();
        let slices: Vec<String> = slices.iter().map(Slice::name).collect();
        let mut problems = Vec::new();
        let mut check = |rule: &Rule, table: RuleTable| {
            let mut complain = |what: &str, name: &str, suggestion: String| {
                let what = format!("there is no {what} {name:?} in either run{suggestion}");
                problems.push(RuleProblem { position: RulePosition { line: rule.line, table }, what });
            };
            for (what, names, known) in
                [("task", &rule.tasks, &tasks), ("detector", &rule.detectors, &detectors)]
            {
                for name in names.iter().flatten().filter(|it| !known.contains(*it)) {
                    complain(what, name, did_you_mean(name, known.iter()));
                }
            }
            for pattern in rule.parts.iter().filter(|it| !slices.iter().any(|slice| names_meant(it, slice))) {
                complain("slice", pattern, did_you_mean(pattern, slices.iter()));
            }
        };
        for (rule_idx, rule) in tolerances.quality.iter().enumerate() {
            check(rule, RuleTable::Quality(rule_idx));
        }
        if let Some(rule) = &tolerances.speed {
            check(rule, RuleTable::Speed);
        }
        problems
    }
}

/// Names of the data sets of `tally` that are judged together, and again if there are others.
pub(crate) fn judged(tally: &Tally) -> Vec<(String, Option<String>)> {
    let pools = tally.pools();
    let names = pools.iter().map(|it| it.extent.name().to_owned());
    names.map(|it| (it.clone(), (pools.len() > 1).then_some(it))).collect()
}

/// Drops gaps of numbers that are known on other data sets: false objects may be known of simulated ones alone.
fn without_gaps(gated: Vec<GatedMetric>) -> Vec<GatedMetric> {
    let is_gap = |it: &GatedMetric| it.difference == Err(Missing::InBoth);
    let key = |it: &GatedMetric| (it.task.clone(), it.detector.clone(), it.slice.clone(), it.metric.clone());
    let known: BTreeSet<_> = gated.iter().filter(|it| !is_gap(it)).map(key).collect();
    gated.into_iter().filter(|it| !is_gap(it) || !known.contains(&key(it))).collect()
}

/// Metrics and parts of `rules` that no number of `gated` was held to: the metric is measured of no such part, or an earlier
/// rule decides.
pub(super) fn void_rules(
    rules: &[Rule],
    table: fn(usize) -> RuleTable,
    gated: &[GatedMetric],
    named: impl Fn(&str) -> String,
) -> Vec<RuleProblem> {
    let mut problems = Vec::new();
    for (rule_idx, rule) in rules.iter().enumerate() {
        let of_rule = || gated.iter().filter(|it| it.rule_idx == rule_idx);
        for metric in &rule.metrics {
            for part in &rule.parts {
                let is_held =
                    |it: &GatedMetric| names_meant(metric, &it.metric.id()) && names_meant(part, &it.slice);
                if !of_rule().any(is_held) {
                    let what = format!(
                        "the rule has no effect on {} of {part:?}: neither run has it, or an earlier rule applies",
                        named(metric)
                    );
                    let position = RulePosition { line: rule.line, table: table(rule_idx) };
                    problems.push(RuleProblem { position, what });
                }
            }
        }
    }
    problems
}
