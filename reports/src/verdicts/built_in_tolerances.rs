//! Tolerances for a baseline that has none: for exactly the numbers that it has.

use std::collections::BTreeSet;

use serde::Deserialize;

use crate::numbers::tally::Tally;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::{ALL_CLASSES, ProtocolMetric};
use crate::protocols::protocol_tally::ProtocolQuestion;
use crate::rows::match_outcome::MatchOutcome;
use crate::rows::match_row::MatchRow;
use crate::run_folder::run_archive::RunArchive;
use crate::streaming::closeness::is_stream;
use crate::uncertainty::sample::{Draw, Question, Sample};
use crate::verdicts::tolerances::{DriftRule, Lateness, Origin, Rule, StreamRule, Tolerances, names_meant};
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::formula::Term;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

const SIZES: &str = include_str!("built_in_tolerances.toml");

/// The file for partly seen objects.
pub(super) const OF_OBJECTS: &str = include_str!("partial_tolerances.toml");

/// How much of each number is tolerated, and what it means.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sizes {
    pub(super) metric: Vec<MetricSize>,
    pub(super) negatives: NegativeSize,
    pub(super) slices: SliceSize,
    pub(super) protocols: ProtocolSize,
    pub(super) speed: SpeedSize,
}

/// For a metric of everything.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MetricSize {
    pub(super) id: String,
    pub(super) meaning: String,
    absolute: f64,
    relative: f64,
}

/// For a count where no annotation counts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NegativeSize {
    pub(super) metric: String,
    pub(super) meaning: String,
    absolute: f64,
    relative: f64,
}

/// For a metric of slices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SliceSize {
    metric: String,
    pub(super) meaning: String,
    patterns: Vec<String>,
    absolute: f64,
    relative: f64,
}

/// For the numbers of all classes together under a protocol of others.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProtocolSize {
    pub(super) meaning: String,
    metrics: Vec<String>,
    class_metrics: Vec<String>,
    absolute: f64,
    relative: f64,
}

/// For times.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpeedSize {
    pub(super) meaning: String,
    relative: f64,
}

impl Sizes {
    pub(super) fn built_in() -> Self {
        toml::from_str(SIZES).expect("the file is a part of the program and tested")
    }
}

impl Tolerances {
    /// The built-in tolerances for `baseline`: rules about every metric, task and detector that it has a number of, and
    /// about its times.
    pub fn built_in(baseline: &RunArchive) -> Self {
        if baseline.manifest.partial.is_some() {
            return Self::parse(OF_OBJECTS, Origin::BuiltIn)
                .expect("the file is a part of the program and tested");
        }
        let tally = baseline.tally();
        let numbers = Numbers { draws: tally.undrawn(), tally: &tally };
        let sizes = Sizes::built_in();
        let all = [Slice::All.name()];
        let of_metrics = sizes.metric.iter();
        let of_metrics =
            of_metrics.flat_map(|it| numbers.rules_about(&it.id, &all, [it.absolute, it.relative]));
        let SliceSize { metric, patterns, absolute, relative, .. } = &sizes.slices;
        let of_slices = numbers.rules_about(metric, patterns, [*absolute, *relative]);
        let quality =
            of_metrics.chain(numbers.rules_of_negatives(&sizes.negatives)).chain(of_slices).collect();
        let speed = numbers.speed_rule(sizes.speed.relative);
        let protocols = protocol_rules(baseline, &sizes.protocols);
        Self {
            origin: Origin::BuiltIn,
            quality,
            protocols,
            streams: stream_rules(baseline),
            speed,
            drift: DriftRule::Fail,
            problems: Vec::new(),
        }
    }
}

/// Rules where the baseline is a stream whose labels can be followed: for answers that are a tenth of a second late, and if all
/// detectors were timed for answers as late as measured.
fn stream_rules(baseline: &RunArchive) -> Vec<StreamRule> {
    let can_be_followed = |it: &MatchRow| match &it.outcome {
        MatchOutcome::Matched { annotation, .. } | MatchOutcome::Missed { annotation, .. } => {
            annotation.track.is_some() && annotation.bounding_box.is_some()
        }
        _ => false,
    };
    if !is_stream(&baseline.scans, baseline.manifest.drive_of())
        || !baseline.matches.iter().any(can_be_followed)
    {
        return Vec::new();
    }
    let is_timed = |name: &&str| {
        let mut of_it = baseline.scans.iter().filter(|it| it.detector == *name);
        of_it.any(|it| it.numbers().is_some_and(|it| it.latency_ms.is_some()))
    };
    let rule = |lateness, absolute| StreamRule {
        rule: Rule::of_streams(absolute),
        criterion: CriterionKind::Centre,
        lateness,
    };
    let are_all_timed = baseline.detector_names().iter().all(is_timed);
    let measured = are_all_timed.then(|| rule(Lateness::Measured, 0.02));
    [rule(Lateness::Fixed(100.0), 0.005)].into_iter().chain(measured).collect()
}

/// One rule for each protocol that the baseline was evaluated under, about those numbers that it has of all classes together,
/// or else of each annotated class.
fn protocol_rules(baseline: &RunArchive, size: &ProtocolSize) -> Vec<Rule> {
    let tally = baseline.tally();
    let names = tally.datasets().iter().flat_map(|it| DrawnScans::of(&tally, it).names().to_vec());
    let scans = DrawnScans::undrawn(names.collect());
    let rule = |protocol: Protocol| {
        let of_detectors = tally
            .detectors()
            .iter()
            .filter_map(|detector| baseline.protocols.rows(ProtocolQuestion { protocol, detector }, &scans));
        let known: Vec<ProtocolMetric> = of_detectors.flat_map(|it| it.metrics()).collect();
        let has_it = |id: &&String| known.iter().any(|it| it.class == ALL_CLASSES && it.id == **id);
        let of_all: Vec<String> = size.metrics.iter().filter(has_it).cloned().collect();
        let of_class = |it: &&ProtocolMetric| size.class_metrics.contains(&it.id) && it.n > 0;
        let classes: BTreeSet<String> = known.iter().filter(of_class).map(|it| it.class.clone()).collect();
        let (metrics, parts) = if of_all.is_empty() {
            (size.class_metrics.clone(), classes.into_iter().collect())
        } else {
            (of_all, vec![ALL_CLASSES.to_owned()])
        };
        (!parts.is_empty()).then(|| Rule {
            line: None,
            metrics,
            parts,
            tasks: Some(vec![protocol.name().to_owned()]),
            detectors: None,
            absolute: size.absolute,
            relative: size.relative,
        })
    };
    baseline.protocols.protocols().into_iter().filter_map(rule).collect()
}

/// The numbers of a run, without their intervals.
struct Numbers<'a> {
    tally: &'a Tally,
    draws: Vec<Draw>,
}

impl Numbers<'_> {
    fn has(&self, metric: &Metric, task: Task, detector: &str, slice: Slice) -> bool {
        let pools = self.tally.pools();
        pools.iter().any(|pool| {
            let question = Question { dataset: pool.extent.name(), task, detector, slice };
            // Rates say nothing where no annotation counts.
            let says = |it: &Sample| !metric.is_ratio() || it.total.of(Term::Annotations) > 0.0;
            self.tally
                .sample(&question, &self.draws)
                .is_some_and(|it| it.value(metric).is_some() && says(&it))
        })
    }

    /// The detectors that have `metric` in `task`, for a slice that `pattern` stands for.
    fn detectors(&self, metric: &Metric, task: Task, pattern: &str) -> Vec<String> {
        let has_it = |detector: &&String| {
            let slices = self.tally.slices(task, detector).into_iter();
            let mut slices = slices.filter(|it| names_meant(pattern, &it.name()));
            slices.any(|it| self.has(metric, task, detector, it))
        };
        self.tally.detectors().iter().filter(has_it).cloned().collect()
    }

    /// Rules about a metric of the slices that `patterns` stand for: one rule for all tasks and patterns that have the
    /// metric for the same detectors.
    fn rules_about(&self, id: &str, patterns: &[String], [absolute, relative]: [f64; 2]) -> Vec<Rule> {
        let metric = Metric::from_id(id).expect("the file is a part of the program and tested");
        let of_task = |task: Task| {
            let of_pattern = |it: &String| (it.clone(), self.detectors(&metric, task, it));
            let kinds = patterns.iter().map(of_pattern).filter(|(_, detectors)| !detectors.is_empty());
            (task, kinds.collect::<Vec<_>>())
        };
        let of_tasks: Vec<_> = self.tally.tasks().iter().map(|it| of_task(*it)).collect();
        let alike = of_tasks.chunk_by(|a, b| a.1 == b.1);
        let rules = alike.flat_map(|tasks| {
            tasks[0].1.chunk_by(|a, b| a.1 == b.1).map(|kinds| Rule {
                line: None,
                metrics: vec![id.to_owned()],
                parts: kinds.iter().map(|(pattern, _)| pattern.clone()).collect(),
                tasks: Some(tasks.iter().map(|(task, _)| task.name().to_owned()).collect()),
                detectors: Some(kinds[0].1.clone()),
                absolute,
                relative,
            })
        });
        rules.collect()
    }

    /// Rules about false detections, in the tasks in which no annotation counts.
    fn rules_of_negatives(&self, size: &NegativeSize) -> Vec<Rule> {
        let all = Slice::All.name();
        let rules =
            self.rules_about(&size.metric, std::slice::from_ref(&all), [size.absolute, size.relative]);
        let is_negative = |task: &String| {
            let task = self.tally.tasks().iter().find(|it| it.name() == task);
            task.is_some_and(|it| self.detectors(&Metric::Recall, *it, &all).is_empty())
        };
        let only_negative = |rule: Rule| {
            let tasks: Vec<String> = rule.tasks.into_iter().flatten().filter(is_negative).collect();
            (!tasks.is_empty()).then_some(Rule { tasks: Some(tasks), ..rule })
        };
        rules.into_iter().filter_map(only_negative).collect()
    }

    /// The rule about the times of the detectors that were timed; `None` if none was.
    fn speed_rule(&self, relative: f64) -> Option<Rule> {
        // Every task has the same times.
        let timed = self.detectors(&Metric::TimeRatio, *self.tally.tasks().first()?, "all");
        (!timed.is_empty()).then(|| Rule { detectors: Some(timed), ..Rule::of_times(relative) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ratio_has_a_size() {
        let sizes = Sizes::built_in();
        let mut known: Vec<Metric> = sizes.metric.iter().filter_map(|it| Metric::from_id(&it.id)).collect();
        known.sort();
        let ratios: Vec<Metric> = Metric::of_sums().filter(Metric::is_ratio).collect();
        assert_eq!(known, ratios);
        assert!(ratios.iter().any(|it| it.id() == sizes.slices.metric));
    }
}
