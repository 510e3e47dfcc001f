//! Numbers of a run held to tolerances, one by one.

use std::collections::BTreeSet;

use crate::numbers::tally::Tally;
use crate::uncertainty::sample::{Draw, Question, Sample};
use crate::verdicts::finding::Finding;
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::verdicts::rule_problems::{RulePlace, RuleProblem, RuleProblems, RuleTable};
use crate::verdicts::suggestion::did_you_mean;
use crate::verdicts::tolerances::{GatedPlace, QualityRule, Tolerances, is_meant, names_meant};
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
    /// What was measured.
    pub metric: Metric,
    /// Place of the rule that decides about it, among those of its kind.
    pub rule_idx: usize,
    /// Before and after, or where there is no number.
    pub difference: Result<PairedDifference, Missing>,
    /// How much worse it may become.
    pub tolerance: f64,
    /// What that means.
    pub finding: Finding,
}

impl GatedMetric {
    /// What it is about: the task, and the data sets if there are others.
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
}

/// A baseline and a run that is judged by it, of the same scans.
pub(super) struct Sides<'a> {
    pub(super) before: &'a Tally,
    pub(super) after: &'a Tally,
    pub(super) draws: &'a [Draw],
}

impl Sides<'_> {
    /// Every number that `tolerances` are about, task by task, detector by detector, slice by slice: over all recorded data sets together,
    /// and over all simulated ones.
    ///
    /// # Errors
    ///
    /// [`RuleProblems`] with all that is wrong: what the file has, names that there are not, rules that decide about nothing.
    pub(super) fn gated_metrics(&self, tolerances: &Tolerances) -> Result<Vec<GatedMetric>, RuleProblems> {
        let slices = self.slices();
        let mut problems = tolerances.problems.clone();
        problems.extend(self.unknown_names(tolerances, &slices));
        let metrics = tolerances.metrics();
        let mut gated = Vec::new();
        for (dataset, on) in self.judged() {
            for &task in self.before.tasks() {
                for detector in self.before.detectors() {
                    for &slice in &slices {
                        let place = GatedPlace { task, detector, slice };
                        let wanted =
                            metrics.iter().filter_map(|it| Some((it, tolerances.rule_about(it, place)?)));
                        let wanted: Vec<(&Metric, usize)> = wanted.collect();
                        if !wanted.is_empty() {
                            let samples =
                                self.samples(&Question { dataset: &dataset, task, detector, slice });
                            let of_metric = |(metric, rule_idx)| {
                                let rule = (rule_idx, &tolerances.quality[rule_idx]);
                                let gated = gated_metric(metric, place, &samples, rule)?;
                                Some(GatedMetric { on: on.clone(), ..gated })
                            };
                            gated.extend(wanted.into_iter().filter_map(of_metric));
                        }
                    }
                }
            }
        }
        let gated = without_gaps(gated);
        problems.extend(void_rules(tolerances, &gated, &problems));
        RuleProblems::check(tolerances.path(), problems)?;
        Ok(gated)
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

    /// Names of the data sets that are judged together, and again if there are others.
    pub(super) fn judged(&self) -> Vec<(String, Option<String>)> {
        judged(self.before)
    }

    fn samples(&self, question: &Question<'_>) -> [Option<Sample>; 2] {
        [self.before, self.after].map(|it| it.sample(question, self.draws))
    }

    /// Names of the rules that neither side knows.
    fn unknown_names(&self, tolerances: &Tolerances, slices: &BTreeSet<Slice>) -> Vec<RuleProblem> {
        let sides = || [self.before, self.after].into_iter();
        let tasks: BTreeSet<String> = sides().flat_map(Tally::tasks).map(|it| it.name().to_owned()).collect();
        let detectors: BTreeSet<String> = sides().flat_map(Tally::detectors).cloned().collect();
        let slice_names: Vec<String> = slices.iter().map(Slice::name).collect();
        let mut problems = Vec::new();
        let mut complain = |place: RulePlace, what: &str, name: &str, suggestion: String| {
            let what = format!("there is no {what} {name:?} in either run{suggestion}");
            problems.push(RuleProblem { place, what });
        };
        for (rule_idx, rule) in tolerances.quality.iter().enumerate() {
            let of_tasks = rule.tasks.iter().flatten().map(|it| ("task", it.name(), &tasks));
            let of_detectors =
                rule.detectors.iter().flatten().map(|it| ("detector", it.as_str(), &detectors));
            for (what, name, known) in
                of_tasks.chain(of_detectors).filter(|(_, name, known)| !known.contains(*name))
            {
                complain(rule.place(rule_idx), what, name, did_you_mean(name, known.iter()));
            }
            for pattern in rule.slices.iter().filter(|it| !slices.iter().any(|slice| is_meant(it, *slice))) {
                complain(rule.place(rule_idx), "slice", pattern, did_you_mean(pattern, slice_names.iter()));
            }
        }
        if let Some(rule) = &tolerances.speed {
            let place = RulePlace { line: rule.line, table: RuleTable::Speed };
            for name in rule.detectors.iter().flatten().filter(|it| !detectors.contains(*it)) {
                complain(place.clone(), "detector", name, did_you_mean(name, detectors.iter()));
            }
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

/// Without those that neither side has on some data sets, but on others: false objects may be known of simulated ones alone.
fn without_gaps(gated: Vec<GatedMetric>) -> Vec<GatedMetric> {
    let is_gap = |it: &GatedMetric| it.difference == Err(Missing::InBoth);
    let key = |it: &GatedMetric| (it.task.clone(), it.detector.clone(), it.slice.clone(), it.metric.clone());
    let known: BTreeSet<_> = gated.iter().filter(|it| !is_gap(it)).map(key).collect();
    gated.into_iter().filter(|it| !is_gap(it) || !known.contains(&key(it))).collect()
}

/// Metrics and slices of rules that no number was held to: of no slice is the metric measured, or an earlier rule decides. Rules
/// with `known` problems are left out, because those are why.
fn void_rules(tolerances: &Tolerances, gated: &[GatedMetric], known: &[RuleProblem]) -> Vec<RuleProblem> {
    let mut problems = Vec::new();
    for (rule_idx, rule) in tolerances.quality.iter().enumerate() {
        if known.iter().any(|it| it.place.table == RuleTable::Quality(rule_idx)) {
            continue;
        }
        for metric in &rule.metrics {
            for pattern in &rule.slices {
                let is_held = |it: &&GatedMetric| {
                    it.metric == *metric && names_meant(pattern, &it.slice) && it.rule_idx == rule_idx
                };
                if !gated.iter().any(|it| is_held(&it)) {
                    let what = format!(
                        "the rule has no effect on {} of {pattern:?}: neither run has it, or an earlier rule applies",
                        metric.id()
                    );
                    problems.push(RuleProblem { place: rule.place(rule_idx), what });
                }
            }
        }
    }
    problems
}

/// `None` if neither side has the number and the rule does not name it.
fn gated_metric(
    metric: &Metric,
    place: GatedPlace<'_>,
    [before, after]: &[Option<Sample>; 2],
    (rule_idx, rule): (usize, &QualityRule),
) -> Option<GatedMetric> {
    let [value_before, value_after] = [before, after].map(|it| it.as_ref().and_then(|it| it.value(metric)));
    let difference = match (value_before, value_after) {
        (Some(_), None) => Err(Missing::InRun),
        (None, Some(_)) => Err(Missing::InBaseline),
        (None, None) if rule.names(place) => Err(Missing::InBoth),
        (None, None) => return None,
        (Some(_), Some(_)) => {
            paired_difference(before.as_ref()?, after.as_ref()?, metric).ok_or(Missing::InBoth)
        }
    };
    let tolerance = rule.tolerance(value_before.unwrap_or(0.0));
    let finding = difference
        .as_ref()
        .map_or(Finding::Incomparable, |it| Finding::of(it.worsening(), it.sure_worsening(), tolerance));
    let GatedPlace { task, detector, slice } = place;
    let (task, detector, slice) = (task.name().to_owned(), detector.to_owned(), slice.name());
    let metric = metric.clone();
    Some(GatedMetric { on: None, task, detector, slice, metric, rule_idx, difference, tolerance, finding })
}
