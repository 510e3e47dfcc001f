//! Whether a run is as good as the one that was accepted.

use std::collections::{BTreeMap, BTreeSet};

use crate::numbers::blocks::{BlockCount, Interval};
use crate::numbers::tally::Tally;
use crate::rows::scan_row::ScanOutcome;
use crate::run_folder::run_archive::RunArchive;
use crate::uncertainty::sample::Draw;
use crate::verdicts::change::{ChangeKind, n_of_kinds};
use crate::verdicts::changed_claims::{ChangedClaim, changed_claims};
use crate::verdicts::comparability::{
    NotComparable, check_comparable, configuration_changes, detectors_only_in,
};
use crate::verdicts::drift::{ScanDrift, drift};
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{GatedMetric, Sides};
use crate::verdicts::gated_objects::gated_objects;
use crate::verdicts::gated_protocols::gated_protocols;
use crate::verdicts::gated_streams::{StreamPair, gated_streams};
use crate::verdicts::partial_differences::CurveName;
use crate::verdicts::rule_problems::RuleProblems;
use crate::verdicts::tolerances::{DriftRule, Tolerances};
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::named::named;
use crate::vocabulary::task::Task;

/// How often the whole 95 % interval of a difference lies on the worse side of the truth.
const FALSE_ALARM_RISK: f64 = 0.025;

/// The result of a gate.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The data set of the numbers by its id, or [`OVERALL`] of several.
    pub dataset: String,
    /// The detectors of the baseline.
    pub detectors: Vec<String>,
    /// Number of scans.
    pub n_scans: usize,
    /// Their name: partial clouds of objects stand for scans in results of `partial`.
    pub unit: &'static str,
    /// The blocks of scans that intervals were drawn from.
    pub blocks: BlockCount,
    /// Everything that is gated, task by task, detector by detector, slice by slice.
    pub metrics: Vec<GatedMetric>,
    /// How long detectors take, divided by how long the reference takes on the same scans: the geometric mean over scans.
    pub speeds: Vec<GatedMetric>,
    /// Why times were not compared, where a rule is about them.
    pub speed_not_compared: Option<String>,
    /// Claims of the papers whose verdict changed.
    pub claims: Vec<ChangedClaim>,
    /// Scans on which results of a detector changed.
    pub drift: Vec<ScanDrift>,
    /// Doubts about the later run's data sets and detectors, those that its user overruled, and what is wrong with the history, a
    /// sentence each.
    pub doubts: Vec<String>,
    /// Changes in the configuration of detectors, a text each.
    pub configuration_changes: Vec<String>,
    /// Detectors that only the later run has.
    pub new_detectors: Vec<String>,
    /// What became of the numbers since an earlier run of the history, if one was named.
    pub since: Option<SinceEarlier>,
    /// The tolerances that it was judged by.
    pub tolerances: Tolerances,
}

/// What became of the numbers since an earlier run of the history.
#[derive(Debug, Clone, PartialEq)]
pub struct SinceEarlier {
    /// How many are worse than tolerated.
    pub n_worse: usize,
    /// What became of them: a sentence, and a line for each that is worse.
    pub lines: Vec<String>,
}

named! {
    /// What a verdict comes to.
    pub enum Conclusion {
        /// Something is surely worse.
        Regression = "regression",
        /// Something that is gated has no number.
        Incomparable = "incomparable",
        /// Something is worse than in the earlier run of the history.
        WorseSince = "worse-since",
        /// Nothing is surely worse, but results changed.
        Drift = "drift",
        /// The same, and that is allowed.
        AllowedDrift = "allowed-drift",
        /// Everything is as it was.
        Same = "same",
    }
}

/// Why there is no verdict.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// The runs cannot be compared.
    #[error(transparent)]
    NotComparable(#[from] NotComparable),
    /// The tolerances are not about these runs.
    #[error(transparent)]
    Rules(#[from] RuleProblems),
}

impl Conclusion {
    /// The conclusion where nothing is surely worse.
    pub fn without_loss(is_changed: bool, drift: DriftRule) -> Self {
        match drift {
            _ if !is_changed => Self::Same,
            DriftRule::Fail => Self::Drift,
            DriftRule::Warn => Self::AllowedDrift,
        }
    }

    /// The words that people read.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Regression => "FAILED: worse",
            Self::Incomparable => "FAILED: numbers are missing",
            Self::WorseSince => "FAILED: worse than an earlier run of the history",
            Self::Drift => "FAILED: results changed",
            Self::AllowedDrift => "PASSED, results changed",
            Self::Same => "PASSED",
        }
    }

    /// Whether the run is good enough.
    pub fn is_pass(self) -> bool {
        match self {
            Self::Regression | Self::Incomparable | Self::WorseSince | Self::Drift => false,
            Self::AllowedDrift | Self::Same => true,
        }
    }
}

impl Verdict {
    /// The conclusion.
    pub fn conclusion(&self) -> Conclusion {
        if self.n(Finding::Regression) > 0 || self.claims.iter().any(ChangedClaim::is_worse) {
            Conclusion::Regression
        } else if self.n(Finding::Incomparable) > 0 {
            Conclusion::Incomparable
        } else if self.since.as_ref().is_some_and(|it| it.n_worse > 0) {
            Conclusion::WorseSince
        } else {
            Conclusion::without_loss(!self.drift.is_empty(), self.tolerances.drift)
        }
    }

    /// The data sets of the numbers, for people.
    pub fn dataset_in_words(&self) -> &str {
        match self.dataset.as_str() {
            OVERALL if self.metrics.iter().any(|it| it.on.is_some()) => {
                "recorded and simulated data sets apart"
            }
            OVERALL => "all data sets together",
            id => id,
        }
    }

    /// Number of scans on which results changed, of whatever detector and task.
    pub fn n_changed_scans(&self) -> usize {
        let scans = self.drift.iter().map(|it| (&it.subject.dataset, &it.subject.sequence, it.subject.scan));
        scans.collect::<BTreeSet<_>>().len()
    }

    /// Number of changed results of each kind that occurs, each detector and task counted, the worst kind first.
    pub fn n_changes(&self) -> BTreeMap<ChangeKind, usize> {
        n_of_kinds(self.drift.iter().flat_map(|it| &it.changes))
    }

    /// Everything that is gated, times last.
    pub fn numbers(&self) -> impl Iterator<Item = &GatedMetric> {
        self.metrics.iter().chain(&self.speeds)
    }

    /// Number of numbers and claims that are worse than tolerated, whether or not that may be chance. Times differ in every
    /// run: they count only where it is none.
    pub fn n_worse(&self) -> usize {
        let n_claims = self.claims.iter().filter(|it| it.is_worse()).count();
        self.n(Finding::Regression) + self.n_unsure() + n_claims
    }

    /// How many of these may be worse by chance.
    pub fn n_unsure(&self) -> usize {
        self.numbers().filter(|it| it.finding == Finding::Inconclusive && !it.metric.is_time()).count()
    }

    /// Number of numbers that changed, so that they may look surely worse by chance; 0 if nothing can be sure. A number that
    /// is the same on every scan is no matter of chance.
    pub fn n_at_risk(&self) -> usize {
        if self.blocks.decide_nothing() {
            return 0;
        }
        let varies = |interval: Option<Interval>| interval.is_some_and(|it| it.ends != [0.0; 2]);
        self.numbers().filter(|it| it.difference.as_ref().is_ok_and(|it| varies(it.interval))).count()
    }

    /// How many of these would be called worse by chance on average, if each were in truth just as much worse as tolerated:
    /// the most that can be expected.
    pub fn most_false_alarms(&self) -> f64 {
        FALSE_ALARM_RISK * self.n_at_risk() as f64
    }

    /// Number of gated numbers with this finding.
    pub fn n(&self, finding: Finding) -> usize {
        self.numbers().filter(|it| it.finding == finding).count()
    }
}

/// Judges `run` by `baseline`.
///
/// ```
/// use std::path::Path;
///
/// use reports::run_folder::run_archive::RunArchive;
/// use reports::tables::formats::format::Format as _;
/// use reports::tables::formats::markdown::Markdown;
/// use reports::verdicts::tolerances::Tolerances;
/// use reports::verdicts::verdict::{Conclusion, judge};
///
/// let accepted = RunArchive::read(Path::new("golden/run"))?;
/// let tolerances = Tolerances::read(Path::new("golden/tolerances.toml"))?;
/// let verdict = judge(&accepted, &accepted, &tolerances)?;
/// assert_eq!(verdict.conclusion(), Conclusion::Same);
/// assert!(Markdown.text(&verdict).starts_with("**PASSED"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`JudgeError`] if the runs cannot be compared, or with all problems of `tolerances`: those of their file, names that
/// neither run has, rules that decide about nothing.
pub fn judge(
    baseline: &RunArchive,
    run: &RunArchive,
    tolerances: &Tolerances,
) -> Result<Verdict, JudgeError> {
    judge_with_streams(baseline, run, tolerances, &[])
}

/// [`judge`] with the moments of both runs for each rule about streams.
///
/// # Errors
///
/// As [`judge`].
pub fn judge_with_streams(
    baseline: &RunArchive,
    run: &RunArchive,
    tolerances: &Tolerances,
    streams: &[StreamPair],
) -> Result<Verdict, JudgeError> {
    let comparable = check_comparable(baseline, run);
    if comparable.is_err() {
        RuleProblems::check(tolerances.path(), tolerances.problems.clone())?;
    }
    comparable?;
    verdict(baseline, run, tolerances, streams)
}

fn verdict(
    baseline: &RunArchive,
    run: &RunArchive,
    tolerances: &Tolerances,
    streams: &[StreamPair],
) -> Result<Verdict, JudgeError> {
    let (before, after) = (baseline.tally(), run.tally());
    let draws = before.draw();
    let sides = Sides { before: &before, after: &after, draws: &draws };
    let (metrics, blocks) = if baseline.manifest.partial.is_some() {
        gated_objects([baseline, run], tolerances)?
    } else {
        let mut metrics = sides.gated_metrics(tolerances)?;
        metrics.extend(gated_protocols(&before, [&baseline.protocols, &run.protocols], tolerances)?);
        metrics.extend(gated_streams(streams, tolerances)?);
        (metrics, draws.iter().map(Draw::blocks).reduce(BlockCount::with))
    };
    let nothing_run = || NotComparable { reasons: vec!["the baseline has no scans".to_owned()] };
    let rule = tolerances.speed.as_ref();
    // Ratios of times are those of a processor.
    let [old, new] = [baseline, run].map(|it| &it.manifest.machine.cpu_model);
    let speed_not_compared = rule.filter(|_| old != new);
    let speed_not_compared =
        speed_not_compared.map(|_| format!("the processor changed from {old:?} to {new:?}"));
    let speeds = rule.filter(|_| old == new).map_or_else(Vec::new, |it| sides.gated_speeds(it));
    let (detectors, n_scans) = judged(baseline, &before);
    let mut doubts = run.manifest.doubts_in_words();
    doubts.extend(failures_in_words(run));
    doubts.extend(classes_without_rule([&before, &after], &metrics));
    Ok(Verdict {
        dataset: dataset(baseline, &before),
        detectors,
        n_scans,
        unit: baseline.manifest.unit(),
        blocks: blocks.ok_or_else(nothing_run)?,
        metrics,
        speeds,
        speed_not_compared,
        claims: changed_claims(&baseline.claims, &run.claims),
        drift: drift(baseline, run),
        doubts,
        configuration_changes: configuration_changes(baseline, run),
        new_detectors: detectors_only_in(run, baseline),
        since: None,
        tolerances: tolerances.clone(),
    })
}

/// How often each detector of `run` failed, a sentence each: its objects are lost there, whatever it would have found.
fn failures_in_words(run: &RunArchive) -> Vec<String> {
    let mut of_detectors: BTreeMap<&str, [BTreeSet<_>; 2]> = BTreeMap::new();
    for row in &run.scans {
        let [failed, all] = of_detectors.entry(&row.detector).or_default();
        let scan = (row.dataset.as_str(), row.sequence.as_str(), row.scan);
        all.insert(scan);
        if matches!(&row.outcome, ScanOutcome::Evaluated(numbers) if numbers.failure.is_some()) {
            failed.insert(scan);
        }
    }
    let of_failing = of_detectors.into_iter().filter(|(_, [failed, _])| !failed.is_empty());
    of_failing
        .map(|(name, [failed, all])| format!("{name} failed on {} of {} scans.", failed.len(), all.len()))
        .collect()
}

/// Classes that the later run gives falsely more or less often than the earlier one, and that no number of `gated` is about.
fn classes_without_rule([before, after]: [&Tally; 2], gated: &[GatedMetric]) -> Vec<String> {
    let n_false = |tally: &Tally, task: Task, detector: &str| {
        let of_pools = tally.pools().into_iter();
        let of_pools = of_pools.filter_map(|it| tally.counts(it.extent.name(), task, detector)?.fo());
        of_pools.sum::<u64>()
    };
    let mut sentences = Vec::new();
    for task in after.tasks().iter().copied().filter(|it| it.class().is_some()) {
        for detector in before.detectors() {
            let is_gated = gated.iter().any(|it| it.task == task.name() && it.detector == *detector);
            let [old, new] = [before, after].map(|it| n_false(it, task, detector));
            if !is_gated && old != new {
                sentences.push(format!(
                    "No rule is about the class {task}, which {detector} gives falsely {new} times, and gave {old} times."
                ));
            }
        }
    }
    sentences
}

/// The data sets of the numbers of `run`.
fn dataset(run: &RunArchive, tally: &Tally) -> String {
    match (&run.manifest.partial, &tally.pools()[..]) {
        (Some(_), _) => run.manifest.selected().into_iter().map(|it| it.0).collect::<Vec<_>>().join(", "),
        (None, [only]) => only.extent.name().to_owned(),
        (None, _) => OVERALL.to_owned(),
    }
}

/// The detectors of `run`, and the number of scans that any of them looked at.
fn judged(run: &RunArchive, tally: &Tally) -> (Vec<String>, usize) {
    let mut scans: BTreeSet<(String, &str, u32)> = BTreeSet::new();
    scans.extend(run.scans.iter().map(|it| (it.dataset.clone(), it.sequence.as_str(), it.scan)));
    let mut detectors = tally.detectors().to_vec();
    for row in &run.objects {
        let curve = CurveName::of(row);
        scans.insert((curve.on(), row.object.as_str(), row.step));
        let detector = curve.detector();
        if !detectors.contains(&detector) {
            detectors.push(detector);
        }
    }
    (detectors, scans.len())
}

#[cfg(test)]
mod tests;
